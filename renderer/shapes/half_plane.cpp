#include "renderer/shapes/half_plane.h"

#include "base/error.h"
#include "renderer/shapes/planar.h"

namespace tessera {

HalfPlane::HalfPlane(const Point3& point, const Vec3& normal, const Vec3& edge_normal)
    : point_(point) {
  if (!is_finite(normal) || !is_finite(edge_normal) || normal == Vec3{} || edge_normal == Vec3{})
    throw scene_error("a half-plane's normal is 0 or not finite; expected any length but 0");
  normal_ = normalize(normal);
  edge_ = accurate_cross(normalize(edge_normal), normal_);
  if (edge_ == Vec3{})
    throw scene_error("a half-plane's normals are parallel; expected edge_normal in the plane");
  edge_ = normalize(edge_);
}

Bounds3 HalfPlane::bounds() const { return Bounds3::everywhere(); }

bool HalfPlane::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  ++counters.primitive_tests;
  PlaneCrossing at;
  if (!cross_plane(point_, normal_, ray, hit, at)) return false;
  // edge . moment is the distance inside the edge times normal . direction (see planar.h).
  const double inside = accurate_dot(edge_, accurate_cross(ray.origin - point_, ray.direction));
  if (!(at.approach > 0 ? inside >= 0 : inside <= 0)) return false;
  hit = {at.t, 0, 0, hit.instance, 0};
  return true;
}

LocalSurface HalfPlane::surface(const Ray& ray, const Hit& hit) const {
  LocalSurface s;
  project_to_plane(point_, normal_, ray.at(hit.t), s);
  const Vec3 inward = cross(normal_, edge_);
  s.uv = {dot(s.point - point_, inward), dot(s.point - point_, edge_)};
  s.dpdu = inward;
  s.dpdv = edge_;
  return s;
}

}  // namespace tessera
