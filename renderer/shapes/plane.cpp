#include "renderer/shapes/plane.h"

#include "renderer/math/rounding.h"

namespace tessera {
namespace {

constexpr double kEndless = Bounds3::kInfinity;

/// Bound on the absolute rounding error of normal . p - offset.
double signed_distance_error(const Vec3& normal, double offset, const Point3& p) {
  return gamma(4) * (std::abs(normal.x * p.x) + std::abs(normal.y * p.y) +
                     std::abs(normal.z * p.z) + std::abs(offset));
}

double signed_distance(const Vec3& normal, double offset, const Point3& p) {
  return normal.x * p.x + normal.y * p.y + normal.z * p.z - offset;
}

}  // namespace

Plane::Plane(const Vec3& normal, double offset) : normal_(normalize(normal)), offset_(offset) {}

Bounds3 Plane::bounds() const {
  return {{-kEndless, -kEndless, -kEndless}, {kEndless, kEndless, kEndless}};
}

bool Plane::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  ++counters.primitive_tests;
  const double approach = dot(normal_, ray.direction);
  if (ray.cull == Cull::none ? approach == 0 : (approach < 0) == (ray.cull == Cull::front))
    return false;
  const double height = signed_distance(normal_, offset_, ray.origin);
  // An origin on the plane, as far as can be told, does not meet it again.
  if (std::abs(height) <= signed_distance_error(normal_, offset_, ray.origin)) return false;
  const double t = -height / approach;
  if (!(t > ray.t_min && t < ray.t_max)) return false;
  if (t > hit.t || (t == hit.t && hit.primitive == 0)) return false;
  hit = {t, 0, 0, hit.instance, 0};
  return true;
}

bool Plane::any_hit(const Ray& ray, TraversalCounters& counters) const {
  Hit hit;
  return closest_hit(ray, hit, counters);
}

LocalSurface Plane::surface(const Ray& ray, const Hit& hit) const {
  LocalSurface s;
  s.point = ray.at(hit.t);
  s.point = s.point - normal_ * signed_distance(normal_, offset_, s.point);
  const double error = 2 * signed_distance_error(normal_, offset_, s.point);
  for (int a = 0; a < 3; ++a)
    s.point_error[a] = gamma(3) * std::abs(s.point[a]) + error * std::abs(normal_[a]);
  s.geometric_normal = s.shading_normal = to_normal(normal_);
  const bool along_y = std::abs(normal_.y) > 0.9;
  s.dpdu = normalize(cross(along_y ? Vec3{0, 0, 1} : Vec3{0, 1, 0}, normal_));
  if (along_y) s.dpdu = s.dpdu * (normal_.y < 0 ? -1 : 1);
  s.dpdv = cross(normal_, s.dpdu);
  const Vec3 from_foot = s.point - (Point3{} + normal_ * offset_);
  s.uv = {dot(from_foot, s.dpdu), dot(from_foot, s.dpdv)};
  return s;
}

}  // namespace tessera
