#pragma once

#include <algorithm>
#include <cmath>

#include "renderer/math/bounds.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/ray.h"

namespace tessera {

/// Where the whole line of a ray is inside a box, grown outward by far more than the rounding of
/// any hit inside it. A larger box gives a range at least as large, bit for bit.
struct LineRange {
  double low = -Bounds3::kInfinity, high = Bounds3::kInfinity;
  bool empty() const { return !(low <= high); }
};

/// One over each part of a line's direction, for the boxes that it is held against.
struct LineInverse {
  explicit LineInverse(const Vec3& direction)
      : x(1 / direction.x),
        y(1 / direction.y),
        z(1 / direction.z),
        // Further out a product with a distance of a box may be no number.
        is_usual(is_in_reach(x) && is_in_reach(y) && is_in_reach(z)) {}

  double x, y, z;
  bool is_usual;

 private:
  static bool is_in_reach(double v) { return std::abs(v) < 1e100; }
};

/// line_range() of a line along some axis, or nearly so.
LineRange line_range_of_any(const Bounds3& box, const Ray& ray);

inline LineRange line_range(const Bounds3& box, const Ray& ray, const LineInverse& inverse) {
  if (box.empty()) return {1, 0};
  if (!inverse.is_usual) [[unlikely]]
    return line_range_of_any(box, ray);
  LineRange range;
  const auto narrow = [&](double min, double max, double o, double scale) {
    const double t0 = (min - o) * scale, t1 = (max - o) * scale;
    const double low = std::min(t0, t1), high = std::max(t0, t1);
    range.low = std::max(range.low, low - gamma(32) * std::abs(low));
    range.high = std::min(range.high, high + gamma(32) * std::abs(high));
  };
  narrow(box.min.x, box.max.x, ray.origin.x, inverse.x);
  narrow(box.min.y, box.max.y, ray.origin.y, inverse.y);
  narrow(box.min.z, box.max.z, ray.origin.z, inverse.z);
  return range;
}

}  // namespace tessera
