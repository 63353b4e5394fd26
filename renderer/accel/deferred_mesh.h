#pragma once

#include <atomic>
#include <memory>
#include <mutex>

#include "renderer/accel/accelerator.h"
#include "renderer/accel/mesh_tree.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// What becomes of the meshes of a scene that are built when they are needed.
struct DeferredBuilds {
  std::atomic<uint64_t> built{0};  ///< trees, since the count was last read
  std::atomic<int> under_way{0};   ///< that threads may wait for
};

/// A mesh whose accelerator is built by the first ray whose line meets its box; other threads that
/// need it wait. The answers are those of the accelerator. Unlike others it allocates, once, in a
/// call for a hit.
class DeferredMesh final : public Accelerator {
 public:
  /// `kind` must be one that cannot be absent from the program. `builds` may be null.
  DeferredMesh(std::shared_ptr<const TriangleMesh> mesh, AcceleratorKind kind, int threads,
               std::shared_ptr<DeferredBuilds> builds, const SharedTree& shared = {});
  Bounds3 bounds() const override { return bounds_; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override;
  using Accelerator::any_hits, Accelerator::closest_hits;
  void closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                    TraversalCounters& counters) const override;
  uint64_t any_hits(std::span<const Ray> rays, TraversalCounters& counters) const override;
  bool takes_batches() const override;
  void all_hits(const Ray& ray, std::vector<Hit>& hits, TraversalCounters& counters) const override;
  /// Of the accelerator, once it is built.
  AcceleratorStatistics statistics() const override;

 private:
  /// Null for a ray that passes by before there is an accelerator.
  const Accelerator* accelerator_for(const Ray& ray) const;
  bool passes_by(const Ray& ray) const;

  std::shared_ptr<const TriangleMesh> mesh_;
  AcceleratorKind kind_;
  int threads_;
  SharedTree shared_;
  std::shared_ptr<DeferredBuilds> builds_;
  Bounds3 bounds_;
  mutable std::once_flag once_;
  mutable std::shared_ptr<const Accelerator> owned_;
  mutable std::atomic<const Accelerator*> built_{nullptr};
};

}  // namespace tessera
