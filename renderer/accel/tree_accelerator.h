#pragma once

#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/accel/bvh_kernels.h"
#include "renderer/accel/mesh_tree.h"

namespace tessera {

/// An eight-wide tree over the triangles of a mesh, however it is built. Boxes in single precision
/// cull, the watertight test in double decides. It has its own copy of the vertices.
class MeshTreeAccelerator : public Accelerator {
 public:
  MeshTreeAccelerator(BuiltMeshTree built, const BvhKernels& code);
  Bounds3 bounds() const override { return tree_.bounds; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override {
    return code_.mesh_closest(tree_, ray, hit, counters);
  }
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override {
    return code_.mesh_any(tree_, ray, counters);
  }
  using Accelerator::any_hits, Accelerator::closest_hits;
  void closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                    TraversalCounters& counters) const override;
  uint64_t any_hits(std::span<const Ray> rays, TraversalCounters& counters) const override;
  bool takes_batches() const override { return true; }
  void all_hits(const Ray& ray, std::vector<Hit>& hits,
                TraversalCounters& counters) const override {
    code_.mesh_all(tree_, ray, hits, counters);
  }
  AcceleratorStatistics statistics() const override { return statistics_; }
  const MeshTree& tree() const { return tree_; }

 private:
  MeshTree tree_;
  BvhKernels code_;
  AcceleratorStatistics statistics_;
};

/// A tree over instances, and what is told of it.
struct BuiltInstanceTree {
  InstanceTree tree;
  Bounds3 bounds;
  AcceleratorStatistics statistics;
};
/// The same over instances. What cannot be held is kept outside of the tree and always tested.
class InstanceTreeAccelerator : public Accelerator {
 public:
  InstanceTreeAccelerator(BuiltInstanceTree built, const BvhKernels& code);
  Bounds3 bounds() const override { return bounds_; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override {
    return code_.instance_closest(tree_, ray, hit, counters);
  }
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override {
    uint32_t first = kNoInstance;
    return code_.instance_any(tree_, ray, first, counters);
  }
  bool any_hit_by(const Ray& ray, uint32_t& instance, TraversalCounters& counters) const override {
    return code_.instance_any(tree_, ray, instance, counters);
  }
  bool takes_guesses() const override { return true; }
  using Accelerator::any_hits, Accelerator::closest_hits;
  void closest_hits(const RayBatch& rays, std::span<Hit> hits,
                    TraversalCounters& counters) const override;
  uint64_t any_hits(const RayBatch& rays, TraversalCounters& counters) const override;
  bool takes_batches() const override { return takes_batches_; }
  void all_hits(const Ray& ray, std::vector<Hit>& hits,
                TraversalCounters& counters) const override {
    code_.instance_all(tree_, ray, hits, counters);
  }
  AcceleratorStatistics statistics() const override { return statistics_; }
  const InstanceTree& tree() const { return tree_; }

 private:
  bool takes_batch(const RayBatch& rays) const {
    return takes_batches_ && are_coherent(rays, double{tree_.tree.extent});
  }

  InstanceTree tree_;
  bool takes_batches_;
  Bounds3 bounds_;
  BvhKernels code_;
  AcceleratorStatistics statistics_;
};

}  // namespace tessera
