#include "renderer/accel/rectangle_soa.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace tessera {

bool RectangleSoA::can_hold(const Rectangle& rectangle) {
  constexpr double kLeastSquare = 1e-60, kFarthest = 1e30;
  const Bounds3 box = rectangle.bounds();
  const double area = length_squared(rectangle.normal());
  return area > kLeastSquare && max_component(abs(box.min - Point3{})) < kFarthest &&
         max_component(abs(box.max - Point3{})) < kFarthest;
}

void RectangleSoA::add(const Rectangle& rectangle) {
  TESSERA_CHECK(count < kMost, "more rectangles than fit");
  const Vec3 &n = rectangle.normal(), &by_u = rectangle.share_u(), &by_v = rectangle.share_v();
  for (int a = 0; a < 3; ++a) {
    corner[a][count] = rectangle.corner()[a];
    normal[a][count] = n[a];
    share_u[a][count] = by_u[a];
    share_v[a][count] = by_v[a];
    extent = std::max(
        {extent, std::abs(rectangle.bounds().min[a]), std::abs(rectangle.bounds().max[a])});
  }
  axis[count] = rectangle.axis();
  grazing[count] = kGrazing * length(n);
  out_u[count] = length(by_u);
  out_v[count] = length(by_v);
  all |= 1u << count++;
}

void RectangleSoA::finish() {
  constexpr size_t kLanes = 4, kFar = 6;
  farthest = kFar * extent;
  for (size_t i = 0; i < count; ++i) {
    const double margin_u = kMargin * extent * out_u[i], margin_v = kMargin * extent * out_v[i];
    in_u[i] = 0.5 - margin_u, out_u[i] = 0.5 + margin_u;
    in_v[i] = 0.5 - margin_v, out_v[i] = 0.5 + margin_v;
  }
  count = (count + kLanes - 1) / kLanes * kLanes;
}

}  // namespace tessera
