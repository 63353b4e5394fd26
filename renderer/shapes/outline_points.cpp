#include "renderer/shapes/outline_points.h"

#include "renderer/math/elementary.h"

namespace tessera {

std::vector<Point3> box_corners(const Bounds3& box) {
  std::vector<Point3> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back({i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                       i & 4 ? box.max.z : box.min.z});
  return corners;
}

void add_rim(const Point3& center, const Vec3& u, const Vec3& v, std::vector<Point3>& points) {
  for (int i = 0; i < 2 * kRimSteps; ++i)
    points.push_back(center + u * portable::cos(i * kRimStep) + v * portable::sin(i * kRimStep));
}

void add_rim(double radius, double y, std::vector<Point3>& points) {
  add_rim({0, y, 0}, {radius, 0, 0}, {0, 0, radius}, points);
}

}  // namespace tessera
