#include "renderer/shapes/triangle.h"

#include "renderer/math/bounds.h"

namespace tessera {
namespace {

/// Moves t into the ray's stretch inside the triangle's box. Where the triangle is seen edge-on its
/// t is anywhere along the edge; without this a tree could cull the hit that a scan reports.
double clamp_to_box(const TriangleRay& ray, const Point3& a, const Point3& b, const Point3& c,
                    double t) {
  double enter = -Bounds3::kInfinity, leave = Bounds3::kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::min(a[axis], std::min(b[axis], c[axis]));
    const double high = std::max(a[axis], std::max(b[axis], c[axis]));
    if (ray.direction[axis] == 0) continue;
    const double t0 = (low - ray.world_origin[axis]) / ray.direction[axis];
    const double t1 = (high - ray.world_origin[axis]) / ray.direction[axis];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return std::max(enter, std::min(leave, t));
}

}  // namespace

bool finish_triangle(const TriangleRay& ray, const Point3& a, const Point3& b, const Point3& c,
                     ShearedTriangle& s, TriangleHit& hit) {
  if (s.u == 0 || s.v == 0 || s.w == 0) {
    // A zero may be a rounded one, and then a sliver far away would count as hit.
    s.u = difference_of_products(s.cx, s.by, s.cy, s.bx);
    s.v = difference_of_products(s.ax, s.cy, s.ay, s.cx);
    s.w = difference_of_products(s.bx, s.ay, s.by, s.ax);
    const bool all_up = s.u >= 0 && s.v >= 0 && s.w >= 0;
    const bool all_down = s.u <= 0 && s.v <= 0 && s.w <= 0;
    if (!(all_up || all_down)) return false;
  }
  const double det = s.u + s.v + s.w;
  if (!(det != 0)) return false;
  if (ray.cull == Cull::back ? det < 0 : ray.cull == Cull::front && det > 0) return false;
  const double inverse_det = 1 / det;
  double t = (s.u * s.az + s.v * s.bz + s.w * s.cz) * inverse_det;
  const double error = t_error(s, inverse_det);
  if (!(t > error)) return false;
  if (error > t * 0x1p-30) [[unlikely]] {
    t = clamp_to_box(ray, a, b, c, t);
    if (!(t > 0)) return false;
  }
  if (!(t > ray.t_min && t < ray.t_max)) return false;
  hit = {t, s.v * inverse_det, s.w * inverse_det};
  return true;
}

}  // namespace tessera
