#pragma once

#include <algorithm>

#include "renderer/math/bounds.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/ray.h"

namespace tessera {

/// Where the whole line of a ray is inside a box, grown outward by far more than the rounding of
/// any hit inside it. A larger box gives a range at least as large, to the bit.
struct LineRange {
  double low = -Bounds3::kInfinity, high = Bounds3::kInfinity;
  bool empty() const { return !(low <= high); }
};

inline LineRange line_range(const Bounds3& box, const Ray& ray) {
  LineRange range;
  if (box.empty()) return {1, 0};
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis], d = ray.direction[axis];
    if (d == 0) {
      if (!(o >= box.min[axis] && o <= box.max[axis])) return {1, 0};
      continue;
    }
    const double t0 = (box.min[axis] - o) / d, t1 = (box.max[axis] - o) / d;
    const double low = std::min(t0, t1), high = std::max(t0, t1);
    range.low = std::max(range.low, low - gamma(32) * std::abs(low));
    range.high = std::min(range.high, high + gamma(32) * std::abs(high));
  }
  return range;
}

}  // namespace tessera
