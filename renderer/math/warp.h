#pragma once

#include "renderer/math/elementary.h"
#include "renderer/math/numbers.h"

namespace tessera {

// From points spread evenly over the unit square to points spread evenly elsewhere.

#include "renderer/math/warp-inl.h"

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
