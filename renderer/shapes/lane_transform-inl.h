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

/// take_to_world()
HWY_INLINE void take_to_world(const Transform& world_from_object, bool flip_normals,
                              LaneSurface& s) {
  const auto is_flat =
      hn::And(hn::Eq(s.front.x, s.shading.x),
              hn::And(hn::Eq(s.front.y, s.shading.y), hn::Eq(s.front.z, s.shading.z)));  // -0 is 0
  if (world_from_object.is_identity()) {
    keep_point(s.point, s.error);
    s.front = kept_normal(s.front), s.shading = kept_normal(s.shading);
  } else {
    const Affine& from = world_from_object.inverse_matrix();
    move_point(world_from_object.matrix(), from, s.point, s.error);
    s.front = normalize(moved_normal(from, s.front));
    s.shading = normalize(moved_normal(from, s.shading));
  }
  s.shading = select(is_flat, s.front, s.shading);
  turn_normals(flip_normals, s.front, s.shading);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
