#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "renderer/accel/traversal_tree.h"
#include "renderer/accel/wide_tree.h"
#include "renderer/shapes/ray.h"

namespace tessera {

/// A ray as the box tests want it. A box [low, high] is entered on axis a at
///   boxes[near_row] * inverse - enter_offset   and left at   boxes[far_row] * inverse -
///   leave_offset,
/// where the offsets take in a margin that covers every rounding here and in the exact tests of
/// what the box holds: no box with a hit is missed (after Ize, JCGT 2(2), 2013). Nothing in it is
/// NaN or infinite, axis-parallel rays included. Real is float; double for rays outside of float's
/// range, and where float is too coarse for the tree.
template <typename Real>
struct BoxRay {
  alignas(16) Real inverse[4], enter_offset[4], leave_offset[4];  ///< the fourth is not used
  int near_row[3];                                                ///< the far row is near_row ^ 1
  Real t_min, t_max;  ///< in single precision not negative
  double t_shift;  ///< t of the point that the box test starts from: where the ray enters the whole
  double t_slack;  ///< in double only: see BoxMargin::time

  static constexpr double kMargin = BoxMargin::kUsual;

  /// An upper bound in box-test terms for hits up to `t`.
  Real limit(double t) const {
    if constexpr (std::is_same_v<Real, double>)
      return (t - t_shift) + (std::abs(t) * kMargin + t_slack);
    else
      return static_cast<Real>((t - t_shift) + t * kMargin);
  }
};

/// What both precisions need first. Written without branches on signs: directions are random.
struct RayFrame {
  double origin[3];  ///< moved to where the ray enters the whole, if it starts far away
  double inverse[3];
  double t_shift, t_min, t_max, t_slack;
  double margin;  ///< in space, on each axis
  bool misses, fits_float;
};

inline double largest(const double* v) {
  return std::max(std::max(std::abs(v[0]), std::abs(v[1])), std::abs(v[2]));
}

/// Moves the origin of a ray from far away, where single precision is coarse, to the whole's box.
inline void move_origin(RayFrame& f, const double* d, const Bounds3& whole, double extent,
                        double shortest, double far_origin, double margin) {
  constexpr double kInf = Bounds3::kInfinity;
  const double low[3] = {whole.min.x, whole.min.y, whole.min.z};
  const double high[3] = {whole.max.x, whole.max.y, whole.max.z};
  const double pad = (far_origin + extent) * 0x1p-40;
  double enter = std::min(0.0, f.t_min),
         leave = f.t_max + std::abs(f.t_max) * BoxRay<float>::kMargin;
  for (int a = 0; a < 3; ++a) {
    const bool matters = std::abs(d[a]) >= shortest;
    const double t0 = ((low[a] - pad) - f.origin[a]) * f.inverse[a];
    const double t1 = ((high[a] + pad) - f.origin[a]) * f.inverse[a];
    enter = std::max(enter, matters ? std::min(t0, t1) : -kInf);
    leave = std::min(leave, matters ? std::max(t0, t1) : kInf);
  }
  f.misses = enter > leave + std::abs(leave) * 0x1p-40;
  f.t_shift = std::max(0.0, enter);
  for (int a = 0; a < 3; ++a) f.origin[a] += d[a] * f.t_shift;
  const double size = std::max(extent, largest(f.origin));
  f.margin = size * margin + far_origin * 0x1p-46;
  f.fits_float = f.fits_float && size < 1e15;
}

inline RayFrame make_ray_frame(const Ray& ray, double t_max, const Bounds3& whole, double extent,
                               const BoxMargin& margin = {}) {
  const double d[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
  RayFrame f{.origin = {ray.origin.x, ray.origin.y, ray.origin.z},
             .inverse = {},
             .t_shift = 0,
             .t_min = ray.t_min,
             .t_max = t_max,
             .t_slack = 0,
             .margin = 0,
             .misses = false,
             .fits_float = false};
  const double longest = largest(d), far_origin = largest(f.origin);
  if (margin.time > 0) f.t_slack = extent / longest * margin.time;
  // A component too short to matter within the scene's extent gets a finite reciprocal; the margin
  // makes up for it.
  const double shortest = longest * margin.space * 0x1p-11;
  for (int a = 0; a < 3; ++a)
    f.inverse[a] = 1 / (std::abs(d[a]) >= shortest ? d[a] : std::copysign(shortest, d[a]));
  // Then no product of sizes and reciprocals overflows or underflows.
  f.fits_float = extent > 1e-15 && extent < 1e14 && longest > 1e-9 && longest < 1e9 && f.t_min >= 0;
  if (far_origin <= 4 * extent) [[likely]]
    f.margin = std::max(extent, far_origin) * margin.space;
  else
    move_origin(f, d, whole, extent, shortest, far_origin, margin.space);
  return f;
}

template <typename Real>
inline BoxRay<Real> make_box_ray(const RayFrame& f) {
  BoxRay<Real> b;
  for (int a = 0; a < 3; ++a) {
    const Real inverse = static_cast<Real>(f.inverse[a]);
    const double at = f.origin[a] * double{inverse};
    const double slack = f.margin * std::abs(double{inverse});
    b.inverse[a] = inverse;
    b.enter_offset[a] = static_cast<Real>(at + slack);
    b.leave_offset[a] = static_cast<Real>(at - slack);
    const int backward = std::signbit(f.inverse[a]) ? 1 : 0;
    b.near_row[a] = 2 * a + backward;
  }
  b.t_shift = f.t_shift;
  b.t_slack = f.t_slack;
  // In double all from the origin on: the margin may be too small to tell apart what is about
  // t_min.
  const double t_min = std::is_same_v<Real, double> ? std::min(f.t_min, 0.0) : f.t_min;
  b.t_min = static_cast<Real>((t_min - f.t_shift) - std::abs(f.t_min) * BoxRay<Real>::kMargin -
                              f.t_slack);
  if (std::is_same_v<Real, float>) b.t_min = std::max(b.t_min, Real{0}) + Real{0};  // never -0
  b.t_max = b.limit(f.t_max);
  return b;
}

/// The usual case, all in single precision, four lanes at a time: false where make_ray_frame() must
/// look closer. Of the margin, 2^-19 of the largest coordinate, at most 10/32 are used up by
/// rounding: of origin, direction, reciprocal, offset and box test. `kJustMade`: the ray was
/// probably written a moment ago.
template <bool kJustMade = false>
[[gnu::always_inline]] inline bool make_usual_box_ray(const Ray& ray, double t_max, float extent,
                                                      BoxRay<float>& b) {
  using FourFloats = float __attribute__((vector_size(16)));
  using FourInts = int32_t __attribute__((vector_size(16)));
  using TwoLongs = int64_t __attribute__((vector_size(16)));
  using FourDoubles = double __attribute__((vector_size(32)));
  const FourInts used{-1, -1, -1, 0}, sign{INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN};
  const auto absolute = [&](FourFloats v) { return (FourFloats)((FourInts)v & ~sign & used); };
  FourDoubles origin, direction;
  if constexpr (kJustMade) {
    // A wide load of what was written in parts waits until it has left for the cache.
    origin = FourDoubles{ray.origin.x, ray.origin.y, ray.origin.z, 0};
    direction = FourDoubles{ray.direction.x, ray.direction.y, ray.direction.z, 0};
  } else {
    // Four at a time with what lies behind them, which no lane in use sees.
    static_assert(offsetof(Ray, direction) == 24 && offsetof(Ray, t_min) == 48);
    std::memcpy(&origin, reinterpret_cast<const char*>(&ray), sizeof origin);
    std::memcpy(&direction, reinterpret_cast<const char*>(&ray) + 24, sizeof direction);
  }
  const FourFloats o = __builtin_convertvector(origin, FourFloats);
  const FourFloats d = __builtin_convertvector(direction, FourFloats);
  const FourFloats far = absolute(o), steep = absolute(d);
  const auto largest_lane = [](FourFloats v) {
    FourFloats w = __builtin_shufflevector(v, v, 1, 0, 3, 2);
    v = v > w ? v : w;
    w = __builtin_shufflevector(v, v, 2, 3, 0, 1);
    return v > w ? v : w;
  };
  const FourFloats whole = FourFloats{} + extent;
  const FourFloats longest = largest_lane(steep), farthest = largest_lane(far);
  // Written so that what is not a number is not usual.
  const TwoLongs usual = (TwoLongs)((far <= 4 * whole) & (steep <= 1e9f) & (longest >= 1e-9f) &
                                    (whole >= 1e-15f) & (whole <= 1e14f));
  if ((usual[0] & usual[1]) != -1 || !(ray.t_min >= 0)) [[unlikely]]
    return false;
  // A component too short to matter within the scene gets a finite reciprocal.
  const FourInts backward = (FourInts)d & sign;
  const FourFloats largest_inverse = FourFloats{} + 1e18f;
  FourFloats inverse = 1 / d;
  inverse = inverse < largest_inverse ? inverse : largest_inverse;
  inverse = inverse > -largest_inverse ? inverse : -largest_inverse;
  const FourFloats at = o * inverse;
  const FourFloats margin =
      (whole > farthest ? whole : farthest) * static_cast<float>(BoxRay<float>::kMargin);
  const FourFloats slack = margin * (FourFloats)((FourInts)inverse & ~sign);
  const FourFloats enter = at + slack, leave = at - slack;
  std::memcpy(b.inverse, &inverse, sizeof inverse);
  std::memcpy(b.enter_offset, &enter, sizeof enter);
  std::memcpy(b.leave_offset, &leave, sizeof leave);
  for (int a = 0; a < 3; ++a) b.near_row[a] = 2 * a + (backward[a] < 0 ? 1 : 0);
  b.t_shift = 0;
  b.t_min = static_cast<float>(ray.t_min * (1 - BoxRay<float>::kMargin)) + 0.0f;  // never -0
  b.t_max = b.limit(t_max);
  return true;
}

}  // namespace tessera
