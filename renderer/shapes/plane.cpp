#include "renderer/shapes/plane.h"

#include "renderer/math/rounding.h"

namespace tessera {

Plane::Plane(const Vec3& normal, double offset, bool keep_uv)
    : ConvexSolid(ShapeKind::plane), equation_{normalize(normal), offset}, keep_uv_(keep_uv) {
  const Vec3& n = equation_.normal;
  const bool along_y = std::abs(n.y) > 0.9;
  dpdu_ = normalize(cross(along_y ? Vec3{0, 0, 1} : Vec3{0, 1, 0}, n));
  if (along_y) dpdu_ = dpdu_ * (n.y < 0 ? -1 : 1);
  dpdv_ = cross(n, dpdu_);
}

Bounds3 Plane::bounds() const { return Bounds3::everywhere(); }

bool Plane::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  ++counters.primitive_tests;
  double t;
  if (!intersect(ray, ray.cull, hit.t, t) || (t == hit.t && hit.primitive == 0)) return false;
  hit = {t, 0, 0, hit.instance, 0};
  return true;
}

LocalSurface Plane::surface(const Ray& ray, const Hit& hit) const {
  LocalSurface s;
  place_surface(ray, hit, s);
  if (!keep_uv_) return s;
  s.dpdu = dpdu_;
  s.dpdv = dpdv_;
  const Vec3 from_foot = s.point - (Point3{} + equation_.normal * equation_.offset);
  s.uv = {dot(from_foot, s.dpdu), dot(from_foot, s.dpdv)};
  return s;
}

}  // namespace tessera
