#include "renderer/shapes/sphere.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"
#include "renderer/math/frame.h"
#include "renderer/math/rounding.h"
#include "renderer/math/transform.h"
#include "renderer/math/warp.h"
#include "renderer/shapes/area_density.h"
#include "renderer/shapes/curved_sampler.h"
#include "renderer/shapes/outline_points.h"

namespace tessera {
namespace {

class SphereSampler final : public SurfaceSampler {
 public:
  SphereSampler(const Point3& center, double radius, bool flip)
      : center_(center), radius_(radius), side_(flip ? -1 : 1) {}

  double sample(const LitPoint& from, const Vec2& u, SurfaceSample& sample) const override {
    const Vec3 way = center_ - from.at;
    const double squared = length_squared(way);
    if (!is_outside(squared)) {  // evenly
      place(direction_at(1 - 2 * u.x, u.y), sample);
      return density_by_area(area(), from.at, sample.point, sample.normal);
    }
    const double sin2 = radius_ * radius_ / squared;
    const double from_axis = one_minus_cosine(sin2);  // exact for the smallest of cones too
    const double drop = u.x * from_axis, cos_chosen = 1 - drop;
    const double sin2_chosen = drop * (2 - drop);
    // The angle at the centre between the axis and the chosen point (PBRT 4ed, 6.2.4).
    const double along = sin2_chosen / std::sqrt(sin2) +
                         cos_chosen * std::sqrt(std::max(0.0, 1 - sin2_chosen / sin2));
    const Vec3 local = direction_at(std::min(along, 1.0), u.y);
    place(Frame(-way / std::sqrt(squared)).from_local(local), sample);
    return 1 / (2 * portable::kPi * from_axis);
  }
  double density(const LitPoint& from, const Point3& there, const Vec3& normal,
                 uint32_t) const override {
    const double squared = length_squared(center_ - from.at);
    if (!is_outside(squared)) return density_by_area(area(), from.at, there, normal);
    if (dot(there - from.at, there - center_) > 0) return 0;  // the half that looks away
    return 1 / (2 * portable::kPi * one_minus_cosine(radius_ * radius_ / squared));
  }
  double area() const override { return 4 * portable::kPi * radius_ * radius_; }
  Bounds3 bounds() const override {
    const Vec3 r{radius_, radius_, radius_};
    return {center_ - r, center_ + r};
  }

 private:
  /// Clearly: on the sphere itself, rounding would decide which half of it is seen.
  bool is_outside(double squared) const { return squared > radius_ * radius_ * (1 + 0x1p-20); }
  static double one_minus_cosine(double sin2) { return sin2 / (1 + std::sqrt(1 - sin2)); }
  void place(const Vec3& out, SurfaceSample& sample) const {
    sample.point = center_ + out * radius_;
    sample.point_error = rounding_of(sample.point, radius_);
    sample.normal = out * side_;
  }

  Point3 center_;
  double radius_, side_;
};

class EllipsoidSampler final : public CurvedSampler {
 public:
  EllipsoidSampler(const Point3& center, double radius, const Transform& to_world, bool flip)
      : CurvedSampler(
            4 * portable::kPi * radius * radius,
            {center - Vec3{radius, radius, radius}, center + Vec3{radius, radius, radius}},
            to_world, flip),
        center_(center),
        radius_(radius) {}

 private:
  CurvedPoint choose(const Vec2& u) const override {
    const Vec3 out = direction_at(1 - 2 * u.x, u.y);
    return {center_ + out * radius_, out};
  }
  Point3 center_;
  double radius_;
};

/// The radius of what the sphere becomes; 0 where that is none.
double sphere_radius(const Affine& m, double radius) {
  Vec3 axes[3];
  for (size_t c = 0; c < 3; ++c) axes[c] = {m.m[0][c], m.m[1][c], m.m[2][c]};
  const double scale = length(axes[0]), tolerance = 1e-12 * scale * scale;
  for (int a = 0; a < 3; ++a) {
    if (std::abs(length_squared(axes[a]) - scale * scale) > tolerance) return 0;
    if (std::abs(dot(axes[a], axes[(a + 1) % 3])) > tolerance) return 0;
  }
  return scale * radius;
}

}  // namespace

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
  Vec3 point = to_vec(ray.at(hit.t)), n;
  place_on_sphere(to_vec(center_), radius_, point, n, s.point_error);
  s.point = to_point(point);
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

std::unique_ptr<const SurfaceSampler> Sphere::make_sampler(const Transform& world_from_object,
                                                           bool flip_normals) const {
  const Affine& to_world = world_from_object.matrix();
  const double radius = sphere_radius(to_world, radius_);
  if (radius == 0)
    return std::make_unique<EllipsoidSampler>(center_, radius_, world_from_object, flip_normals);
  return std::make_unique<SphereSampler>(to_world(center_), radius, flip_normals);
}

std::vector<Point3> Sphere::outline() const {
  const Bounds3 box = bounds();
  const Vec3 half = box.diagonal() * .5;
  std::vector<Point3> points;
  for (int i = 0; i <= kRimSteps; ++i) {
    const double out = half.x * portable::sin(i * kRimStep);
    add_rim(box.center() + Vec3{0, half.y * portable::cos(i * kRimStep), 0}, {out, 0, 0},
            {0, 0, out}, points);
  }
  return points;
}

}  // namespace tessera
