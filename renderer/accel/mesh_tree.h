#pragma once

#include "base/weak_cache.h"
#include "renderer/accel/accelerator.h"
#include "renderer/accel/bvh_kernels.h"

namespace tessera {

/// See spatial_splits.h. The hits are the same.
enum class BvhQuality { standard, spatial_splits };

struct BuiltMeshTree {
  MeshTree tree;
  AcceleratorStatistics statistics;
};

/// At least one triangle, all of them finite.
BuiltMeshTree build_mesh_tree(const TriangleMesh& mesh, int threads, BvhQuality quality);

/// Where trees are shared, and what this one is called there.
struct SharedTree : Sharing {
  Digest key;  ///< of all that the mesh is made from, and of the kind of accelerator
};

/// Below this a build takes no longer than to wait for another's.
inline constexpr size_t kTrianglesWorthSharing = 4096;

/// The same tree, built by one of the processes that share it, on all cores since the others wait;
/// the others copy it. Small ones are built by each.
BuiltMeshTree shared_mesh_tree(const TriangleMesh& mesh, int threads, BvhQuality quality,
                               const SharedTree& shared);

}  // namespace tessera
