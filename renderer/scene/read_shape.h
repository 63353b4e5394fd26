#pragma once

#include <memory>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/accel/accelerator.h"
#include "renderer/accel/bvh_kernels.h"
#include "renderer/accel/deferred_mesh.h"
#include "renderer/scene/check.h"
#include "renderer/scene/csg_plan.h"
#include "renderer/shapes/shape.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// What of a mesh some material of its shape looks at.
struct KeptAttributes {
  bool normals = false, uvs = false, second_uvs = false, tangents = false;
  bool colors = false;  ///< else they are kept where some alpha is not 1
};

struct ShapeSource {
  const BlobStore& blobs;
  AcceleratorKind accelerator;
  int threads;
  KeptAttributes keep{};
  std::shared_ptr<DeferredBuilds> deferred{};  ///< where set, trees are built when first needed
  Sharing sharing{};                           ///< of trees
  const BvhKernels* code = &kernels();         ///< of the trees
};

/// A built shape, and what building it left out.
struct BuiltShape {
  std::shared_ptr<const Shape> shape;  ///< null where nothing is left of it
  bool is_deferred = false;            ///< its tree is built by the first ray that comes near
  size_t triangles = 0;
  size_t triangles_dropped = 0;                ///< degenerate ones
  size_t bytes = 0;                            ///< of the arrays of its meshes
  size_t bytes_dropped = 0;                    ///< of arrays that the picture does not depend on
  size_t attributes_dropped = 0;               ///< how many these are
  std::shared_ptr<const TriangleMesh> mesh{};  ///< what a shape that is a mesh is made of
  bool has_clear_vertices = false;             ///< some vertex colour lets light through
};

/// Checks the shape's numbers, sizes, counts and indices before anything is allocated for them, and
/// builds it. Throws a scene error that begins with `where`.
BuiltShape read_shape(const Where& where, const v1::Shape& shape, const ShapeSource& source);

/// The same of a CSG shape. Its materials are those of its solids, one after the other.
BuiltShape read_csg(const CsgPlan& plan, const ShapeSource& source);

/// How many materials a shape that is no CSG takes: one where it names none.
inline int material_count(const v1::Shape& shape) {
  return shape.materials_size() > 0 ? shape.materials_size() : 1;
}

}  // namespace tessera
