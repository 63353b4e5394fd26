#include "renderer/shapes/line_box.h"

namespace tessera {

LineRange line_range_of_any(const Bounds3& box, const Ray& ray) {
  LineRange range;
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
