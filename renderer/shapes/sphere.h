#pragma once

#include "renderer/math/numbers.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/solid.h"

namespace tessera {

inline constexpr double kSphereMargin = 0x1p-44;  ///< hundreds of times the rounding of the squares
/// The least product of the squares of direction and distance that rounding alone tells the error
/// of: below it what underflows may be more than kSphereMargin.
inline constexpr double kLeastSphereProduct = 1e-280;

#include "renderer/shapes/sphere-inl.h"

/// The sphere about `center`; `radius` > 0. Texture coordinates as X3D maps a sphere: u runs
/// counter-clockwise seen from +y from the seam at -z, v from 0 at -y to 1 at +y.
class Sphere final : public ConvexSolid {
 public:
  /// Without `keep_uv` surface() leaves texture coordinates, and derivatives by them, zero.
  Sphere(const Point3& center, double radius, bool keep_uv = true)
      : ConvexSolid(ShapeKind::sphere), center_(center), radius_(radius), keep_uv_(keep_uv) {}
  const Point3& center() const { return center_; }
  double radius() const { return radius_; }
  Bounds3 bounds() const override;
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  bool span(const Ray& ray, const RayError& error, SolidSpan& span) const override;
  /// By the cone in which it is seen, where it stays a sphere.
  std::unique_ptr<const SurfaceSampler> make_sampler(const Transform& world_from_object,
                                                     bool flip_normals) const override;
  std::vector<Point3> outline() const override;
  Side side_of(const Point3& p, double margin) const override {
    const double squared = length_squared(p - center_), inner = radius_ - margin;
    if (squared > (radius_ + margin) * (radius_ + margin)) return Side::outside;
    return inner > 0 && squared < inner * inner ? Side::inside : Side::in_doubt;
  }

  /// Where `ray` first meets the sides that `cull` leaves, if it does at t <= `limit`; ray.cull
  /// does not count.
  bool intersect(const Ray& ray, Cull cull, double limit, double& t) const {
    const SphereLine line = line_of(ray);
    if (line.surely_misses(ray.t_min >= 0)) return false;
    double roots[2];
    if (!line.roots(roots[0], roots[1])) return false;
    for (int i = 0; i < 2; ++i) {
      // Entering shows the front, leaving the back.
      if (cull == (i == 0 ? Cull::front : Cull::back)) continue;
      t = roots[i];
      if (t > ray.t_min && t < ray.t_max) return t <= limit;
    }
    return false;
  }

 private:
  SphereLine line_of(const Ray& ray) const {
    return {ray.origin - center_, ray.direction, radius_};
  }

  Point3 center_;
  double radius_;
  bool keep_uv_;
};

}  // namespace tessera
