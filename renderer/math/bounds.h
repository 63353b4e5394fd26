#pragma once

#include <algorithm>
#include <limits>

#include "renderer/math/vec.h"

namespace tessera {

/// An axis-aligned box, closed; empty where min > max on any axis.
struct Bounds3 {
  Point3 min{kInfinity, kInfinity, kInfinity};
  Point3 max{-kInfinity, -kInfinity, -kInfinity};

  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  static Bounds3 everywhere() {
    return {{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}};
  }

  bool empty() const { return min.x > max.x || min.y > max.y || min.z > max.z; }
  void extend(const Point3& p) {
    for (int a = 0; a < 3; ++a) {
      min[a] = std::min(min[a], p[a]);
      max[a] = std::max(max[a], p[a]);
    }
  }
  void extend(const Bounds3& b) {
    for (int a = 0; a < 3; ++a) {
      min[a] = std::min(min[a], b.min[a]);
      max[a] = std::max(max[a], b.max[a]);
    }
  }
  Vec3 diagonal() const { return max - min; }
  Point3 center() const { return min + diagonal() * 0.5; }
  bool contains(const Point3& p) const {
    return p.x >= min.x && p.x <= max.x && p.y >= min.y && p.y <= max.y && p.z >= min.z &&
           p.z <= max.z;
  }
  friend bool operator==(const Bounds3&, const Bounds3&) = default;
};

}  // namespace tessera
