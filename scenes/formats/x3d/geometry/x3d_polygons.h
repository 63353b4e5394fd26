#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/math/transform.h"
#include "scenes/formats/x3d/document/x3d_values.h"

namespace tessera {

/// What a polygon node becomes: a mesh, and what its shape's material has to know.
struct X3dMesh {
  v1::TriangleMesh mesh;
  bool has_colors = false;
  bool has_color_alpha = false;  ///< which takes the place of the material's transparency
  bool empty = false;            ///< no face that could be seen
};

/// Whether nodes of that type become meshes.
bool is_x3d_mesh(std::string_view type);
/// Whether they are lines or points, which no light falls on.
bool is_x3d_lines(std::string_view type);

/// How wide lines and points are: so that they look alike wide wherever they are, seen from one
/// camera. Lengths are the camera's, in whose frame it looks along -z.
struct X3dPen {
  Affine camera_from_node{};
  double width = 0;            ///< at the camera, and everywhere where it has no perspective
  double width_per_depth = 0;  ///< what is added a length along the view

  /// Half of it.
  double radius(const Vec3& point) const;
  /// 0 at the camera, below 0 behind it.
  double depth(const Vec3& point) const;
};

/// The nodes with polygons, grids, extrusions, text, lines and points.
struct X3dMeshOptions {
  bool linear = false;    ///< vertex colours are decoded from sRGB
  double weld = 0;        ///< points this near are one to made normals, in the node's units
  bool textured = false;  ///< texture coordinates are made where the node has none
  X3dPen pen{};           ///< of lines and points
};
/// Throws scene_error naming the node and the face.
X3dMesh build_x3d_mesh(const X3dNode& node, const X3dValues& values, const X3dMeshOptions& options,
                       BlobStore& blobs);

}  // namespace tessera
