#include "renderer/shapes/triangle.h"

#include "renderer/math/bounds.h"

namespace tessera {
namespace {

/// t moved into the ray's stretch inside the triangle's box. Where the triangle is seen edge-on its
/// t is anywhere along the edge; without this a tree could cull the hit that a scan reports.
double clamp_to_box(const Ray& ray, const std::array<Point3, 3>& corners, double t) {
  double enter = -Bounds3::kInfinity, leave = Bounds3::kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = corners[0][axis], b = corners[1][axis], c = corners[2][axis];
    if (ray.direction[axis] == 0) continue;
    const double t0 = (std::min(a, std::min(b, c)) - ray.origin[axis]) / ray.direction[axis];
    const double t1 = (std::max(a, std::max(b, c)) - ray.origin[axis]) / ray.direction[axis];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return std::max(enter, std::min(leave, t));
}

/// Whether every corner is in front of the origin by far more than any rounding: then so is the
/// hit, however badly t is known. A ray that starts on the triangle never sees it so. Without this
/// the bound on t would open a crack where a closed mesh has a triangle of almost no area.
bool clearly_ahead(const TriangleRay& ray, const ShearedTriangle& s) {
  const double nearest = std::min(std::min(s.az, s.bz), s.cz);
  const double farthest = std::max(std::max(s.az, s.bz), s.cz);
  const double origin =
      std::max(std::max(std::abs(ray.origin.x), std::abs(ray.origin.y)), std::abs(ray.origin.z));
  return nearest > 0x1p-30 * (origin * std::abs(ray.sz) + farthest);
}

}  // namespace

bool sharpen_edges(ShearedTriangle& s) {
  s.u = difference_of_products(s.cx, s.by, s.cy, s.bx);
  s.v = difference_of_products(s.ax, s.cy, s.ay, s.cx);
  s.w = difference_of_products(s.bx, s.ay, s.by, s.ax);
  const bool all_up = s.u >= 0 && s.v >= 0 && s.w >= 0;
  const bool all_down = s.u <= 0 && s.v <= 0 && s.w <= 0;
  return (all_up || all_down) && s.u + s.v + s.w != 0;
}

bool settle_uncertain_t(const TriangleRay& ray, const ShearedTriangle& s,
                        const std::array<Point3, 3>& corners, double error, double& t) {
  if (!(t > error) && !clearly_ahead(ray, s)) return false;
  t = clamp_to_box(ray.ray, corners, t);
  return t > 0;
}

}  // namespace tessera
