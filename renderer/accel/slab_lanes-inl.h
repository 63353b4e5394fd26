// Compiled once for each instruction set: as many rays as there are lanes against boxes.
#if defined(TESSERA_SLAB_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_SLAB_LANES_INL_H
#undef TESSERA_SLAB_LANES_INL_H
#else
#define TESSERA_SLAB_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <limits>

#include "renderer/accel/box_soa.h"
#include "renderer/math/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// One over each, never infinite, as SlabAxis.
HWY_INLINE Lanes inverse_of(Lanes direction) {
  const Lanes most = broadcast(BoxSoA::kMostInverse);
  return hn::Max(hn::Neg(most), hn::Min(broadcast(1) / direction, most));
}

/// As many rays as there are lanes, held against boxes one after the other; the test of
/// BvhKernels::boxes_entered.
class SlabLanes {
 public:
  HWY_INLINE SlabLanes(const Lanes3& origin, const Lanes3& direction)
      : far_(sum(abs(origin))),
        steep_(sum(abs(direction))),
        inverse_{inverse_of(direction.x), inverse_of(direction.y), inverse_of(direction.z)},
        offset_(origin * inverse_) {}

  /// Whose answers count; others may hit anything.
  HWY_INLINE LaneMask are_usual(const BoxSoA& boxes) const {
    // Of no boxes every answer is right, if the ray is one.
    const double farthest = boxes.all == 0 ? std::numeric_limits<double>::max() : boxes.farthest;
    const auto is_steep = hn::And(hn::Ge(steep_, broadcast(BoxSoA::kLeastSteep)),
                                  hn::Le(steep_, broadcast(BoxSoA::kMostSteep)));
    return hn::And(hn::Le(far_, broadcast(farthest)), is_steep);
  }
  /// Which of them may hit something in box `i` from `enter` to `leave`; raises `enter` to a lower
  /// bound of t there.
  HWY_INLINE LaneMask entered(const BoxSoA& boxes, size_t i, Lanes& enter, Lanes leave) const {
    const auto narrow = [&](const double* min, const double* max, Lanes inverse, Lanes offset)
                            HWY_ATTR {
                              const Lanes a = hn::MulSub(broadcast(min[i]), inverse, offset);
                              const Lanes b = hn::MulSub(broadcast(max[i]), inverse, offset);
                              enter = hn::Max(enter, hn::Min(a, b));
                              leave = hn::Min(leave, hn::Max(a, b));
                            };
    narrow(boxes.min[0], boxes.max[0], inverse_.x, offset_.x);
    narrow(boxes.min[1], boxes.max[1], inverse_.y, offset_.y);
    narrow(boxes.min[2], boxes.max[2], inverse_.z, offset_.z);
    return hn::Le(enter, leave);
  }

  const Lanes3& inverse() const { return inverse_; }

 private:
  Lanes far_, steep_;
  Lanes3 inverse_, offset_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
