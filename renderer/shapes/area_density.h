#pragma once

#include <cmath>

#include "renderer/math/rounding.h"
#include "renderer/math/transform.h"
#include "renderer/math/vec.h"

namespace tessera {

/// Per steradian as seen from `from`, of the point `there` chosen evenly over `area`; 0 where the
/// surface is seen edge-on.
inline double density_by_area(double area, const Point3& from, const Point3& there,
                              const Vec3& normal) {
  const Vec3 way = there - from;
  const double squared = length_squared(way), facing = std::abs(dot(way, normal));
  return facing > 0 ? squared * std::sqrt(squared) / (facing * area) : 0;
}

/// By what the transform of that matrix makes a small area larger whose normal becomes `normal`, of
/// unit length.
inline double area_growth(const Affine& m, const Vec3& normal) {
  // It grows by |det| |M^-T n'|, n' its normal before.
  Vec3 before;
  for (size_t axis = 0; axis < 3; ++axis) {
    before[static_cast<int>(axis)] =
        m.m[0][axis] * normal.x + m.m[1][axis] * normal.y + m.m[2][axis] * normal.z;
  }
  return std::abs(m.determinant()) / length(before);
}

/// `normal` of a shape as it stands in the world; unit.
inline Vec3 unit_normal(const Transform& world_from_object, const Vec3& normal, bool flip) {
  const Vec3 n = normalize(static_cast<Vec3>(world_from_object.normal(to_normal(normal))));
  return flip ? -n : n;
}

/// A bound of what rounding makes of a point of a shape that reaches so far.
inline Vec3 rounding_of(const Point3& p, double extent) {
  return Vec3{gamma(6) * (std::abs(p.x) + extent), gamma(6) * (std::abs(p.y) + extent),
              gamma(6) * (std::abs(p.z) + extent)};
}

}  // namespace tessera
