// Compiled once for each instruction set: LocalSurface at many hits of one plane, sphere or
// rectangle, and RayOrigins, a lane each, to the last bit.
#if defined(TESSERA_LANE_SURFACE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_LANE_SURFACE_INL_H
#undef TESSERA_LANE_SURFACE_INL_H
#else
#define TESSERA_LANE_SURFACE_INL_H
#endif

#include <hwy/highway.h>

#include "renderer/math/lanes-inl.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// As LocalSurface, in world space.
struct LaneSurface {
  Lanes3 point, error, front, shading;
};
template <size_t kPadded>
HWY_INLINE void store_anywhere(const Lanes3& a, size_t at, double (&parts)[3][kPadded]) {
  hn::StoreU(a.x, kLaneTag, parts[0] + at);
  hn::StoreU(a.y, kLaneTag, parts[1] + at);
  hn::StoreU(a.z, kLaneTag, parts[2] + at);
}

/// What take_to_world() makes of it under the identity, its normals apart.
HWY_INLINE void place_in_world(Lanes3& point, Lanes3& error) {
  const Lanes zero = hn::Zero(kLaneTag);
  point = point + Lanes3{zero, zero, zero};  // no -0
  const Lanes3 size = abs(point) * broadcast(gamma(4));
  error = error * broadcast(gamma(3) + 1) + size + size;
}
/// Plane::place_surface().
HWY_INLINE LaneSurface surface_of(const Plane& plane, const Vec3& front, const Lanes3& at) {
  LaneSurface s;
  const Lanes3 normal = broadcast(plane.normal());
  const Lanes offset = broadcast(plane.offset());
  s.point = at;
  const Lanes distance = dot(normal, s.point) - offset;
  s.point = s.point - normal * distance;
  const Lanes terms = sum(abs(normal * s.point)) + hn::Abs(offset);
  const Lanes error = broadcast(2) * (broadcast(gamma(4)) * terms);
  s.error = abs(s.point) * broadcast(gamma(3)) + abs(normal) * error;
  place_in_world(s.point, s.error);
  s.front = s.shading = broadcast(front);
  return s;
}
/// Sphere::surface().
HWY_INLINE LaneSurface surface_of(const Sphere& sphere, double facing, const Lanes3& at) {
  LaneSurface s;
  const Lanes3 center = broadcast(sphere.center());
  const Lanes3 n = normalize(at - center);
  s.point = center + n * broadcast(sphere.radius());
  const Lanes3 terms = abs(center) + abs(n) * broadcast(5 * sphere.radius()) + abs(s.point);
  s.error = terms * broadcast(kUnitRoundoff);
  place_in_world(s.point, s.error);
  const Lanes zero = hn::Zero(kLaneTag);
  const Lanes3 whole = n + Lanes3{zero, zero, zero};
  const auto is_unit = hn::Eq(dot(whole, whole), broadcast(1));
  s.front = select(is_unit, whole, normalize(whole));
  s.front = s.shading = s.front * broadcast(facing);
  return s;
}

/// Rectangle::surface(), without its normals.
HWY_INLINE LaneSurface surface_of(const Rectangle& rectangle, Lanes u, Lanes v) {
  LaneSurface s;
  const Lanes3 corner = broadcast(rectangle.corner());
  const Lanes3 along = broadcast(rectangle.edge_u()) * u;
  const Lanes3 up = broadcast(rectangle.edge_v()) * v;
  s.point = corner + along + up;
  s.error = (abs(along) + abs(up)) * broadcast(gamma(8)) +
            (abs(corner) + abs(s.point)) * broadcast(gamma(3));
  return s;
}

/// Surfaces in memory.
template <size_t kPadded>
struct LaneSurfaces {
  alignas(64) double point[3][kPadded], error[3][kPadded], front[3][kPadded], shading[3][kPadded];

  HWY_INLINE LaneSurface load(size_t at) const {
    using HWY_NAMESPACE::load;
    return {load(point, at), load(error, at), load(front, at), load(shading, at)};
  }
  /// At any place, with room for a whole vector behind it.
  HWY_INLINE void store(const LaneSurface& s, size_t at) {
    store_anywhere(s.point, at, point);
    store_anywhere(s.error, at, error);
    store_anywhere(s.front, at, front);
    store_anywhere(s.shading, at, shading);
  }
};

/// RayOrigins::towards().
HWY_INLINE Lanes3 origin_towards(const LaneSurface& s, const Lanes3& direction) {
  const auto behind = hn::Lt(dot(s.front, direction), hn::Zero(kLaneTag));
  const Lanes reach = dot(abs(s.front), s.error);
  const Lanes3 offset = s.front * hn::IfThenElse(behind, hn::Neg(reach), reach);
  const Lanes3 origin = s.point + offset;
  return {next_towards(origin.x, offset.x), next_towards(origin.y, offset.y),
          next_towards(origin.z, offset.z)};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
