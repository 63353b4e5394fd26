#pragma once

#include "renderer/math/rounding.h"
#include "renderer/shapes/shape.h"

namespace tessera {

// What flat shapes share. A plane goes through `anchor` across `normal`, of any length but 0. Which
// part of it a ray meets is told from the line's moment about a point of the plane: with
// m = (origin - point) x direction, the hit is at point + normal x m / (normal . direction). No
// rounded hit point comes in, so the answer is as good from far away as from near.

struct PlaneCrossing {
  double t = 0;
  double approach = 0;  ///< normal . direction
};

/// cross_plane() by the products of the normal with the way from the anchor to the origin and with
/// the direction; `reach` is the former's, all parts taken as positive.
inline bool cross_plane_at(double height, double approach, double reach, const Ray& ray,
                           const Hit& hit, PlaneCrossing& crossing) {
  if (!(approach != 0)) return false;
  if (ray.cull != Cull::none && (approach < 0) == (ray.cull == Cull::front)) return false;
  if (std::abs(height) <= gamma(2) * reach) return false;
  const double t = -height / approach;
  if (!(t > ray.t_min && t < ray.t_max)) return false;
  if (t > hit.t || (t == hit.t && hit.primitive == 0)) return false;
  crossing = {t, approach};
  return true;
}

/// Whether the ray meets the plane inside its stretch, on a side that it does not cull, no farther
/// than `hit`. An origin on the plane, as far as can be told, does not meet it again.
inline bool cross_plane(const Point3& anchor, const Vec3& normal, const Ray& ray, const Hit& hit,
                        PlaneCrossing& crossing) {
  const Vec3 from_anchor = ray.origin - anchor;
  return cross_plane_at(accurate_dot(normal, from_anchor), accurate_dot(normal, ray.direction),
                        dot(abs(normal), abs(from_anchor)), ray, hit, crossing);
}

/// Moves `near_plane`, a point at most some roundings off the plane, onto it, and bounds its error
/// so that a ray spawned off it is told apart from the plane by cross_plane.
inline void project_to_plane(const Point3& anchor, const Vec3& normal, const Point3& near_plane,
                             LocalSurface& surface) {
  const double height = accurate_dot(normal, near_plane - anchor);
  surface.point = near_plane - normal * (height / dot(normal, normal));
  for (int a = 0; a < 3; ++a)
    surface.point_error[a] =
        gamma(6) * std::abs(surface.point[a] - anchor[a]) + gamma(3) * std::abs(surface.point[a]);
  surface.geometric_normal = surface.shading_normal = to_normal(normalize(normal));
}

/// A unit tangent across the unit normal: +x for a normal along +z, else as near to level as can
/// be.
inline Vec3 level_tangent(const Vec3& normal) {
  if (std::abs(normal.y) > 0.9) return normalize(cross({0, 0, normal.y}, normal));
  return normalize(cross({0, 1, 0}, normal));
}

}  // namespace tessera
