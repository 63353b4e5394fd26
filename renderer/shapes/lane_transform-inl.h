// Compiled once for each instruction set: take_to_world() of many hits of one instance, a lane
// each, to the last bit.
#if defined(TESSERA_LANE_TRANSFORM_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_LANE_TRANSFORM_INL_H
#undef TESSERA_LANE_TRANSFORM_INL_H
#else
#define TESSERA_LANE_TRANSFORM_INL_H
#endif

#include <hwy/highway.h>

#include "renderer/math/lanes-inl.h"
#include "renderer/math/rounding.h"
#include "renderer/math/transform.h"
#include "renderer/shapes/lane_surface-inl.h"
#include "renderer/shapes/surface_interaction.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

using MatrixRow = std::array<double, 4>;

/// |m[0]| v.x + |m[1]| v.y + |m[2]| v.z
HWY_INLINE Lanes grown(const MatrixRow& m, const Lanes3& v) {
  return sum({broadcast(std::abs(m[0])) * v.x, broadcast(std::abs(m[1])) * v.y,
              broadcast(std::abs(m[2])) * v.z});
}
/// |m[0] p.x| + |m[1] p.y| + |m[2] p.z| + |m[3]|
HWY_INLINE Lanes size_of(const MatrixRow& m, const Lanes3& p) {
  return grown(m, abs(p)) + broadcast(std::abs(m[3]));
}
HWY_INLINE Lanes3 of_rows(const auto& of_row) { return {of_row(0), of_row(1), of_row(2)}; }

/// The point and its error as place_moved() does.
HWY_INLINE void place_in_world(const Transform& world_from_object, Lanes3& point, Lanes3& error) {
  const auto& to = world_from_object.matrix().m;
  const auto& from = world_from_object.inverse_matrix().m;
  const Lanes3 local = point;
  point = of_rows([&](size_t r) HWY_ATTR {
    const MatrixRow& m = to[r];
    return broadcast(m[0]) * local.x + broadcast(m[1]) * local.y +
           (broadcast(m[2]) * local.z + broadcast(m[3]));
  });
  const Lanes3 round_trip =
      of_rows([&](size_t r) HWY_ATTR { return broadcast(gamma(4)) * size_of(from[r], point); });
  error = of_rows([&](size_t r) HWY_ATTR {
    const Lanes given = broadcast(gamma(3) + 1) * grown(to[r], error);
    const Lanes rounding = broadcast(gamma(4)) * size_of(to[r], local);
    return given + rounding + grown(to[r], round_trip);
  });
}
/// normalize(Transform::normal(n))
HWY_INLINE Lanes3 normal_in_world(const Transform& world_from_object, const Lanes3& n) {
  const auto& m = world_from_object.inverse_matrix().m;
  return normalize(of_rows([&](size_t c) HWY_ATTR {
    return sum({broadcast(m[0][c]) * n.x, broadcast(m[1][c]) * n.y, broadcast(m[2][c]) * n.z});
  }));
}
/// The same under the identity.
HWY_INLINE Lanes3 unmoved_normal(const Lanes3& n) {
  const Lanes zero = hn::Zero(kLaneTag);
  const Lanes3 whole = n + Lanes3{zero, zero, zero};  // no -0
  const auto is_unit = hn::Eq(dot(whole, whole), broadcast(1));
  return select(is_unit, whole, normalize(whole));
}
/// take_to_world()
HWY_INLINE void take_to_world(const Transform& world_from_object, bool flip_normals,
                              LaneSurface& s) {
  const auto is_flat =
      hn::And(hn::Eq(s.front.x, s.shading.x),
              hn::And(hn::Eq(s.front.y, s.shading.y), hn::Eq(s.front.z, s.shading.z)));  // -0 is 0
  if (world_from_object.is_identity()) {
    place_in_world(s.point, s.error);
    s.front = unmoved_normal(s.front), s.shading = unmoved_normal(s.shading);
  } else {
    place_in_world(world_from_object, s.point, s.error);
    s.front = normal_in_world(world_from_object, s.front);
    s.shading = normal_in_world(world_from_object, s.shading);
  }
  s.shading = select(is_flat, s.front, s.shading);
  if (flip_normals) s.front = -s.front, s.shading = -s.shading;
  const auto is_behind = hn::Lt(dot(s.front, s.shading), broadcast(kFlipCosine));
  s.shading = select(is_behind, -s.shading, s.shading);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
