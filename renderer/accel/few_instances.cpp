#include "renderer/accel/few_instances.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "base/uninitialized.h"
#include "renderer/accel/tree_boxes.h"
#include "renderer/shapes/csg_shape.h"

namespace tessera {
namespace {

/// Takes the lowest of the bits.
size_t take_lowest(uint32_t& bits) {
  const auto i = static_cast<size_t>(std::countr_zero(bits));
  bits &= bits - 1;
  return i;
}
/// Takes that of the bits whose box is entered first.
size_t take_nearest(uint32_t& bits, const double* entered) {
  uint32_t others = bits;
  size_t nearest = take_lowest(others);
  while (others != 0) {
    const size_t i = take_lowest(others);
    if (entered[i] < entered[nearest]) nearest = i;
  }
  bits &= ~(1u << nearest);
  return nearest;
}

/// The rectangle that the instance is, where it stands as it is; or null.
const Rectangle* plain_rectangle(const Instance& instance) {
  if (!instance.world_from_object.is_identity()) return nullptr;
  const auto* rectangle = dynamic_cast<const Rectangle*>(instance.shape.get());
  return rectangle && RectangleSoA::can_hold(*rectangle) ? rectangle : nullptr;
}

bool is_plain_plane(const Instance& instance) {
  return instance.shape->kind() == ShapeKind::plane && instance.world_from_object.is_identity();
}

/// As closest_hit_of() where the ray is known to be inside the rectangle's edges.
bool closest_hit_inside_of(const Rectangle& rectangle, uint32_t number, const Ray& ray, Hit& hit,
                           TraversalCounters& counters) {
  const uint32_t primitive = hit.primitive;
  if (number != hit.instance) {
    hit.primitive = number < hit.instance ? std::numeric_limits<uint32_t>::max() : 0;
  }
  const bool found = rectangle.closest_hit_inside(ray, hit, counters);
  if (found)
    hit.instance = number;
  else
    hit.primitive = primitive;
  return found;
}

}  // namespace

FewInstances::FewInstances(std::vector<Instance> instances, const BvhKernels& code)
    : instances_(std::move(instances)),
      boxes_entered_(code.boxes_entered),
      rectangles_met_(code.rectangles_met),
      planes_met_(code.planes_met),
      intersect_batch_(code.intersect_batch) {
  std::vector<Bounds3> boxes;
  Bounds3 bounded;
  rectangles_.resize(instances_.size());
  for (uint32_t i = 0; i < instances_.size(); ++i) {
    const Instance& instance = instances_[i];
    const Bounds3 box = bounds_of(instance);
    if (box.empty()) continue;
    bounds_.extend(box);
    if (const Rectangle* const rectangle = plain_rectangle(instance)) {
      rectangles_[i] = rectangle;
      const size_t place = soa_.rectangles.count;
      const Cull cull = seen_cull(instance);
      if (cull != Cull::front) soa_.seen_from_front |= 1u << place;
      if (cull != Cull::back) soa_.seen_from_behind |= 1u << place;
      if (instance.casts_shadow) soa_.shading_rectangles |= 1u << place;
      held_[place] = soa_.rectangle_instances[place] = i;
      soa_.rectangles.add(*rectangle);
    } else if (can_be_held(instance, box)) {
      held_[kBoxes + boxes.size()] = i;
      boxes.push_back(box);
      bounded.extend(box);
    } else {
      endless_.push_back(i);
    }
  }
  soa_.rectangles.finish();
  soa_.boxes = BoxSoA(boxes);
  if (!bounded.empty()) bounded_extent_ = max_component(bounded.max - bounded.min);
  fill_soa();
}

size_t FewInstances::planes_among(std::span<const Instance> instances) {
  return static_cast<size_t>(std::count_if(instances.begin(), instances.end(), is_plain_plane));
}

void FewInstances::fill_soa() {
  PlaneSoA& planes = soa_.planes;
  for (const uint32_t i : endless_) {
    if (planes.count == PlaneSoA::kMost || !is_plain_plane(instances_[i])) {
      soa_endless_.push_back(i);
      continue;
    }
    soa_.plane_instances[planes.count] = i;
    if (instances_[i].casts_shadow) soa_.shading_planes |= 1u << planes.count;
    planes.add(static_cast<const Plane&>(*instances_[i].shape), seen_cull(instances_[i]));
  }
  if (planes.count >= PlaneSoA::kLeast) {
    planes_at_once_ = planes.count;
    endless_ = soa_endless_;
  }
  for (size_t box = 0; (soa_.boxes.all >> box & 1) != 0; ++box) {
    const uint32_t i = held_[kBoxes + box];
    const Instance& instance = instances_[i];
    if (instance.shape->takes_batches()) batch_boxes_ |= 1u << box;
    if (!instance.world_from_object.is_identity()) continue;
    if (const auto* const csg = dynamic_cast<const CsgShape*>(instance.shape.get())) {
      std::optional<CarvedBox> carved = csg->carved_box();
      if (!carved || instance.cull != Cull::none || !instance.casts_shadow) continue;
      soa_.carved[box] = *std::move(carved);
      soa_.carved_boxes |= 1u << box;
    }
    if (instance.shape->kind() != ShapeKind::sphere) continue;
    const auto& sphere = static_cast<const Sphere&>(*instance.shape);
    // Beyond, squares leave the range of double, and a hit may be told before its box is entered.
    if (!(sphere.radius() > 1e-100 && sphere.radius() < 1e100)) continue;
    soa_.spheres.set(box, sphere, i, seen_cull(instance), instance.casts_shadow);
  }
}

void FewInstances::find_rectangles(const Ray& ray, double t_max, Candidates& candidates) const {
  if (is_all_in_boxes()) return;
  const RectanglesMet met = rectangles_met_(soa_.rectangles, ray, t_max, candidates.entered);
  const uint32_t two_sided = soa_.seen_from_front & soa_.seen_from_behind;
  candidates.left = met.maybe;
  candidates.inside = ray.cull == Cull::none ? met.inside & two_sided : 0;
  candidates.is_unusual = (met.maybe & RectangleSoA::kUnusual) != 0;
}

void FewInstances::find_boxes(const Ray& ray, double t_max, Candidates& candidates) const {
  if (soa_.boxes.count == 0) {
    candidates.is_unusual |= is_all_in_boxes();
    return;
  }
  const uint32_t in = boxes_entered_(soa_.boxes, ray, t_max, candidates.entered + kBoxes);
  candidates.left |= (in & soa_.boxes.all) << kBoxes;
  candidates.is_unusual |= (in & BoxSoA::kUnusual) != 0;
}

inline bool FewInstances::closest_plane(const Ray& ray, Hit& hit,
                                        TraversalCounters& counters) const {
  if (ray.cull != Cull::none) {
    bool found = false;
    for (size_t i = 0; i < planes_at_once_; ++i) {
      const uint32_t number = soa_.plane_instances[i];
      found |= closest_hit_of(instances_[number], number, ray, hit, counters);
    }
    return found;
  }
  counters.primitive_tests += planes_at_once_;
  double t[PlaneSoA::kMost];
  uint32_t met = planes_met_(soa_.planes, ray, hit.t, t);
  if (met == 0) return false;
  const size_t nearest = take_nearest(met, t);
  return take_if_closer(t[nearest], soa_.plane_instances[nearest], hit);
}

inline bool FewInstances::closest_endless(const Ray& ray, Hit& hit,
                                          TraversalCounters& counters) const {
  bool found = planes_at_once_ > 0 && closest_plane(ray, hit, counters);
  for (const uint32_t i : endless_) found |= closest_hit_of(instances_[i], i, ray, hit, counters);
  return found;
}

inline bool FewInstances::any_endless(const Ray& ray, TraversalCounters& counters) const {
  if (planes_at_once_ > 0 && ray.cull == Cull::none) {
    counters.primitive_tests += planes_at_once_;
    double t[PlaneSoA::kMost];
    if ((planes_met_(soa_.planes, ray, ray.t_max, t) & soa_.shading_planes) != 0) return true;
  } else {
    for (size_t i = 0; i < planes_at_once_; ++i)
      if (any_hit_of(instances_[soa_.plane_instances[i]], ray, counters)) return true;
  }
  for (const uint32_t i : endless_)
    if (any_hit_of(instances_[i], ray, counters)) return true;
  return false;
}

bool FewInstances::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  Candidates candidates;
  const double t_max = std::min(ray.t_max, hit.t);
  find_rectangles(ray, t_max, candidates);
  find_boxes(ray, t_max, candidates);
  if (candidates.is_unusual && !can_hit(ray)) return false;
  bool found = closest_endless(ray, hit, counters);
  for (uint32_t left = candidates.left; left != 0;) {
    const size_t nearest = take_nearest(left, candidates.entered);
    if (candidates.entered[nearest] > hit.t) break;
    const uint32_t i = held_[nearest];
    found |= (candidates.inside >> nearest & 1) != 0
                 ? closest_hit_inside_of(*rectangles_[i], i, ray, hit, counters)
                 : closest_hit_of(instances_[i], i, ray, hit, counters);
  }
  return found;
}

void FewInstances::closest_hits(const RayBatch& rays, std::span<Hit> hits,
                                TraversalCounters& counters) const {
  BatchHits met;
  intersect_batch_(soa_, rays, false, met);
  counters.primitive_tests += met.tests;
  const uint32_t batch_boxes = boxes_for_batches(rays);
  for (size_t i = 0; i < rays.count; ++i) {
    Hit& hit = hits[i];
    hit = {};
    auto boxes = static_cast<uint32_t>(met.boxes[i]);
    if ((boxes & BoxSoA::kUnusual) != 0) [[unlikely]] {
      counters.primitive_tests -= soa_.tests_of_each();
      closest_hit(rays.ray(i), hit, counters);
      continue;
    }
    const auto nearest = static_cast<uint32_t>(met.instance[i]);
    const bool on_rectangle = std::isfinite(met.t[i]) && rectangles_[nearest];
    hit.t = met.t[i];
    hit.instance = nearest;
    if (boxes == 0 && soa_endless_.empty() && !on_rectangle) continue;
    const Ray ray = rays.ray(i);
    for (const uint32_t of : soa_endless_) closest_hit_of(instances_[of], of, ray, hit, counters);
    double entered[BoxSoA::kMost];
    if ((boxes & (boxes - 1)) != 0) {
      for (uint32_t left = boxes; left != 0;) {
        const size_t box = take_lowest(left);
        entered[box] = met.entered[box][i];
      }
    }
    boxes &= ~batch_boxes;
    while (boxes != 0) {
      const size_t box = take_nearest(boxes, entered);
      if (met.entered[box][i] > hit.t) break;
      closest_hit_of(instances_[held_[kBoxes + box]], held_[kBoxes + box], ray, hit, counters);
    }
    if (on_rectangle && hit.instance == nearest)
      hit = rectangles_[nearest]->hit_at(ray, hit.t, hit);
  }
  if (batch_boxes != 0) closest_in_batches(rays, met, hits, counters);
}

void FewInstances::closest_in_batches(const RayBatch& rays, const BatchHits& met,
                                      std::span<Hit> hits, TraversalCounters& counters) const {
  // The boxes that are entered first have their turn first.
  uint32_t entered = 0;
  double first[BoxSoA::kMost];
  std::ranges::fill(first, std::numeric_limits<double>::infinity());
  for (size_t i = 0; i < rays.count; ++i) {
    if ((met.boxes[i] & BoxSoA::kUnusual) != 0) continue;
    for (uint32_t left = static_cast<uint32_t>(met.boxes[i]) & batch_boxes_; left != 0;) {
      const size_t box = take_lowest(left);
      entered |= 1u << box;
      first[box] = std::min(first[box], met.entered[box][i]);
    }
  }
  while (entered != 0) {
    const size_t box = take_nearest(entered, first);
    Uninitialized<Ray, RayBatch::kMost> some;
    Uninitialized<Hit, RayBatch::kMost> theirs;
    uint32_t number[RayBatch::kMost];
    size_t n = 0;
    for (uint32_t i = 0; i < rays.count; ++i) {
      const auto boxes = static_cast<uint32_t>(met.boxes[i]);
      if ((boxes >> box & 1) == 0 || (boxes & BoxSoA::kUnusual) != 0 ||
          met.entered[box][i] > hits[i].t)
        continue;
      some[n] = rays.ray(i);
      theirs[n] = hits[i];
      number[n++] = i;
    }
    const uint32_t instance = held_[kBoxes + box];
    closest_hits_of(instances_[instance], instance, {some.data(), n}, {theirs.data(), n}, counters);
    for (size_t i = 0; i < n; ++i) hits[number[i]] = theirs[i];
  }
}

uint64_t FewInstances::any_hits(const RayBatch& rays, TraversalCounters& counters) const {
  BatchHits met;
  intersect_batch_(soa_, rays, true, met);
  counters.primitive_tests += met.tests;
  const uint32_t batch_boxes = boxes_for_batches(rays);
  uint64_t stopped = 0;
  for (size_t i = 0; i < rays.count; ++i) {
    const auto boxes = static_cast<uint32_t>(met.boxes[i]);
    bool stops = false;
    if ((boxes & BoxSoA::kUnusual) != 0) [[unlikely]] {
      counters.primitive_tests -= soa_.tests_of_each();
      stops = any_hit(rays.ray(i), counters);
    } else if (std::isfinite(met.t[i])) {
      stops = true;
    } else if (boxes != 0 || !soa_endless_.empty()) {
      const Ray ray = rays.ray(i);
      stops = std::ranges::any_of(
          soa_endless_, [&](uint32_t of) { return any_hit_of(instances_[of], ray, counters); });
      for (uint32_t left = boxes & ~batch_boxes; left != 0 && !stops;)
        stops = any_hit_of(instances_[held_[kBoxes + take_lowest(left)]], ray, counters);
    }
    stopped |= uint64_t{stops} << i;
  }
  for (uint32_t left = batch_boxes; left != 0;)
    stopped |= any_in_batch(rays, met, take_lowest(left), stopped, counters);
  return stopped;
}

uint64_t FewInstances::any_in_batch(const RayBatch& rays, const BatchHits& met, size_t box,
                                    uint64_t stopped, TraversalCounters& counters) const {
  Uninitialized<Ray, RayBatch::kMost> some;
  uint32_t number[RayBatch::kMost];
  size_t n = 0;
  for (uint32_t i = 0; i < rays.count; ++i) {
    const auto boxes = static_cast<uint32_t>(met.boxes[i]);
    if ((boxes >> box & 1) == 0 || (boxes & BoxSoA::kUnusual) != 0 || (stopped >> i & 1) != 0)
      continue;
    some[n] = rays.ray(i);
    number[n++] = i;
  }
  if (n == 0) return 0;
  uint64_t hit = 0;
  for (uint64_t left = any_hits_of(instances_[held_[kBoxes + box]], {some.data(), n}, counters);
       left != 0; left &= left - 1)
    hit |= uint64_t{1} << number[std::countr_zero(left)];
  return hit;
}

bool FewInstances::any_hit(const Ray& ray, TraversalCounters& counters) const {
  Candidates candidates;
  find_rectangles(ray, ray.t_max, candidates);
  for (uint32_t inside = candidates.left & candidates.inside; inside != 0;) {
    const uint32_t i = held_[take_lowest(inside)];
    if (instances_[i].casts_shadow && rectangles_[i]->any_hit_inside(ray, counters)) return true;
  }
  candidates.left &= ~candidates.inside;
  find_boxes(ray, ray.t_max, candidates);
  if (candidates.is_unusual && !can_hit(ray)) return false;
  if (any_endless(ray, counters)) return true;
  for (uint32_t left = candidates.left; left != 0;)
    if (any_hit_of(instances_[held_[take_lowest(left)]], ray, counters)) return true;
  return false;
}

bool FewInstances::any_hit_among(uint32_t boxes, const Ray& ray,
                                 TraversalCounters& counters) const {
  if ((boxes & BoxSoA::kUnusual) != 0 && !can_hit(ray)) return false;
  if (holds_any(0) && any_endless(ray, counters)) return true;
  for (uint32_t left = boxes & ~BoxSoA::kUnusual; left != 0;)
    if (any_hit_of(instances_[held_[kBoxes + take_lowest(left)]], ray, counters)) return true;
  return false;
}

void FewInstances::all_hits(const Ray& ray, std::vector<Hit>& hits,
                            TraversalCounters& counters) const {
  if (!can_hit(ray)) return;
  for (uint32_t i = 0; i < instances_.size(); ++i)
    all_hits_of(instances_[i], i, ray, hits, counters);
}

AcceleratorStatistics FewInstances::statistics() const {
  return {.primitives = instances_.size(),
          .references = instances_.size(),
          .bytes = sizeof(FewInstances) + instances_.size() * (sizeof(Instance) + sizeof(void*)) +
                   (soa_endless_.size() + endless_.size()) * sizeof(uint32_t)};
}

}  // namespace tessera
