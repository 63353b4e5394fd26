#include "renderer/shapes/sphere.h"

#include "renderer/math/elementary.h"
#include "renderer/math/rounding.h"

namespace tessera {

Bounds3 Sphere::bounds() const {
  Bounds3 box;
  for (int a = 0; a < 3; ++a) {
    box.min[a] = next_down(center_[a] - radius_);
    box.max[a] = next_up(center_[a] + radius_);
  }
  return box;
}

bool Sphere::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  ++counters.primitive_tests;
  double t;
  if (!intersect(ray, ray.cull, hit.t, t) || (t == hit.t && hit.primitive == 0)) return false;
  hit = {t, 0, 0, hit.instance, 0};
  return true;
}

LocalSurface Sphere::surface(const Ray& ray, const Hit& hit) const {
  using namespace portable;
  LocalSurface s;
  const Vec3 n = normalize(ray.at(hit.t) - center_);
  s.point = center_ + n * radius_;
  for (int a = 0; a < 3; ++a)
    s.point_error[a] = kUnitRoundoff *
                       (std::abs(center_[a]) + 5 * radius_ * std::abs(n[a]) + std::abs(s.point[a]));
  s.geometric_normal = s.shading_normal = to_normal(n);
  if (!keep_uv_) return s;
  const double turn = atan2(-n.x, -n.z) / (2 * kPi);
  s.uv = {turn < 0 ? turn + 1 : turn, acos(std::max(-1.0, std::min(1.0, -n.y))) / kPi};
  s.dpdu = Vec3{n.z, 0, -n.x} * (2 * kPi * radius_);
  const double ring = std::sqrt(n.x * n.x + n.z * n.z);
  if (ring > 0)
    s.dpdv = Vec3{-n.x * n.y / ring, ring, -n.z * n.y / ring} * (kPi * radius_);
  else
    s.dpdv = Vec3{0, 0, n.y > 0 ? 1.0 : -1.0} * (kPi * radius_);
  return s;
}

}  // namespace tessera
