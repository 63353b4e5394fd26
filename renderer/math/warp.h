#pragma once

#include "renderer/math/elementary.h"
#include "renderer/math/vec.h"

namespace tessera {

// From points spread evenly over the unit square to points spread evenly elsewhere.

/// Sine and cosine of |x| <= pi / 4, to 1e-13, by their series: in pairs of terms, which do not
/// wait for each other.
inline Vec2 small_sine_cosine(double x) {
  const double q = x * x, q2 = q * q, q4 = q2 * q2;
  const double sine = (1 - q * (1.0 / 6)) + q2 * (1.0 / 120 - q * (1.0 / 5040)) +
                      q4 * ((1.0 / 362880 - q * (1.0 / 39916800)) + q2 * (1.0 / 6227020800));
  const double cosine =
      (1 - q * (1.0 / 2)) + q2 * (1.0 / 24 - q * (1.0 / 720)) +
      q4 * ((1.0 / 40320 - q * (1.0 / 3628800)) + q2 * (1.0 / 479001600 - q * (1.0 / 87178291200)));
  return {x * sine, cosine};
}

// small_sine_cosine() and cosine_hemisphere_point() also stand in lane_lambert-inl.h, a lane each,
// to the bit.

/// Uniform over the unit disc, neighbours staying neighbours (Shirley and Chiu 1997).
inline Vec2 disc_point(const Vec2& u) {
  const double a = 2 * u.x - 1, b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {0, 0};
  // Which one is longer is a matter of chance: chosen without a branch.
  const bool wide = std::abs(a) > std::abs(b);
  const double longer = wide ? a : b, shorter = wide ? b : a;
  const Vec2 turn = small_sine_cosine(portable::kPi / 4 * (shorter / longer));
  const double along = longer * turn.y, across = longer * turn.x;
  return {wide ? along : across, wide ? across : along};
}

/// Over the hemisphere about +z by the cosine; its density is z / pi (Malley's method).
inline Vec3 cosine_hemisphere_point(const Vec2& u) {
  const Vec2 d = disc_point(u);
  return {d.x, d.y, std::sqrt(std::max(0.0, 1 - d.x * d.x - d.y * d.y))};
}

/// The unit vector about +z at azimuth 2 pi `u` and the given z.
inline Vec3 direction_at(double z, double u) {
  const double r = std::sqrt(std::max(0.0, 1 - z * z)), azimuth = 2 * portable::kPi * u;
  return {r * portable::cos(azimuth), r * portable::sin(azimuth), z};
}

/// Barycentric weights of the corners 1 and 2 of a triangle, uniform over its area (Heitz 2019, "A
/// Low-Distortion Map Between Triangle and Square").
inline Vec2 triangle_point(const Vec2& u) {
  if (u.y > u.x) {
    const double x = u.x / 2;
    return {x, u.y - x};
  }
  const double y = u.y / 2;
  return {u.x - y, y};
}

}  // namespace tessera
