#pragma once

#include "renderer/shapes/solid.h"

namespace tessera {

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
  /// Also a lane each in sphere_lanes-inl.h, to the bit.
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  /// Also a lane each in lane_surface-inl.h, to the bit.
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  bool span(const Ray& ray, const RayError& error, SolidSpan& span) const override;
  Side side_of(const Point3& p, double margin) const override {
    const double squared = length_squared(p - center_), inner = radius_ - margin;
    if (squared > (radius_ + margin) * (radius_ + margin)) return Side::outside;
    return inner > 0 && squared < inner * inner ? Side::inside : Side::in_doubt;
  }

  static constexpr double kMargin = 0x1p-44;  ///< hundreds of times the rounding of the squares
  /// The least product of the squares of direction and distance that rounding alone tells the error
  /// of: below it what underflows may be more than kMargin.
  static constexpr double kLeastProduct = 1e-280;
  /// Where `ray` first meets the sides that `cull` leaves, if it does at t <= `limit`; ray.cull
  /// does not count.
  bool intersect(const Ray& ray, Cull cull, double limit, double& t) const {
    const Vec3 f = ray.origin - center_;
    if (surely_missed(ray, f)) return false;
    double roots_of[2];
    if (!roots(ray.direction, f, roots_of[0], roots_of[1])) return false;
    for (int i = 0; i < 2; ++i) {
      // Entering shows the front, leaving the back.
      if (cull == (i == 0 ? Cull::front : Cull::back)) continue;
      t = roots_of[i];
      if (t > ray.t_min && t < ray.t_max) return t <= limit;
    }
    return false;
  }

 private:
  /// A cheap test, without roots and divisions, that most misses pass; where it says nothing the
  /// roots decide. `f` leads from the centre to the ray's origin.
  bool surely_missed(const Ray& ray, const Vec3& f) const {
    const double a = dot(ray.direction, ray.direction), ff = dot(f, f), b = dot(f, ray.direction);
    const double rr = radius_ * radius_, all = a * ff;
    if (!(all > kLeastProduct)) return false;
    if (b > 0 && ray.t_min >= 0 && ff - rr > kMargin * ff) return true;  // it lies behind
    return all - b * b - a * rr > kMargin * all;
  }
  /// The same for the whole line.
  bool surely_missed_by_line(const Vec3& d, const Vec3& f) const {
    const double a = dot(d, d), b = dot(f, d), all = a * dot(f, f);
    return all > kLeastProduct && all - b * b - a * (radius_ * radius_) > kMargin * all;
  }
  /// Roots in ascending order; false where the line misses.
  bool roots(const Vec3& direction, const Vec3& f, double& t0, double& t1) const;

  Point3 center_;
  double radius_;
  bool keep_uv_;
};

}  // namespace tessera
