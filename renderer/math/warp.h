#pragma once

#include "renderer/math/elementary.h"
#include "renderer/math/vec.h"

namespace tessera {

// From points spread evenly over the unit square to points spread evenly elsewhere.

/// Uniform over the unit disc, neighbours staying neighbours (Shirley and Chiu 1997).
inline Vec2 disc_point(const Vec2& u) {
  const double a = 2 * u.x - 1, b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {0, 0};
  constexpr double kQuarter = portable::kPi / 4;
  if (std::abs(a) > std::abs(b)) {
    const double angle = kQuarter * (b / a);
    return {a * portable::cos(angle), a * portable::sin(angle)};
  }
  const double angle = kQuarter * (a / b);
  return {b * portable::sin(angle), b * portable::cos(angle)};
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
