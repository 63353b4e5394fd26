#pragma once

#include <vector>

#include "renderer/accel/tree_accelerator.h"

namespace tessera {

/// Bounding volume hierarchy over the triangles of a mesh, which it does not need afterwards.
class MeshBvh final : public MeshTreeAccelerator {
 public:
  /// At least one triangle, all of them finite.
  MeshBvh(const TriangleMesh& mesh, int threads, const BvhKernels& code = kernels(),
          BvhQuality quality = BvhQuality::standard)
      : MeshBvh(build_mesh_tree(mesh, threads, quality), code) {}
  explicit MeshBvh(BuiltMeshTree built, const BvhKernels& code = kernels())
      : MeshTreeAccelerator(std::move(built), code) {}
};

/// The same over instances: at least one that can_be_held().
class InstanceBvh final : public InstanceTreeAccelerator {
 public:
  InstanceBvh(std::vector<Instance> instances, int threads, const BvhKernels& code = kernels());
};

}  // namespace tessera
