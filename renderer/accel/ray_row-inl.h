// Part of bvh_kernels.cpp, compiled once for each instruction set: many rays against each of a few
// planes and boxes.
#if defined(TESSERA_RAY_ROW_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_RAY_ROW_INL_H
#undef TESSERA_RAY_ROW_INL_H
#else
#define TESSERA_RAY_ROW_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "renderer/accel/carved_lanes-inl.h"
#include "renderer/accel/few_rows.h"
#include "renderer/accel/ray_row.h"
#include "renderer/accel/slab_lanes-inl.h"
#include "renderer/accel/sphere_lanes-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/math/rounding.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// The nearest that rays have met.
struct Nearest {
  Lanes t, instance;

  HWY_INLINE Nearest()
      : t(all(std::numeric_limits<double>::infinity())), instance(hn::Zero(kLaneTag)) {}
  HWY_INLINE void take(LaneMask met, Lanes at, uint32_t number) {
    const Lanes candidate = all(number);
    const auto is_first = hn::And(hn::Eq(at, t), hn::Lt(candidate, instance));
    const auto taken = hn::And(met, hn::Or(hn::Lt(at, t), is_first));
    t = hn::IfThenElse(taken, at, t);
    instance = hn::IfThenElse(taken, candidate, instance);
  }
};

/// Plane::intersect() with each, line by line, and no product fused with a sum.
HWY_INLINE void meet_planes(const FewRows& few, const Lanes3& origin, const Lanes3& direction,
                            Lanes first, Lanes last, Nearest& nearest) {
  const PlaneRow& row = few.planes;
  const Lanes rounding = all(gamma(4)), zero = hn::Zero(kLaneTag);
  for (size_t i = 0; i < row.count; ++i) {
    const Lanes3 normal{all(row.normal[0][i]), all(row.normal[1][i]), all(row.normal[2][i])};
    const Lanes offset = all(row.offset[i]), approach = dot(normal, direction);
    const Lanes3 terms = multiply(normal, origin);
    const Lanes height = hn::Sub(sum(terms), offset);
    const Lanes t = hn::Div(hn::Neg(height), approach);
    const Lanes error = hn::Mul(rounding, hn::Add(sum(abs(terms)), hn::Abs(offset)));
    const auto inside = hn::And(hn::Gt(t, first), hn::Lt(t, last));
    auto is_met = hn::And(inside, hn::Gt(hn::Abs(height), error));
    const auto in_front = hn::Lt(approach, zero);
    if ((row.from_front >> i & 1) == 0) is_met = hn::AndNot(in_front, is_met);
    if ((row.from_behind >> i & 1) == 0) is_met = hn::And(in_front, is_met);
    nearest.take(is_met, t, few.plane_instances[i]);
  }
}

/// BvhKernels::row_met.
void row_met(const FewRows& few, const RayRow& rays, RayRowMet& met) {
  const Lanes first = all(rays.t_min), last = all(rays.t_max);
  met.tests = few.planes.count * rays.count;
  // What is behind the last ray counts for nothing.
  for (size_t at = 0; at < rays.count; at += kLanes) {
    const Lanes3 origin = load(rays.origin, at), direction = load(rays.direction, at);
    Nearest nearest;
    meet_planes(few, origin, direction, first, last, nearest);
    const SlabLanes slabs(origin, direction);
    const auto usual = slabs.are_usual(few.boxes);
    const uint32_t rays_here = bits_of(usual) & ((1u << std::min(kLanes, rays.count - at)) - 1);
    auto bits = hn::IfThenElse(hn::RebindMask(kIndexTag, usual), hn::Zero(kIndexTag),
                               hn::Set(kIndexTag, int64_t{BoxRow::kUnusual}));
    for (size_t i = 0; (few.boxes.all >> i & 1) != 0; ++i) {
      Lanes enter = first;
      auto in = slabs.entered(few.boxes, i, enter, hn::Min(last, nearest.t));
      if ((few.carved_boxes >> i & 1) != 0 && !hn::AllFalse(kLaneTag, in)) {
        met.tests += static_cast<uint64_t>(std::popcount(bits_of(in) & rays_here));
        in = hn::AndNot(meet_carved_box(few.carved[i], origin, direction, last).missed, in);
      }
      if ((few.spheres.boxes >> i & 1) == 0) {
        hn::Store(enter, kLaneTag, met.entered[i] + at);
        const auto bit = hn::Set(kIndexTag, int64_t{1} << i);
        bits = hn::Or(bits, hn::IfThenElseZero(hn::RebindMask(kIndexTag, in), bit));
        continue;
      }
      const uint32_t entering = bits_of(in) & rays_here;
      if (entering == 0) continue;
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
