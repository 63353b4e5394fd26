// Compiled once for each instruction set: as many rays as there are lanes against a carved box.
#if defined(TESSERA_CARVED_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CARVED_LANES_INL_H
#undef TESSERA_CARVED_LANES_INL_H
#else
#define TESSERA_CARVED_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <cmath>

#include "renderer/accel/slab_lanes-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/shapes/carved_box.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Which rays surely hit a carved box after 0, and 0 is where they begin, and before `last`; and
/// which surely do not after 0, wherever they begin. What is in neither has to be worked out.
struct CarvedBoxMet {
  LaneMask hit, missed;
};

/// By the ends of the stretch inside the box: where one of them is before the ray and outside of
/// all spheres it is a hit, and where both are inside of one sphere there is none.
HWY_INLINE CarvedBoxMet meet_carved_box(const CarvedBox& carved, const Lanes3& origin,
                                        const Lanes3& direction, Lanes last) {
  const Lanes margin = broadcast(CarvedBox::kDoubt), zero = hn::Zero(kLaneTag);
  const Lanes from = sum(abs(origin)), along = sum(abs(direction));
  Lanes enter = broadcast(-1e300), leave = broadcast(1e300), flattest = zero;
  const auto narrow = [&](double min, double max, Lanes o, Lanes d) HWY_ATTR {
    const Lanes inverse = inverse_of(d);
    const Lanes a = (broadcast(min) - o) * inverse;
    const Lanes b = (broadcast(max) - o) * inverse;
    enter = hn::Max(enter, hn::Min(a, b));
    leave = hn::Min(leave, hn::Max(a, b));
    flattest = hn::Max(flattest, hn::Abs(inverse));
  };
  narrow(carved.box.min.x, carved.box.max.x, origin.x, direction.x);
  narrow(carved.box.min.y, carved.box.max.y, origin.y, direction.y);
  narrow(carved.box.min.z, carved.box.max.z, origin.z, direction.z);
  const auto doubt_at = [&](Lanes t) HWY_ATTR { return margin * (from + hn::Abs(t) * along); };
  const Lanes at_enter = doubt_at(enter), at_leave = doubt_at(leave);
  const Lanes doubt = hn::Max(at_enter, at_leave) * flattest;
  auto missed = hn::Or(hn::Gt(enter - doubt, leave + doubt),
                       hn::Or(hn::Lt(leave, hn::Neg(doubt)), hn::Gt(enter, last + doubt)));
  auto enters_outside = hn::Lt(enter + doubt, leave - doubt);
  auto leaves_outside = enters_outside;
  const Lanes3 first_end = origin + direction * enter;
  const Lanes3 last_end = origin + direction * leave;
  for (const CarvedBox::Hole& hole : carved.holes) {
    const Lanes radius = broadcast(hole.radius);
    const auto is_inside = [&](const Lanes3& point, Lanes by, LaneMask& outside) HWY_ATTR {
      const Lanes3 v = point - broadcast(hole.center);
      const Lanes squared = dot(v, v), outer = radius + by, inner = radius - by;
      outside = hn::And(outside, hn::Gt(squared, outer * outer));
      return hn::And(hn::Gt(inner, zero), hn::Lt(squared, inner * inner));
    };
    const auto enters_inside = is_inside(first_end, at_enter, enters_outside);
    const auto leaves_inside = is_inside(last_end, at_leave, leaves_outside);
    missed = hn::Or(missed, hn::And(enters_inside, leaves_inside));
  }
  const auto is_on_ray = [&](Lanes t) HWY_ATTR {
    return hn::And(hn::Gt(t, doubt), hn::Lt(t + doubt, last));
  };
  return {
      hn::Or(hn::And(enters_outside, is_on_ray(enter)), hn::And(leaves_outside, is_on_ray(leave))),
      missed};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
