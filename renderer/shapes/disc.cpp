#include "renderer/shapes/disc.h"

#include "base/error.h"
#include "renderer/shapes/planar.h"

namespace tessera {

Disc::Disc(const Point3& center, const Vec3& normal, double radius, double inner_radius)
    : center_(center), radius_(radius), inner_radius_(inner_radius) {
  if (!(radius > 0 && std::isfinite(radius) && inner_radius >= 0 && inner_radius < radius))
    throw scene_error("a disc's radii are wrong; expected 0 <= inner_radius < radius");
  if (!is_finite(normal) || normal == Vec3{})
    throw scene_error("a disc's normal is 0 or not finite; expected any length but 0");
  normal_ = normalize(normal);
  tangent_ = level_tangent(normal_);
}

Bounds3 Disc::bounds() const {
  Bounds3 box;
  for (int a = 0; a < 3; ++a) {
    // A circle reaches r sqrt(1 - n^2) along an axis; 1 - n^2 from the other two components, so
    // that it does not cancel.
    const double n1 = normal_[(a + 1) % 3], n2 = normal_[(a + 2) % 3];
    const double reach = radius_ * std::sqrt(n1 * n1 + n2 * n2) * (1 + gamma(12)) +
                         gamma(8) * (radius_ + std::abs(center_[a]));
    box.min[a] = next_down(center_[a] - reach);
    box.max[a] = next_up(center_[a] + reach);
  }
  return box;
}

bool Disc::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  ++counters.primitive_tests;
  PlaneCrossing at;
  if (!cross_plane(center_, normal_, ray, hit, at)) return false;
  const Vec3 moment = accurate_cross(ray.origin - center_, ray.direction);
  const double from_center = length(cross(normal_, moment));
  const double scale = std::abs(at.approach);
  if (!(from_center <= radius_ * scale && from_center >= inner_radius_ * scale)) return false;
  hit = {at.t, 0, 0, hit.instance, 0};
  return true;
}

LocalSurface Disc::surface(const Ray& ray, const Hit& hit) const {
  LocalSurface s;
  project_to_plane(center_, normal_, ray.at(hit.t), s);
  const Vec3 up = cross(normal_, tangent_);
  const Vec3 from_center = s.point - center_;
  s.uv = {0.5 + dot(from_center, tangent_) / (2 * radius_),
          0.5 + dot(from_center, up) / (2 * radius_)};
  s.dpdu = tangent_ * (2 * radius_);
  s.dpdv = up * (2 * radius_);
  return s;
}

}  // namespace tessera
