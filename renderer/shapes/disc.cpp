#include "renderer/shapes/disc.h"

#include <cmath>

#include "base/error.h"
#include "renderer/math/elementary.h"
#include "renderer/math/transform.h"
#include "renderer/math/warp.h"
#include "renderer/shapes/area_density.h"
#include "renderer/shapes/outline_points.h"
#include "renderer/shapes/planar.h"
#include "renderer/shapes/surface_sampler.h"

namespace tessera {
namespace {

class DiscSampler final : public SurfaceSampler {
 public:
  /// `a` and `b` lead from the centre to the rim, square to each other before any transform.
  DiscSampler(const Point3& center, const Vec3& a, const Vec3& b, double inner, const Vec3& normal)
      : center_(center), a_(a), b_(b), inner_(inner), normal_(normal) {}
  double sample(const LitPoint& from, const Vec2& u, SurfaceSample& sample) const override {
    choose(u, sample);
    return density_by_area(area(), from.at, sample.point, sample.normal);
  }
  double density(const LitPoint& from, const Point3& there, const Vec3& normal,
                 uint32_t) const override {
    return density_by_area(area(), from.at, there, normal);
  }
  double area() const override {
    return portable::kPi * length(cross(a_, b_)) * (1 - inner_ * inner_);
  }
  Bounds3 bounds() const override {
    const Vec3 r = abs(a_) + abs(b_);
    return {center_ - r, center_ + r};
  }
  bool is_flat(Point3& at, Vec3& normal) const override {
    at = center_;
    normal = normal_;
    return true;
  }

 private:
  void choose(const Vec2& u, SurfaceSample& sample) const {
    Vec2 d = disc_point(u);
    if (inner_ > 0) {
      const double r2 = d.x * d.x + d.y * d.y;
      if (r2 == 0) d = {1e-150, 0};
      const double from = std::sqrt(d.x * d.x + d.y * d.y);
      const double to = std::sqrt(inner_ * inner_ + (1 - inner_ * inner_) * r2);
      d = {d.x * (to / from), d.y * (to / from)};
    }
    sample.point = center_ + a_ * d.x + b_ * d.y;
    sample.point_error = rounding_of(sample.point, length(a_) + length(b_));
    sample.normal = normal_;
  }

  Point3 center_;
  Vec3 a_, b_;
  double inner_;
  Vec3 normal_;
};

}  // namespace

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

std::unique_ptr<const SurfaceSampler> Disc::make_sampler(const Transform& world_from_object,
                                                         bool flip_normals) const {
  const Affine& to_world = world_from_object.matrix();
  return std::make_unique<DiscSampler>(
      to_world(center_), to_world(tangent_ * radius_), to_world(cross(normal_, tangent_) * radius_),
      inner_radius_ / radius_, unit_normal(world_from_object, normal_, flip_normals));
}

std::vector<Point3> Disc::outline() const {
  std::vector<Point3> points;
  add_rim(center_, tangent_ * radius_, cross(normal_, tangent_) * radius_, points);
  return points;
}

}  // namespace tessera
