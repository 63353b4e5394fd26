#pragma once

#include "renderer/math/rounding.h"
#include "renderer/shapes/solid.h"

namespace tessera {

#include "renderer/shapes/plane-inl.h"

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
  void place_surface(const Ray& ray, const Hit& hit, LocalSurface& s) const {
    Vec3 point = to_vec(ray.at(hit.t));
    equation_.place(point, s.point_error);
    s.point = to_point(point);
    s.geometric_normal = s.shading_normal = to_normal(equation_.normal);
  }
  bool keeps_uv() const { return keep_uv_; }
  bool span(const Ray& ray, const RayError& error, SolidSpan& span) const override;

  /// Where `ray` meets the sides that `cull` leaves, if it does at t <= `limit`; ray.cull does not
  /// count.
  bool intersect(const Ray& ray, Cull cull, double limit, double& t) const {
    const double approach = dot(equation_.normal, ray.direction);
    if (cull == Cull::none ? approach == 0 : (approach < 0) == (cull == Cull::front)) return false;
    const double height = signed_distance(ray.origin);
    t = -height / approach;
    if (!(t > ray.t_min && t < ray.t_max && t <= limit)) return false;
    // An origin on the plane, as far as can be told, does not meet it again.
    return std::abs(height) > distance_error(ray.origin);
  }
  /// Of unit length.
  const Vec3& normal() const { return equation_.normal; }
  double offset() const { return equation_.offset; }
  double signed_distance(const Point3& p) const { return equation_.signed_distance(to_vec(p)); }
  double distance_error(const Point3& p) const { return equation_.distance_error(to_vec(p)); }

 private:
  PlaneEquation equation_;
  Vec3 dpdu_, dpdv_;
  bool keep_uv_;
};

}  // namespace tessera
