// Compiled once for each instruction set: LambertBsdf at many points, a lane each, to the last bit.
#if defined(TESSERA_LANE_LAMBERT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_LANE_LAMBERT_INL_H
#undef TESSERA_LANE_LAMBERT_INL_H
#else
#define TESSERA_LANE_LAMBERT_INL_H
#endif

#include <hwy/highway.h>

#include "renderer/math/elementary.h"
#include "renderer/math/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

HWY_INLINE Lanes greatest(const Lanes3& c) { return max(c.x, max(c.y, c.z)); }
/// bounded() of a colour.
HWY_INLINE Lanes3 bounded(const Lanes3& color) {
  const Lanes largest = greatest(color);
  const auto exceeds = hn::Gt(largest, broadcast(1));
  return select(exceeds, multiply(color, hn::Div(broadcast(1), largest)), color);
}

/// small_sine_cosine()
HWY_INLINE Lanes2 small_sine_cosine(Lanes x) {
  const auto minus = [](double a, Lanes q, double b)
                         HWY_ATTR { return hn::Sub(broadcast(a), hn::Mul(q, broadcast(b))); };
  const Lanes q = hn::Mul(x, x), q2 = hn::Mul(q, q), q4 = hn::Mul(q2, q2);
  const Lanes sine =
      hn::Add(hn::Add(minus(1, q, 1.0 / 6), hn::Mul(q2, minus(1.0 / 120, q, 1.0 / 5040))),
              hn::Mul(q4, hn::Add(minus(1.0 / 362880, q, 1.0 / 39916800),
                                  hn::Mul(q2, broadcast(1.0 / 6227020800)))));
  const Lanes cosine =
      hn::Add(hn::Add(minus(1, q, 1.0 / 2), hn::Mul(q2, minus(1.0 / 24, q, 1.0 / 720))),
              hn::Mul(q4, hn::Add(minus(1.0 / 40320, q, 1.0 / 3628800),
                                  hn::Mul(q2, minus(1.0 / 479001600, q, 1.0 / 87178291200)))));
  return {hn::Mul(x, sine), cosine};
}
/// cosine_hemisphere_point()
HWY_INLINE Lanes3 cosine_hemisphere_point(const Lanes2& u) {
  const Lanes zero = hn::Zero(kLaneTag), one = broadcast(1), two = broadcast(2);
  const Lanes a = hn::Sub(hn::Mul(two, u.x), one), b = hn::Sub(hn::Mul(two, u.y), one);
  const auto is_middle = hn::And(hn::Eq(a, zero), hn::Eq(b, zero));
  const auto wide = hn::Gt(hn::Abs(a), hn::Abs(b));
  const Lanes longer = hn::IfThenElse(wide, a, b), shorter = hn::IfThenElse(wide, b, a);
  const Lanes2 turn =
      small_sine_cosine(hn::Mul(broadcast(portable::kPi / 4), hn::Div(shorter, longer)));
  const Lanes along = hn::Mul(longer, turn.y), across = hn::Mul(longer, turn.x);
  const Lanes x = hn::IfThenZeroElse(is_middle, hn::IfThenElse(wide, along, across));
  const Lanes y = hn::IfThenZeroElse(is_middle, hn::IfThenElse(wide, across, along));
  const Lanes left = hn::Sub(hn::Sub(one, hn::Mul(x, x)), hn::Mul(y, y));
  return {x, y, hn::Sqrt(max(zero, left))};
}
/// Frame(z).from_local(v)
HWY_INLINE Lanes3 from_local(const Lanes3& z, const Lanes3& v) {
  const Lanes one = broadcast(1);
  const Lanes sign = hn::CopySign(one, z.z);
  const Lanes a = hn::Div(hn::Neg(one), hn::Add(sign, z.z));
  const Lanes b = hn::Mul(hn::Mul(z.x, z.y), a);
  const Lanes3 x{hn::Add(one, hn::Mul(hn::Mul(hn::Mul(sign, z.x), z.x), a)), hn::Mul(sign, b),
                 hn::Mul(hn::Neg(sign), z.x)};
  const Lanes3 y{b, hn::Add(sign, hn::Mul(hn::Mul(z.y, z.y), a)), hn::Neg(z.y)};
  return add(add(multiply(x, v.x), multiply(y, v.y)), multiply(z, v.z));
}

/// BsdfValue
struct LaneValue {
  Lanes3 share;
  Lanes density;
};
class LaneLambert {
 public:
  /// `facet` is the geometric normal, towards the viewer.
  HWY_INLINE LaneLambert(const Lanes3& diffuse, const Lanes3& shading, const Lanes3& facet)
      : albedo_(bounded(diffuse)), normal_(shading), facet_(facet) {}
  const Lanes3& albedo() const { return albedo_; }
  HWY_INLINE LaneValue evaluate(const Lanes3& wi) const {
    const auto is_before = hn::Gt(dot(wi, facet_), hn::Zero(kLaneTag));
    const Lanes density = hn::IfThenElseZero(is_before, density_of(dot(wi, normal_)));
    const Lanes mirrored = hn::IfThenElseZero(is_before, density_mirrored_to(wi));
    return {add(multiply(albedo_, density), multiply(albedo_, mirrored)),
            hn::Add(density, mirrored)};
  }
  /// Whether each goes on.
  HWY_INLINE LaneMask sample(const Lanes2& u, Lanes3& wi, Lanes& density) const {
    const Lanes zero = hn::Zero(kLaneTag);
    const Lanes3 local = cosine_hemisphere_point(u);
    wi = from_local(normal_, local);
    density = hn::Add(density_of(local.z), density_mirrored_to(wi));
    const Lanes height = dot(wi, facet_);
    wi = select(hn::Lt(height, zero), reflect(wi, facet_), wi);
    return hn::And(hn::Gt(local.z, zero), hn::Ne(height, zero));
  }

 private:
  static HWY_INLINE Lanes density_of(Lanes cosine) {
    return hn::Mul(max(cosine, hn::Zero(kLaneTag)), broadcast(1 / portable::kPi));
  }
  HWY_INLINE Lanes density_mirrored_to(const Lanes3& wi) const {
    return density_of(dot(reflect(wi, facet_), normal_));
  }

  Lanes3 albedo_, normal_, facet_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
