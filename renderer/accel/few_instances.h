#pragma once

#include <array>
#include <span>
#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/accel/box_soa.h"
#include "renderer/accel/bvh_kernels.h"
#include "renderer/accel/instance_soa.h"
#include "renderer/accel/plane_soa.h"
#include "renderer/accel/rectangle_soa.h"

namespace tessera {

/// A few instances without a tree: a ray is held against all rectangles that stand as they are, all
/// planes if they are several, and the boxes of all others, each at once, which takes less than to
/// prepare it for a tree. What cannot be held in a box is always tested.
class FewInstances final : public Accelerator {
 public:
  /// At most BoxSoA::kMost that can_be_held(), any number of others.
  explicit FewInstances(std::vector<Instance> instances, const BvhKernels& code = kernels());
  Bounds3 bounds() const override { return bounds_; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override;
  void all_hits(const Ray& ray, std::vector<Hit>& hits, TraversalCounters& counters) const override;
  using Accelerator::any_hits, Accelerator::closest_hits;
  void closest_hits(const RayBatch& rays, std::span<Hit> hits,
                    TraversalCounters& counters) const override;
  uint64_t any_hits(const RayBatch& rays, TraversalCounters& counters) const override;
  bool takes_batches() const override { return batch_boxes_ != 0; }
  AcceleratorStatistics statistics() const override;

  /// A bit of a mask stands for one of them.
  const BoxSoA& boxes() const { return soa_.boxes; }
  const InstanceSoA& soa() const { return soa_; }
  /// Whether nothing is held as a rectangle, so that what is in no box is always tested.
  bool is_all_in_boxes() const { return soa_.rectangles.count == 0; }
  /// any_hit() of a ray that may hit what is in `boxes`, as BvhKernels::boxes_entered tells, where
  /// all are in boxes.
  bool any_hit_among(uint32_t boxes, const Ray& ray, TraversalCounters& counters) const;
  /// Whether there is anything to hit in `boxes`, or that is in none.
  bool holds_any(uint32_t boxes) const {
    return boxes != 0 || !endless_.empty() || planes_at_once_ != 0;
  }

  /// How many planes of `instances` are held against a ray at once, if they are several.
  static size_t planes_among(std::span<const Instance> instances);

 private:
  void fill_soa();
  /// The place of the first box among candidates.
  static constexpr size_t kBoxes = RectangleSoA::kMost;
  /// What the ray may hit, a bit each, and lower bounds of t there.
  struct Candidates {
    uint32_t left = 0;
    uint32_t inside = 0;      ///< rectangles that the ray is inside of
    bool is_unusual = false;  ///< the ray may hit nothing at all
    double entered[2 * BoxSoA::kMost];
  };
  void find_rectangles(const Ray& ray, double t_max, Candidates& candidates) const;
  void find_boxes(const Ray& ray, double t_max, Candidates& candidates) const;

  /// Those of batch_boxes_ if the rays go much the same way.
  uint32_t boxes_for_batches(const RayBatch& rays) const {
    return batch_boxes_ != 0 && are_coherent(rays, bounded_extent_) ? batch_boxes_ : 0;
  }
  /// What the rays hit in batch_boxes_.
  void closest_in_batches(const RayBatch& rays, const BatchHits& met, std::span<Hit> hits,
                          TraversalCounters& counters) const;
  /// Those that hit something in the box; `stopped` are not asked.
  uint64_t any_in_batch(const RayBatch& rays, const BatchHits& met, size_t box, uint64_t stopped,
                        TraversalCounters& counters) const;
  bool closest_endless(const Ray& ray, Hit& hit, TraversalCounters& counters) const;
  bool any_endless(const Ray& ray, TraversalCounters& counters) const;
  bool closest_plane(const Ray& ray, Hit& hit, TraversalCounters& counters) const;

  std::vector<Instance> instances_;
  std::vector<const Rectangle*> rectangles_;  ///< by instance; null: it is not held as one
  InstanceSoA soa_;
  /// Of soa_.planes those that a single ray is held against at once: all or, if they are fewer
  /// than PlaneSoA::kLeast, none.
  size_t planes_at_once_ = 0;
  /// What is in no box and no rectangle, ascending, always tested: by many rays at once beside
  /// soa_.planes, by a single ray beside those that it is held against at once.
  std::vector<uint32_t> soa_endless_, endless_;
  double bounded_extent_ = 0;  ///< the longest side of the box around soa_.boxes
  uint32_t batch_boxes_ = 0;   ///< a bit for each of soa_.boxes that holds what takes_batches()
  /// By candidate: those of the rectangles, and from kBoxes on those of the boxes.
  std::array<uint32_t, 2 * BoxSoA::kMost> held_{};
  Bounds3 bounds_;
  decltype(BvhKernels::boxes_entered) boxes_entered_;
  decltype(BvhKernels::rectangles_met) rectangles_met_;
  decltype(BvhKernels::planes_met) planes_met_;
  decltype(BvhKernels::intersect_batch) intersect_batch_;
};

}  // namespace tessera
