// Compiled once for each instruction set: vectors with one ray in each lane. The same sums of
// products, in the same order, as for one ray, and none fused.
#if defined(TESSERA_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_LANES_INL_H
#undef TESSERA_LANES_INL_H
#else
#define TESSERA_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstdint>
#include <limits>

#include "renderer/math/arc_table.h"
#include "renderer/math/color.h"
#include "renderer/math/elementary.h"
#include "renderer/math/mask_bits-inl.h"
#include "renderer/math/numbers.h"
#include "renderer/math/rounding.h"
#include "renderer/math/vec.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using LaneTag = hn::CappedTag<double, 8>;
using Lanes = hn::Vec<LaneTag>;
using LaneMask = hn::Mask<LaneTag>;
using LaneIndices = hn::Vec<hn::RebindToSigned<LaneTag>>;
constexpr LaneTag kLaneTag;
constexpr hn::RebindToSigned<LaneTag> kIndexTag;
constexpr size_t kLanes = hn::MaxLanes(LaneTag());

struct Lanes2 {
  Lanes x, y;
};
/// x, y and z, or red, green and blue.
struct Lanes3 {
  Lanes x, y, z;
};

// The names of numbers.h.
using Num = Lanes;
using Num2 = Lanes2;
using Num3 = Lanes3;
using NumColor = Lanes3;
using NumMask = LaneMask;

HWY_INLINE Num num(double value) { return hn::Set(kLaneTag, value); }
HWY_INLINE NumColor num_color(double grey) { return {num(grey), num(grey), num(grey)}; }
HWY_INLINE Num3 num3(double x, double y, double z) { return {num(x), num(y), num(z)}; }
HWY_INLINE Num negated(Num x) { return hn::Neg(x); }
HWY_INLINE Num absolute(Num x) { return hn::Abs(x); }
HWY_INLINE Num floor_of(Num x) { return hn::Floor(x); }
HWY_INLINE Num square_root(Num x) { return hn::Sqrt(x); }
HWY_INLINE Num copy_sign(Num size, Num sign) { return hn::CopySign(size, sign); }
HWY_INLINE Num maximum(Num a, Num b) { return hn::IfThenElse(hn::Lt(a, b), b, a); }
HWY_INLINE bool is_all(NumMask mask) { return hn::AllTrue(kLaneTag, mask); }
HWY_INLINE NumMask both(NumMask a, NumMask b) { return hn::And(a, b); }
HWY_INLINE NumMask either(NumMask a, NumMask b) { return hn::Or(a, b); }
HWY_INLINE NumMask and_not(NumMask a, NumMask b) { return hn::AndNot(b, a); }
HWY_INLINE Num select(NumMask mask, Num yes, Num no) { return hn::IfThenElse(mask, yes, no); }

HWY_INLINE Lanes broadcast(double value) { return num(value); }
HWY_INLINE Lanes3 broadcast(const Vec3& v) { return num3(v.x, v.y, v.z); }
HWY_INLINE Lanes3 broadcast(const Point3& p) {
  return {broadcast(p.x), broadcast(p.y), broadcast(p.z)};
}
HWY_INLINE Lanes3 broadcast(const Color& c) {
  return {broadcast(c.r), broadcast(c.g), broadcast(c.b)};
}

HWY_INLINE Lanes3 operator+(const Lanes3& a, const Lanes3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
HWY_INLINE Lanes3 operator-(const Lanes3& a, const Lanes3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
HWY_INLINE Lanes3 operator-(const Lanes3& a) { return {hn::Neg(a.x), hn::Neg(a.y), hn::Neg(a.z)}; }
HWY_INLINE Lanes3 operator*(const Lanes3& a, const Lanes3& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
HWY_INLINE Lanes3 operator*(const Lanes3& a, Lanes s) { return {a.x * s, a.y * s, a.z * s}; }
HWY_INLINE Lanes3 operator/(const Lanes3& a, Lanes s) { return {a.x / s, a.y / s, a.z / s}; }
HWY_INLINE Lanes3 abs(const Lanes3& a) { return {hn::Abs(a.x), hn::Abs(a.y), hn::Abs(a.z)}; }
HWY_INLINE Lanes sum(const Lanes3& a) { return (a.x + a.y) + a.z; }
HWY_INLINE Lanes l1_norm(const Lanes3& a) { return sum(abs(a)); }
HWY_INLINE Lanes dot(const Lanes3& a, const Lanes3& b) { return sum(a * b); }
HWY_INLINE Lanes3 select(LaneMask mask, const Lanes3& yes, const Lanes3& no) {
  return {hn::IfThenElse(mask, yes.x, no.x), hn::IfThenElse(mask, yes.y, no.y),
          hn::IfThenElse(mask, yes.z, no.z)};
}
/// From arrays of parts, at a place whose vectors are aligned.
template <size_t kPadded>
HWY_INLINE Lanes3 load(const double (&parts)[3][kPadded], size_t at) {
  return {hn::Load(kLaneTag, parts[0] + at), hn::Load(kLaneTag, parts[1] + at),
          hn::Load(kLaneTag, parts[2] + at)};
}
template <size_t kPadded>
HWY_INLINE void store(const Lanes3& a, size_t at, double (&parts)[3][kPadded]) {
  hn::Store(a.x, kLaneTag, parts[0] + at);
  hn::Store(a.y, kLaneTag, parts[1] + at);
  hn::Store(a.z, kLaneTag, parts[2] + at);
}
HWY_INLINE Num max_component(const Lanes3& a) { return maximum(a.x, maximum(a.y, a.z)); }
HWY_INLINE LaneMask is_black(const Lanes3& c) {
  const Lanes zero = hn::Zero(kLaneTag);
  return hn::And(hn::And(hn::Eq(c.x, zero), hn::Eq(c.y, zero)), hn::Eq(c.z, zero));
}

HWY_INLINE uint32_t movemask(LaneMask mask) { return movemask(kLaneTag, mask); }
HWY_INLINE LaneMask mask_of(uint32_t bits) {
  const uint8_t bytes[8] = {static_cast<uint8_t>(bits)};
  return hn::LoadMaskBits(kLaneTag, bytes);
}
HWY_INLINE size_t take_lowest_lane(uint32_t& bits) {
  const auto lane = static_cast<size_t>(std::countr_zero(bits));
  bits &= bits - 1;
  return lane;
}

/// Lanes in memory, to be looked at one by one.
struct Stored3 {
  alignas(64) double x[kLanes], y[kLanes], z[kLanes];

  Stored3() = default;
  HWY_INLINE explicit Stored3(const Lanes3& a) {
    hn::Store(a.x, kLaneTag, x);
    hn::Store(a.y, kLaneTag, y);
    hn::Store(a.z, kLaneTag, z);
  }
  HWY_INLINE Lanes3 load() const {
    return {hn::Load(kLaneTag, x), hn::Load(kLaneTag, y), hn::Load(kLaneTag, z)};
  }
  Vec3 vec(size_t lane) const { return {x[lane], y[lane], z[lane]}; }
  Point3 point(size_t lane) const { return {x[lane], y[lane], z[lane]}; }
  Color color(size_t lane) const { return {x[lane], y[lane], z[lane]}; }
  void put(size_t lane, const Vec3& v) { x[lane] = v.x, y[lane] = v.y, z[lane] = v.z; }
  /// The lanes from `count` on, of one or more, as the first.
  void fill_from(size_t count) {
    for (size_t lane = count; lane < kLanes; ++lane) put(lane, vec(0));
  }
};

inline HWY_NOINLINE void normalize_each(Stored3& v) {
  for (size_t lane = 0; lane < kLanes; ++lane) v.put(lane, tessera::normalize(v.vec(lane)));
}
HWY_INLINE Lanes3 normalize(const Lanes3& v) {
  const Lanes squared = dot(v, v);
  const auto is_safe = hn::And(hn::Gt(squared, broadcast(kLeastSafeSquare)),
                               hn::Lt(squared, broadcast(kMostSafeSquare)));
  if (!hn::AllTrue(kLaneTag, is_safe)) [[unlikely]] {
    Stored3 each(v);
    normalize_each(each);
    return each.load();
  }
  return v / square_root(squared);
}
HWY_INLINE Lanes3 reflect(const Lanes3& v, const Lanes3& n) { return v - n * (num(2) * dot(v, n)); }

/// The next larger value where `way` is positive, the next smaller one where it is negative.
HWY_INLINE Lanes next_towards(Lanes x, Lanes way) {
  const Lanes zero = hn::Zero(kLaneTag);
  const auto down = hn::Lt(way, zero);
  const Lanes up_from = hn::IfThenElse(down, hn::Neg(x), x);
  const auto step = hn::IfThenElse(hn::RebindMask(kIndexTag, hn::Gt(up_from, zero)),
                                   hn::Set(kIndexTag, 1), hn::Set(kIndexTag, -1));
  Lanes up = hn::BitCast(kLaneTag, hn::Add(hn::BitCast(kIndexTag, up_from), step));
  up = hn::IfThenElse(hn::Eq(up_from, zero), broadcast(std::numeric_limits<double>::denorm_min()),
                      up);
  const auto has_next = hn::Lt(up_from, broadcast(std::numeric_limits<double>::infinity()));
  up = hn::IfThenElse(has_next, up, up_from);
  const auto moves = hn::Or(hn::Gt(way, zero), down);
  return hn::IfThenElse(moves, hn::IfThenElse(down, hn::Neg(up), up), x);
}

/// As DoubleDouble.
struct NumPair {
  Num high, low;
};

#include "renderer/math/exact_sums-inl.h"

inline HWY_NOINLINE Lanes atan2_each(Lanes y, Lanes x, uint32_t which, Lanes angle) {
  alignas(64) double ys[kLanes], xs[kLanes], angles[kLanes];
  hn::Store(y, kLaneTag, ys);
  hn::Store(x, kLaneTag, xs);
  hn::Store(angle, kLaneTag, angles);
  while (which != 0) {
    const size_t lane = take_lowest_lane(which);
    angles[lane] = portable::atan2(ys[lane], xs[lane]);
  }
  return hn::Load(kLaneTag, angles);
}

/// portable::atan2() to the last bit: its quick way, and where that is not sure the function
/// itself.
HWY_INLINE Lanes arc_tangent(Lanes of_y, Lanes x) {
  using Arc = portable::QuickArc;
  const auto term = [](Lanes z, double a, double b)
                        HWY_ATTR { return z * broadcast(a) + broadcast(b); };
  const Lanes zero = hn::Zero(kLaneTag), y = hn::Abs(of_y), ax = hn::Abs(x);
  const auto left = hn::Lt(x, zero), steep = hn::Gt(y, ax);
  Lanes large = hn::IfThenElse(steep, y, ax), small = hn::IfThenElse(steep, ax, y);
  const auto in_range =
      hn::And(hn::And(hn::Lt(large, broadcast(Arc::kMost)), hn::Gt(large, broadcast(Arc::kLeast))),
              hn::Gt(small, large * broadcast(Arc::kLeastRatio)));
  large = hn::IfThenElse(in_range, large, broadcast(1));
  small = hn::IfThenElse(in_range, small, broadcast(1));
  const Lanes n = hn::Trunc(term(small / large, 8, Arc::kNearlyHalf));
  const Lanes c = n * broadcast(0.125);
  const auto leading = [](Lanes v) HWY_ATTR {
    const hn::RebindToUnsigned<LaneTag> bits;
    return hn::BitCast(kLaneTag, hn::And(hn::BitCast(bits, v), hn::Set(bits, ~Arc::kLastBits)));
  };
  const Lanes large_high = leading(large), small_high = leading(small);
  const Lanes across = small - c * large_high - c * (large - large_high);
  const Lanes more = c * small;
  const NumPair along = fast_two_sum(large, more);
  const Lanes along_low = along.low + (c * small_high - more + c * (small - small_high));
  const Lanes t = across / along.high, inverse = broadcast(1) / along.high;
  const NumPair back = two_product(t, along.high);
  const Lanes t_low = (across - back.high - back.low - t * along_low) * inverse;
  const Lanes z = t * t, zz = z * z;
  const Lanes last = term(z, Arc::k13, Arc::k11) - zz / broadcast(Arc::kBy15);
  const Lanes p = z * (term(z, Arc::k5, Arc::k3) + zz * (term(z, Arc::k9, Arc::k7) + zz * last));
  const auto forward = hn::Or(hn::And(left, steep), hn::Not(hn::Or(left, steep)));
  const Lanes sign = hn::IfThenElse(forward, broadcast(1), broadcast(-1));
  const auto axis = [&](double of_steep, double of_left) HWY_ATTR {
    return hn::IfThenElse(steep, broadcast(of_steep), hn::IfThenElseZero(left, broadcast(of_left)));
  };
  alignas(64) double steps[kLanes];
  hn::Store(n, kLaneTag, steps);
  alignas(64) double arc_high[kLanes], arc_low[kLanes];
  for (size_t lane = 0; lane < kLanes; ++lane) {
    const DoubleDouble& arc = portable::kArc[static_cast<int>(steps[lane])];
    arc_high[lane] = arc.high, arc_low[lane] = arc.low;
  }
  const NumPair begin =
      two_sum(axis(portable::kPi2.high, portable::kPiDd.high), sign * hn::Load(kLaneTag, arc_high));
  const NumPair sum = fast_two_sum(begin.high, sign * t);
  const Lanes tail = t * p;
  const Lanes rest = sign * (hn::Load(kLaneTag, arc_low) + t_low);
  const Lanes from_axis = axis(portable::kPi2.low, portable::kPiDd.low) + rest;
  const Lanes low = sum.low + (begin.low + from_axis) + sign * tail;
  const Lanes doubt =
      hn::Abs(tail) * broadcast(Arc::kTailDoubt) + sum.high * broadcast(Arc::kSumDoubt);
  const auto is_sure =
      hn::And(in_range, hn::Eq(sum.high + (low - doubt), sum.high + (low + doubt)));
  const Lanes angle = hn::CopySign(sum.high + low, of_y);
  const uint32_t unsure = movemask(hn::Not(is_sure));
  return unsure == 0 ? angle : atan2_each(of_y, x, unsure, angle);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
