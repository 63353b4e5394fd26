#pragma once

#include <vector>

#include "renderer/accel/octree_builder.h"
#include "renderer/accel/tree_accelerator.h"

namespace tessera {

enum class OctreeKind {
  uniform,           ///< voxels split at their centre
  nonuniform,        ///< where SweepSearch finds the study's function least
  nonuniform_nlopt,  ///< where NLopt does; throws a usage Error where its module is not installed
};

/// What the accelerators below build with; `search` must outlive the build.
OctreeOptions mesh_octree_options(const SplitSearch* search);
OctreeOptions instance_octree_options(const SplitSearch* search);

/// Octree over the triangles of a mesh, which it does not need afterwards: see build_octree().
class MeshOctree final : public MeshTreeAccelerator {
 public:
  /// At least one triangle, all of them finite.
  MeshOctree(const TriangleMesh& mesh, OctreeKind kind, int threads,
             const BvhKernels& code = kernels());
};

/// The same over instances: at least one that can_be_held().
class InstanceOctree final : public InstanceTreeAccelerator {
 public:
  InstanceOctree(std::vector<Instance> instances, OctreeKind kind, int threads,
                 const BvhKernels& code = kernels());
};

}  // namespace tessera
