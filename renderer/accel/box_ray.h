#pragma once

#include <algorithm>
#include <cmath>

#include "renderer/accel/wide_tree.h"
#include "renderer/shapes/ray.h"

namespace tessera {

/// A ray as the box tests want it. A box [low, high] is entered on axis a at
///   boxes[near_row] * inverse - enter_offset   and left at   boxes[far_row] * inverse -
///   leave_offset,
/// where the offsets take in a margin that covers every rounding here and in the exact tests of
/// what the box holds: no box with a hit is missed (after Ize, JCGT 2(2), 2013). Nothing in it is
/// NaN or infinite, axis-parallel rays included. Real is float; double for rays outside of float's
/// range.
template <typename Real>
struct BoxRay {
  Real inverse[3], enter_offset[3], leave_offset[3];
  int near_row[3], far_row[3];
  Real t_min, t_max;
  double t_shift;  ///< t of the point that the box test starts from: where the ray enters the whole

  static constexpr double kMargin = 0x1p-20;

  /// An upper bound in box-test terms for hits up to `t`.
  Real limit(double t) const { return static_cast<Real>((t - t_shift) + t * kMargin); }
};

/// What both precisions need first.
struct RayFrame {
  Point3 origin;  ///< moved to where the ray enters the whole
  Vec3 inverse;
  double t_shift = 0;
  double margin = 0;  ///< in space, on each axis
  bool misses = false;
  bool fits_float = false;
};

inline RayFrame make_ray_frame(const Ray& ray, const Bounds3& whole, double extent) {
  RayFrame f;
  const Vec3& d = ray.direction;
  const double longest = max_component(abs(d));
  const double far_origin =
      std::max(std::max(std::abs(ray.origin.x), std::abs(ray.origin.y)), std::abs(ray.origin.z));
  // A component too short to matter within the scene's extent gets a finite reciprocal; the margin
  // makes up for it.
  const double shortest = longest * 0x1p-30;
  double enter = std::min(0.0, ray.t_min), leave = ray.t_max * (1 + BoxRay<double>::kMargin);
  const double pad = (far_origin + extent) * 0x1p-40;
  for (int a = 0; a < 3; ++a) {
    if (!(std::abs(d[a]) >= shortest)) {
      f.inverse[a] = 1 / std::copysign(shortest, d[a]);
      continue;
    }
    f.inverse[a] = 1 / d[a];
    const bool down = d[a] < 0;
    const double low = whole.min[a] - pad, high = whole.max[a] + pad;
    enter = std::max(enter, ((down ? high : low) - ray.origin[a]) * f.inverse[a]);
    leave = std::min(leave, ((down ? low : high) - ray.origin[a]) * f.inverse[a]);
  }
  f.misses = enter > leave * (1 + 0x1p-40);
  f.t_shift = std::max(0.0, enter);
  f.origin = enter > 0 ? ray.at(enter) : ray.origin;
  const double near_origin =
      std::max(std::max(std::abs(f.origin.x), std::abs(f.origin.y)), std::abs(f.origin.z));
  const double size = std::max(extent, near_origin);
  f.margin = size * BoxRay<float>::kMargin + far_origin * 0x1p-46;
  // Products of size and reciprocals must neither overflow nor underflow.
  f.fits_float = size > 1e-25 && size < 1e25 && size / shortest < 1e36 && size / longest > 1e-25 &&
                 1 / longest > 1e-25 && 1 / shortest < 1e36;
  return f;
}

template <typename Real>
BoxRay<Real> make_box_ray(const Ray& ray, const RayFrame& f) {
  BoxRay<Real> b;
  for (int a = 0; a < 3; ++a) {
    const Real inverse = static_cast<Real>(f.inverse[a]);
    const double at = f.origin[a] * double{inverse};
    const double slack = f.margin * std::abs(double{inverse});
    b.inverse[a] = inverse;
    b.enter_offset[a] = static_cast<Real>(at + slack);
    b.leave_offset[a] = static_cast<Real>(at - slack);
    b.near_row[a] = 2 * a + (f.inverse[a] < 0 ? 1 : 0);
    b.far_row[a] = 2 * a + (f.inverse[a] < 0 ? 0 : 1);
  }
  b.t_shift = f.t_shift;
  b.t_min =
      static_cast<Real>((ray.t_min - f.t_shift) - std::abs(ray.t_min) * BoxRay<Real>::kMargin);
  b.t_max = b.limit(ray.t_max);
  return b;
}

}  // namespace tessera
