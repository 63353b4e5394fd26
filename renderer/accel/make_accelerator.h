#pragma once

#include <memory>
#include <string>
#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/accel/bvh_kernels.h"
#include "renderer/accel/deferred_mesh.h"
#include "renderer/accel/instance.h"
#include "renderer/accel/mesh_shape.h"
#include "renderer/accel/mesh_tree.h"

namespace tessera {

// `threads` is how many the build may use; it changes nothing in the result. What is too small to
// be worth a tree gets none. `code` are its kernels, which change the
// counters alone. Throws a usage Error for a kind that this program was built without, a scene
// Error for a mesh of more than kMaxPrimitives.

/// The names of --accel that this program has; the first is the default.
const std::vector<std::string>& available_accelerators();

/// Throws a scene Error where no tree can hold so many.
void check_triangle_count(size_t count);

/// Every triangle of `mesh` must be legal: see drop_degenerate().
std::unique_ptr<const Accelerator> make_mesh_accelerator(std::shared_ptr<const TriangleMesh> mesh,
                                                         AcceleratorKind kind, int threads,
                                                         const SharedTree& shared = {},
                                                         const BvhKernels& code = kernels());
/// The same, or what another scene of this process has of it already.
std::shared_ptr<const Accelerator> shared_mesh_accelerator(std::shared_ptr<const TriangleMesh> mesh,
                                                           AcceleratorKind kind, int threads,
                                                           const SharedTree& shared,
                                                           const BvhKernels& code = kernels());
std::shared_ptr<const MeshShape> make_mesh_shape(std::shared_ptr<const TriangleMesh> mesh,
                                                 AcceleratorKind kind, int threads,
                                                 const SharedTree& shared = {},
                                                 const BvhKernels& code = kernels());
/// The same, but built by the first ray that may hit it: a mesh that no ray comes near costs no
/// build. `builds` counts it then.
std::shared_ptr<const MeshShape> make_deferred_mesh_shape(std::shared_ptr<const TriangleMesh> mesh,
                                                          AcceleratorKind kind, int threads,
                                                          std::shared_ptr<DeferredBuilds> builds,
                                                          const SharedTree& shared = {});
/// Hits carry the index into `instances`.
std::unique_ptr<const Accelerator> make_instance_accelerator(std::vector<Instance> instances,
                                                             AcceleratorKind kind, int threads,
                                                             const BvhKernels& code = kernels());

}  // namespace tessera
