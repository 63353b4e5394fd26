// Compiled once for each instruction set: as many rays as there are lanes against a sphere.
#if defined(TESSERA_SPHERE_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_SPHERE_LANES_INL_H
#undef TESSERA_SPHERE_LANES_INL_H
#else
#define TESSERA_SPHERE_LANES_INL_H
#endif

#include <hwy/highway.h>

#include "renderer/accel/sphere_soa.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/shapes/shape_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Which of the rays meet the sphere that box `box` holds between `first` and `last`, and where.
HWY_INLINE LaneMask meet_sphere(const SphereSoA& spheres, size_t box, const Lanes3& origin,
                                const Lanes3& direction, Lanes first, Lanes last, Lanes& t) {
  const Lanes3 center{broadcast(spheres.center[0][box]), broadcast(spheres.center[1][box]),
                      broadcast(spheres.center[2][box])};
  const SphereLine line{origin - center, direction, broadcast(spheres.radius[box])};
  const Lanes zero = hn::Zero(kLaneTag);
  const LaneMask is_missed = line.surely_misses(first >= zero);
  if (hn::AllTrue(kLaneTag, is_missed)) return hn::Lt(zero, zero);
  Lanes enter, leave;
  const LaneMask has_roots = line.roots(enter, leave);
  const auto counts = [&](Lanes at)
                          HWY_ATTR { return hn::And(hn::Gt(at, first), hn::Lt(at, last)); };
  // Entering shows the front, leaving the back.
  const Cull cull = spheres.cull[box];
  const auto enters = cull == Cull::front ? hn::Lt(zero, zero) : counts(enter);
  const auto leaves = cull == Cull::back ? hn::Lt(zero, zero) : counts(leave);
  t = hn::IfThenElse(enters, enter, leave);
  return hn::AndNot(is_missed, hn::And(has_roots, hn::Or(enters, leaves)));
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
