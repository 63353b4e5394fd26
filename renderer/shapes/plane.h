#pragma once

#include "renderer/math/rounding.h"
#include "renderer/shapes/solid.h"

namespace tessera {

/// The endless plane normal . p = offset; as a solid, the half-space below it. Its bounds are
/// endless on every axis. No texture coordinates of its own: uv are metres along two unit tangents
/// from the foot of the origin.
class Plane final : public ConvexSolid {
 public:
  /// `normal` of any length but 0; `offset` is along the unit normal. Without `keep_uv` surface()
  /// leaves uv, and derivatives by them, zero.
  Plane(const Vec3& normal, double offset, bool keep_uv = true);
  Bounds3 bounds() const override;
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  /// The same in place, but for texture coordinates.
  /// Also a lane each in lane_surface-inl.h, bit for bit.
  void place_surface(const Ray& ray, const Hit& hit, LocalSurface& s) const {
    s.point = ray.at(hit.t);
    s.point = s.point - normal_ * signed_distance(s.point);
    const double error = 2 * distance_error(s.point);
    s.point_error = abs(s.point - Point3{}) * gamma(3) + abs(normal_) * error;
    s.geometric_normal = s.shading_normal = to_normal(normal_);
  }
  bool keeps_uv() const { return keep_uv_; }
  bool span(const Ray& ray, const RayError& error, SolidSpan& span) const override;

  /// Where `ray` meets the sides that `cull` leaves, if it does at t <= `limit`; ray.cull does not
  /// count.
  /// Also a lane each in instance_soa-inl.h, bit for bit.
  bool intersect(const Ray& ray, Cull cull, double limit, double& t) const {
    const double approach = dot(normal_, ray.direction);
    if (cull == Cull::none ? approach == 0 : (approach < 0) == (cull == Cull::front)) return false;
    const double height = signed_distance(ray.origin);
    t = -height / approach;
    if (!(t > ray.t_min && t < ray.t_max && t <= limit)) return false;
    // An origin on the plane, as far as can be told, does not meet it again.
    return std::abs(height) > distance_error(ray.origin);
  }
  /// Of unit length.
  const Vec3& normal() const { return normal_; }
  double offset() const { return offset_; }
  double signed_distance(const Point3& p) const {
    return normal_.x * p.x + normal_.y * p.y + normal_.z * p.z - offset_;
  }
  /// Bound on the absolute error of signed_distance(p).
  double distance_error(const Point3& p) const {
    return gamma(4) * (std::abs(normal_.x * p.x) + std::abs(normal_.y * p.y) +
                       std::abs(normal_.z * p.z) + std::abs(offset_));
  }

 private:
  Vec3 normal_;
  double offset_;
  Vec3 dpdu_, dpdv_;
  bool keep_uv_;
};

}  // namespace tessera
