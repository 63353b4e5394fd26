// Part of bvh_kernels.cpp, compiled once for each instruction set: what the rays of a batch
// meet of InstanceSoA, a lane a ray.
#if defined(TESSERA_INSTANCE_SOA_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_INSTANCE_SOA_INL_H
#undef TESSERA_INSTANCE_SOA_INL_H
#else
#define TESSERA_INSTANCE_SOA_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "renderer/accel/carved_lanes-inl.h"
#include "renderer/accel/instance_soa.h"
#include "renderer/accel/ray_batch.h"
#include "renderer/accel/slab_lanes-inl.h"
#include "renderer/accel/sphere_lanes-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/shape_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// The nearest that rays have met.
struct Nearest {
  Lanes t, instance;

  HWY_INLINE Nearest()
      : t(broadcast(std::numeric_limits<double>::infinity())), instance(hn::Zero(kLaneTag)) {}
  HWY_INLINE void take(LaneMask met, Lanes at, uint32_t number) {
    const Lanes candidate = broadcast(number);
    const auto is_first = hn::And(hn::Eq(at, t), hn::Lt(candidate, instance));
    const auto taken = hn::And(met, hn::Or(hn::Lt(at, t), is_first));
    t = hn::IfThenElse(taken, at, t);
    instance = hn::IfThenElse(taken, candidate, instance);
  }
};

/// Plane::intersect() with each.
HWY_INLINE void meet_planes(const InstanceSoA& few, uint32_t asked, const Lanes3& origin,
                            const Lanes3& direction, Lanes first, Lanes last, Nearest& nearest) {
  const PlaneSoA& planes = few.planes;
  const Lanes zero = hn::Zero(kLaneTag);
  for (size_t i = 0; i < planes.count; ++i) {
    if ((asked >> i & 1) == 0) continue;
    const PlaneEquation plane{{broadcast(planes.normal[0][i]), broadcast(planes.normal[1][i]),
                               broadcast(planes.normal[2][i])},
                              broadcast(planes.offset[i])};
    const Lanes approach = dot(plane.normal, direction);
    const Lanes height = plane.signed_distance(origin);
    const Lanes t = hn::Neg(height) / approach;
    const auto inside = hn::And(hn::Gt(t, first), hn::Lt(t, last));
    auto is_met = hn::And(inside, hn::Gt(hn::Abs(height), plane.distance_error(origin)));
    const auto in_front = hn::Lt(approach, zero);
    if ((planes.from_front >> i & 1) == 0) is_met = hn::AndNot(in_front, is_met);
    if ((planes.from_behind >> i & 1) == 0) is_met = hn::And(in_front, is_met);
    nearest.take(is_met, t, few.plane_instances[i]);
  }
}

HWY_INLINE Lanes along_axis(const Lanes3& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}
HWY_INLINE Lanes3 part_of(const double (&parts)[3][RectangleSoA::kMost], size_t i) {
  return {broadcast(parts[0][i]), broadcast(parts[1][i]), broadcast(parts[2][i])};
}
/// Where rays cross the plane of a rectangle.
struct RectangleCrossing {
  Lanes3 from;  ///< the corner
  /// Of the normal, what cross_plane() asks for.
  Lanes height, approach, reach;
};
HWY_INLINE RectangleCrossing cross_rectangle(const RectangleSoA& rectangles, size_t i,
                                             const Lanes3& origin, const Lanes3& direction) {
  RectangleCrossing at;
  at.from = origin - part_of(rectangles.corner, i);
  const Lanes3 normal = part_of(rectangles.normal, i);
  if (rectangles.axis[i] < 0) {
    at.height = accurate_dot(normal, at.from);
    at.approach = accurate_dot(normal, direction);
    at.reach = dot(abs(normal), abs(at.from));
  } else {
    const Lanes along = along_axis(normal, rectangles.axis[i]);
    at.height = along * along_axis(at.from, rectangles.axis[i]);
    at.approach = along * along_axis(direction, rectangles.axis[i]);
    at.reach = hn::Abs(at.height);
  }
  return at;
}
HWY_INLINE LaneMask are_close(Lanes t, Lanes other) {
  constexpr double kFarAboveRounding = 0x1p-44;
  return hn::Le(hn::Abs(t - other), hn::Abs(t) * broadcast(kFarAboveRounding));
}

/// Rectangle::closest_hit() with each, to its bits; in the lanes that are returned one of `asked`
/// may be hit of which that cannot be told here. Of rays as RectangleSoA knows them; `inverse` is
/// one over the direction, about. By it t is told well enough to find the nearest; exactly, by a
/// division, it is worked out of that one, and where a ray ends close to it.
HWY_INLINE LaneMask meet_rectangles(const InstanceSoA& few, uint32_t asked, const Lanes3& origin,
                                    const Lanes3& direction, const Lanes3& inverse, Lanes first,
                                    Lanes last, Nearest& nearest) {
  const RectangleSoA& rectangles = few.rectangles;
  const Lanes zero = hn::Zero(kLaneTag), half = broadcast(0.5);
  const Lanes steep = sum(abs(direction));
  const Lanes slack = broadcast(2 * RectangleSoA::kMargin * rectangles.extent) / steep;
  auto in_doubt = hn::Lt(steep, zero), is_rectangle = in_doubt;  // none
  Lanes height = zero, approach = broadcast(1);
  while (asked != 0) {
    const size_t i = take_lowest_lane(asked);
    const RectangleCrossing at = cross_rectangle(rectangles, i, origin, direction);
    const auto exact = [&] HWY_ATTR { return hn::Neg(at.height) / at.approach; };
    const int axis = rectangles.axis[i];
    Lanes t = axis < 0 ? exact() : hn::Neg(along_axis(at.from, axis) * along_axis(inverse, axis));
    const auto told = hn::Gt(hn::Abs(at.approach), broadcast(rectangles.grazing[i]) * steep);
    const auto too_far = hn::Gt(t, hn::Min(last, nearest.t) + slack);
    const auto elsewhere = hn::Or(hn::Lt(t + slack, first), too_far);
    if (hn::AllTrue(kLaneTag, hn::And(told, elsewhere))) continue;
    const Lanes3 p = direction * t + at.from;
    const Lanes u = hn::Abs(dot(part_of(rectangles.share_u, i), p) - half);
    const Lanes v = hn::Abs(dot(part_of(rectangles.share_v, i), p) - half);
    const auto outside = hn::Or(hn::Gt(u, broadcast(rectangles.out_u[i])),
                                hn::Gt(v, broadcast(rectangles.out_v[i])));
    const auto missed = hn::And(told, hn::Or(outside, elsewhere));
    const auto inside =
        hn::And(hn::Lt(u, broadcast(rectangles.in_u[i])), hn::Lt(v, broadcast(rectangles.in_v[i])));
    const auto sure = hn::And(told, inside);
    in_doubt = hn::Or(in_doubt, hn::Not(hn::Or(missed, sure)));
    auto met = hn::AndNot(missed, sure);
    const auto in_front = hn::Lt(at.approach, zero);
    if ((few.seen_from_front >> i & 1) == 0) met = hn::AndNot(in_front, met);
    if ((few.seen_from_behind >> i & 1) == 0) met = hn::And(in_front, met);
    const auto at_end = hn::Or(are_close(t, first), are_close(t, last));
    if (axis >= 0 && !hn::AllFalse(kLaneTag, hn::And(met, at_end))) t = exact();
    met = hn::And(met, hn::Gt(hn::Abs(at.height), broadcast(gamma(2)) * at.reach));
    met = hn::And(met, hn::And(hn::Gt(t, first), hn::Lt(t, last)));
    in_doubt = hn::Or(in_doubt, hn::And(met, are_close(t, nearest.t)));
    const auto taken = hn::And(met, hn::Lt(t, nearest.t));
    nearest.t = hn::IfThenElse(taken, t, nearest.t);
    nearest.instance =
        hn::IfThenElse(taken, broadcast(few.rectangle_instances[i]), nearest.instance);
    height = hn::IfThenElse(taken, at.height, height);
    approach = hn::IfThenElse(taken, at.approach, approach);
    is_rectangle = hn::Or(is_rectangle, taken);
  }
  nearest.t = hn::IfThenElse(is_rectangle, hn::Neg(height) / approach, nearest.t);
  return in_doubt;
}
/// Whether rectangles_met() would tell of each.
HWY_INLINE LaneMask are_usual(const RectangleSoA& rectangles, const Lanes3& origin,
                              const Lanes3& direction, double t_min) {
  const Lanes steep = sum(abs(direction));
  const auto is_steep = hn::And(hn::Ge(steep, broadcast(RectangleSoA::kLeastSteep)),
                                hn::Le(steep, broadcast(RectangleSoA::kMostSteep)));
  const double farthest = t_min >= 0 ? rectangles.farthest : -1;
  return hn::And(is_steep, hn::Le(sum(abs(origin)), broadcast(farthest)));
}

/// BvhKernels::intersect_batch.
void intersect_batch(const InstanceSoA& few, const RayBatch& rays, bool only_shading,
                     BatchHits& met) {
  const uint32_t planes = only_shading ? few.shading_planes : ~0u;
  const uint32_t rectangles = only_shading ? few.shading_rectangles : few.rectangles.all;
  const uint32_t spheres = only_shading ? few.spheres.shading : few.spheres.boxes;
  const Lanes first = broadcast(rays.t_min);
  met.tests = few.tests_of_each() * rays.count;
  // What is behind the last ray counts for nothing.
  for (size_t at = 0; at < rays.count; at += kLanes) {
    const Lanes3 origin = load(rays.origin, at), direction = load(rays.direction, at);
    const Lanes last = hn::Load(kLaneTag, rays.t_max + at);
    Nearest nearest;
    meet_planes(few, planes, origin, direction, first, last, nearest);
    const SlabLanes slabs(origin, direction);
    auto usual = slabs.are_usual(few.boxes);
    if (few.rectangles.all != 0) {
      usual = hn::And(usual, are_usual(few.rectangles, origin, direction, rays.t_min));
      const auto in_doubt = meet_rectangles(few, rectangles, origin, direction, slabs.inverse(),
                                            first, last, nearest);
      usual = hn::AndNot(in_doubt, usual);
    }
    const uint32_t rays_here = movemask(usual) & ((1u << std::min(kLanes, rays.count - at)) - 1);
    auto bits = hn::IfThenElse(hn::RebindMask(kIndexTag, usual), hn::Zero(kIndexTag),
                               hn::Set(kIndexTag, int64_t{BoxSoA::kUnusual}));
    for (size_t i = 0; (few.boxes.all >> i & 1) != 0; ++i) {
      Lanes enter = first;
      auto in = slabs.entered(few.boxes, i, enter, hn::Min(last, nearest.t));
      if ((few.carved_boxes >> i & 1) != 0 && !hn::AllFalse(kLaneTag, in)) {
        met.tests += static_cast<uint64_t>(std::popcount(movemask(in) & rays_here));
        in = hn::AndNot(meet_carved_box(few.carved[i], origin, direction, last).missed, in);
      }
      if ((few.spheres.boxes >> i & 1) == 0) {
        hn::Store(enter, kLaneTag, met.entered[i] + at);
        const auto bit = hn::Set(kIndexTag, int64_t{1} << i);
        bits = hn::Or(bits, hn::IfThenElseZero(hn::RebindMask(kIndexTag, in), bit));
        continue;
      }
      const uint32_t entering = movemask(in) & rays_here;
      if (entering == 0 || (spheres >> i & 1) == 0) continue;
      met.tests += static_cast<uint64_t>(std::popcount(entering));
      Lanes t = first;
      const auto is_met = meet_sphere(few.spheres, i, origin, direction, first, last, t);
      nearest.take(hn::And(in, is_met), t, few.spheres.instance[i]);
    }
    hn::Store(nearest.t, kLaneTag, met.t + at);
    hn::Store(nearest.instance, kLaneTag, met.instance + at);
    hn::Store(bits, kIndexTag, met.boxes + at);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
