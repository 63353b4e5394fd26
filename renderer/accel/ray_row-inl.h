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
#include <cstdint>
#include <limits>

#include "renderer/accel/box_row.h"
#include "renderer/accel/plane_row.h"
#include "renderer/accel/ray_row.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/ray.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// As many rays as there are lanes.
class RayLaneRow {
 public:
  using Tag = hn::CappedTag<double, 8>;
  using Lanes = hn::Vec<Tag>;
  using Mask = hn::Mask<Tag>;
  static constexpr size_t kCount = hn::MaxLanes(Tag());

  /// From the ray at `at` on; what is not set counts for nothing.
  HWY_INLINE RayLaneRow(const RayRow& rays, size_t at)
      : at_(at),
        ox_(hn::Load(tag_, rays.origin[0] + at)),
        oy_(hn::Load(tag_, rays.origin[1] + at)),
        oz_(hn::Load(tag_, rays.origin[2] + at)),
        dx_(hn::Load(tag_, rays.direction[0] + at)),
        dy_(hn::Load(tag_, rays.direction[1] + at)),
        dz_(hn::Load(tag_, rays.direction[2] + at)),
        first_(all(rays.t_min)),
        last_(all(rays.t_max)) {}

  /// Plane::intersect() with each plane, line by line, and no product fused with a sum.
  HWY_INLINE void meet(const PlaneRow& row, RayRowMet& met) const {
    const Lanes rounding = all(gamma(4)), zero = hn::Zero(tag_);
    Lanes nearest = all(std::numeric_limits<double>::infinity());
    Lanes number = all(RayRowMet::kNone);
    for (size_t i = 0; i < row.count; ++i) {
      const Lanes nx = all(row.normal[0][i]), ny = all(row.normal[1][i]),
                  nz = all(row.normal[2][i]), offset = all(row.offset[i]);
      const Lanes approach = sum(hn::Mul(nx, dx_), hn::Mul(ny, dy_), hn::Mul(nz, dz_));
      const Lanes x = hn::Mul(nx, ox_), y = hn::Mul(ny, oy_), z = hn::Mul(nz, oz_);
      const Lanes height = hn::Sub(sum(x, y, z), offset);
      const Lanes t = hn::Div(hn::Neg(height), approach);
      const Lanes error =
          hn::Mul(rounding, hn::Add(sum(hn::Abs(x), hn::Abs(y), hn::Abs(z)), hn::Abs(offset)));
      const auto inside = hn::And(hn::Gt(t, first_), hn::And(hn::Lt(t, last_), hn::Lt(t, nearest)));
      auto is_met = hn::And(inside, hn::Gt(hn::Abs(height), error));
      const bool from_front = (row.from_front >> i & 1) != 0;
      const bool from_behind = (row.from_behind >> i & 1) != 0;
      const auto in_front = hn::Lt(approach, zero);
      if (!from_front) is_met = hn::AndNot(in_front, is_met);
      if (!from_behind) is_met = hn::And(in_front, is_met);
      nearest = hn::IfThenElse(is_met, t, nearest);
      number = hn::IfThenElse(is_met, all(static_cast<double>(i)), number);
    }
    hn::Store(nearest, tag_, met.plane_t + at_);
    hn::Store(number, tag_, met.plane + at_);
  }

  /// BvhKernels::boxes_entered, before the plane that was met.
  HWY_INLINE void enter(const BoxRow& row, RayRowMet& met) const {
    const Lanes far = sum(hn::Abs(ox_), hn::Abs(oy_), hn::Abs(oz_));
    const Lanes steep = sum(hn::Abs(dx_), hn::Abs(dy_), hn::Abs(dz_));
    const auto usual = hn::And(hn::Le(far, all(row.farthest)),
                               hn::And(hn::Ge(steep, all(1e-150)), hn::Le(steep, all(1e150))));
    constexpr hn::RebindToSigned<Tag> index;
    auto boxes = hn::IfThenElse(hn::RebindMask(index, usual), hn::Zero(index),
                                hn::Set(index, int64_t{BoxRow::kUnusual}));
    const Lanes rx = inverse_of(dx_), ry = inverse_of(dy_), rz = inverse_of(dz_);
    const Lanes fx = hn::Mul(ox_, rx), fy = hn::Mul(oy_, ry), fz = hn::Mul(oz_, rz);
    const Lanes end = hn::Min(last_, hn::Load(tag_, met.plane_t + at_));
    for (size_t i = 0; (row.all >> i & 1) != 0; ++i) {
      Lanes enter = first_, leave = end;
      const auto narrow = [&](const double* min, const double* max, Lanes inverse, Lanes offset)
                              HWY_ATTR {
                                const Lanes a = hn::MulSub(all(min[i]), inverse, offset);
                                const Lanes b = hn::MulSub(all(max[i]), inverse, offset);
                                enter = hn::Max(enter, hn::Min(a, b));
                                leave = hn::Min(leave, hn::Max(a, b));
                              };
      narrow(row.min[0], row.max[0], rx, fx);
      narrow(row.min[1], row.max[1], ry, fy);
      narrow(row.min[2], row.max[2], rz, fz);
      hn::Store(enter, tag_, met.entered[i] + at_);
      const auto is_in = hn::RebindMask(index, hn::Le(enter, leave));
      boxes = hn::Or(boxes, hn::IfThenElseZero(is_in, hn::Set(index, int64_t{1} << i)));
    }
    hn::Store(boxes, index, met.boxes + at_);
  }

 private:
  static HWY_INLINE Lanes all(double value) { return hn::Set(Tag(), value); }
  static HWY_INLINE Lanes sum(Lanes a, Lanes b, Lanes c) { return hn::Add(hn::Add(a, b), c); }
  /// As SlabAxis.
  static HWY_INLINE Lanes inverse_of(Lanes direction) {
    constexpr double kSteepest = 1e200;
    return hn::Max(all(-kSteepest), hn::Min(hn::Div(all(1), direction), all(kSteepest)));
  }

  static constexpr Tag tag_{};
  size_t at_;
  Lanes ox_, oy_, oz_, dx_, dy_, dz_, first_, last_;
};

/// BvhKernels::row_met.
void row_met(const PlaneRow& planes, const BoxRow& boxes, const RayRow& rays, RayRowMet& met) {
  for (size_t at = 0; at < rays.count; at += RayLaneRow::kCount) {
    const RayLaneRow lanes(rays, at);
    lanes.meet(planes, met);
    lanes.enter(boxes, met);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
