#pragma once

#include <memory>
#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/accel/bvh_kernels.h"
#include "renderer/accel/mesh_tree.h"

namespace tessera {

/// Eight-wide bounding volume hierarchy over the triangles of a mesh. Boxes in single precision
/// cull, the watertight test in double decides. It keeps its own copy of the vertices and does not
/// need the mesh afterwards.
class MeshBvh final : public Accelerator {
 public:
  /// At least one triangle, all of them finite.
  MeshBvh(const TriangleMesh& mesh, int threads, const BvhKernels& code = kernels(),
          BvhQuality quality = BvhQuality::standard)
      : MeshBvh(build_mesh_tree(mesh, threads, quality), code) {}
  explicit MeshBvh(BuiltMeshTree built, const BvhKernels& code = kernels());
  Bounds3 bounds() const override { return tree_.bounds; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override {
    return closest_(tree_, ray, hit, counters);
  }
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override {
    return any_(tree_, ray, counters);
  }
  using Accelerator::any_hits, Accelerator::closest_hits;
  void closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                    TraversalCounters& counters) const override;
  uint64_t any_hits(std::span<const Ray> rays, TraversalCounters& counters) const override;
  bool takes_batches() const override { return true; }
  void all_hits(const Ray& ray, std::vector<Hit>& hits,
                TraversalCounters& counters) const override {
    all_(tree_, ray, hits, counters);
  }
  AcceleratorStatistics statistics() const override { return statistics_; }

 private:
  MeshTree tree_;
  decltype(BvhKernels::mesh_closest) closest_;
  decltype(BvhKernels::mesh_any) any_;
  decltype(BvhKernels::mesh_all) all_;
  decltype(BvhKernels::mesh_closest_packet) closest_packet_;
  decltype(BvhKernels::mesh_any_packet) any_packet_;
  AcceleratorStatistics statistics_;
};

/// The same over instances. What cannot be held is kept outside of the tree and always tested.
class InstanceBvh final : public Accelerator {
 public:
  /// At least one instance that can_be_held().
  InstanceBvh(std::vector<Instance> instances, int threads, const BvhKernels& code = kernels());
  Bounds3 bounds() const override { return bounds_; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override {
    return closest_(tree_, ray, hit, counters);
  }
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override {
    uint32_t first = kNoInstance;
    return any_(tree_, ray, first, counters);
  }
  bool any_hit_by(const Ray& ray, uint32_t& instance, TraversalCounters& counters) const override {
    return any_(tree_, ray, instance, counters);
  }
  bool takes_guesses() const override { return true; }
  using Accelerator::any_hits, Accelerator::closest_hits;
  void closest_hits(const RayBatch& rays, std::span<Hit> hits,
                    TraversalCounters& counters) const override;
  uint64_t any_hits(const RayBatch& rays, TraversalCounters& counters) const override;
  bool takes_batches() const override { return takes_batches_; }
  void all_hits(const Ray& ray, std::vector<Hit>& hits,
                TraversalCounters& counters) const override {
    all_(tree_, ray, hits, counters);
  }
  AcceleratorStatistics statistics() const override { return statistics_; }

 private:
  bool takes_batch(const RayBatch& rays) const {
    return takes_batches_ && are_coherent(rays, double{tree_.tree.extent});
  }

  InstanceTree tree_;
  bool takes_batches_;
  Bounds3 bounds_;
  decltype(BvhKernels::instance_closest) closest_;
  decltype(BvhKernels::instance_any) any_;
  decltype(BvhKernels::instance_all) all_;
  decltype(BvhKernels::instance_closest_packet) closest_packet_;
  decltype(BvhKernels::instance_any_packet) any_packet_;
  AcceleratorStatistics statistics_;
};

}  // namespace tessera
