#pragma once

#include <memory>
#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/accel/instance.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// Tests every triangle: the oracle that all other accelerators are held against.
class MeshLinearScan final : public Accelerator {
 public:
  explicit MeshLinearScan(std::shared_ptr<const TriangleMesh> mesh);
  Bounds3 bounds() const override { return bounds_; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override;
  void all_hits(const Ray& ray, std::vector<Hit>& hits, TraversalCounters& counters) const override;
  AcceleratorStatistics statistics() const override;

 private:
  std::shared_ptr<const TriangleMesh> mesh_;
  Bounds3 bounds_;
};

/// Tests every instance.
class InstanceLinearScan final : public Accelerator {
 public:
  explicit InstanceLinearScan(std::vector<Instance> instances);
  Bounds3 bounds() const override { return bounds_; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override;
  using Accelerator::any_hits, Accelerator::closest_hits;
  void closest_hits(const RayBatch& rays, std::span<Hit> hits,
                    TraversalCounters& counters) const override;
  uint64_t any_hits(const RayBatch& rays, TraversalCounters& counters) const override;
  bool takes_batches() const override { return takes_batches_; }
  void all_hits(const Ray& ray, std::vector<Hit>& hits, TraversalCounters& counters) const override;
  AcceleratorStatistics statistics() const override;

 private:
  bool takes_batch(const RayBatch& rays) const;

  std::vector<Instance> instances_;
  bool takes_batches_;
  double bounded_extent_ = 0;  ///< the longest side of the box around those that have a box
  Bounds3 bounds_;
};

}  // namespace tessera
