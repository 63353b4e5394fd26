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

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Sphere::intersect() line by line, its limit apart: which of the rays meet the sphere that box
/// `box` holds between `first` and `last`, and where.
HWY_INLINE LaneMask meet_sphere(const SphereSoA& row, size_t box, const Lanes3& origin,
                                const Lanes3& direction, Lanes first, Lanes last, Lanes& t) {
  const Lanes zero = hn::Zero(kLaneTag), margin = broadcast(Sphere::kMargin);
  const Lanes3 center{broadcast(row.center[0][box]), broadcast(row.center[1][box]),
                      broadcast(row.center[2][box])};
  const Lanes radius = broadcast(row.radius[box]);
  const Lanes3 f = subtract(origin, center);
  const Lanes a = dot(direction, direction), ff = dot(f, f), along = dot(f, direction);
  const Lanes rr = hn::Mul(radius, radius), whole = hn::Mul(a, ff);
  const auto lies_behind = hn::And(hn::And(hn::Gt(along, zero), hn::Ge(first, zero)),
                                   hn::Gt(hn::Sub(ff, rr), hn::Mul(margin, ff)));
  const Lanes off = hn::Sub(hn::Sub(whole, hn::Mul(along, along)), hn::Mul(a, rr));
  const auto is_missed = hn::And(hn::Gt(whole, broadcast(Sphere::kLeastProduct)),
                                 hn::Or(lies_behind, hn::Gt(off, hn::Mul(margin, whole))));
  if (hn::AllTrue(kLaneTag, is_missed)) return hn::Lt(zero, zero);
  const Lanes b = hn::Neg(along);
  const Lanes3 nearest = add(f, multiply(direction, hn::Div(b, a)));
  const Lanes from_axis = hn::Sqrt(dot(nearest, nearest));
  const Lanes discriminant = hn::Mul(hn::Add(radius, from_axis), hn::Sub(radius, from_axis));
  const Lanes distance = hn::Sqrt(ff);
  const Lanes c = hn::Mul(hn::Add(distance, radius), hn::Sub(distance, radius));
  const Lanes q = hn::Add(b, hn::CopySign(hn::Sqrt(hn::Mul(a, discriminant)), b));
  const auto touches = hn::Eq(q, zero);
  const Lanes one = hn::IfThenElse(touches, zero, hn::Div(c, q));
  const Lanes other = hn::IfThenElse(touches, zero, hn::Div(q, a));
  const auto swapped = hn::Gt(one, other);
  const Lanes enter = hn::IfThenElse(swapped, other, one);
  const Lanes leave = hn::IfThenElse(swapped, one, other);
  const auto counts = [&](Lanes at)
                          HWY_ATTR { return hn::And(hn::Gt(at, first), hn::Lt(at, last)); };
  // Entering shows the front, leaving the back.
  const Cull cull = row.cull[box];
  const auto enters = cull == Cull::front ? hn::Lt(zero, zero) : counts(enter);
  const auto leaves = cull == Cull::back ? hn::Lt(zero, zero) : counts(leave);
  t = hn::IfThenElse(enters, enter, leave);
  const auto has_roots = hn::Ge(discriminant, zero);
  return hn::AndNot(is_missed, hn::And(has_roots, hn::Or(enters, leaves)));
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
