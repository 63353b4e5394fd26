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
#include "renderer/shapes/shape_lanes-inl.h"

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

HWY_INLINE LaneSurface surface_of(const Plane& plane, const Vec3& front, const Lanes3& at) {
  LaneSurface s;
  s.point = at;
  PlaneEquation{broadcast(plane.normal()), num(plane.offset())}.place(s.point, s.error);
  keep_point(s.point, s.error);
  s.front = s.shading = broadcast(front);
  return s;
}
HWY_INLINE LaneSurface surface_of(const Sphere& sphere, double facing, const Lanes3& at) {
  LaneSurface s;
  s.point = at;
  place_on_sphere(broadcast(sphere.center()), num(sphere.radius()), s.point, s.front, s.error);
  keep_point(s.point, s.error);
  s.front = s.shading = kept_normal(s.front) * num(facing);
  return s;
}
/// Without its normals.
HWY_INLINE LaneSurface surface_of(const Rectangle& rectangle, Lanes u, Lanes v) {
  LaneSurface s;
  place_on_rectangle(broadcast(rectangle.corner()), broadcast(rectangle.edge_u()) * u,
                     broadcast(rectangle.edge_v()) * v, s.point, s.error);
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

/// Where rays to the side that `direction` points to start.
HWY_INLINE Lanes3 origin_towards(const LaneSurface& s, const Lanes3& direction) {
  return moved_off(s.point, s.error, s.front, hn::Lt(dot(s.front, direction), num(0)));
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
