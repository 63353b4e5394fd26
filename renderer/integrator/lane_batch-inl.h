// Compiled once for each instruction set: some of a batch's rays and their hits, a lane each, out
// of it and into the next one.
#if defined(TESSERA_LANE_BATCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_LANE_BATCH_INL_H
#undef TESSERA_LANE_BATCH_INL_H
#else
#define TESSERA_LANE_BATCH_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "renderer/accel/ray_batch.h"
#include "renderer/math/color.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/math/vec.h"
#include "renderer/shapes/ray.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

HWY_INLINE Lanes gather(const double* values, LaneIndices places) {
  return hn::GatherIndex(kLaneTag, values, places);
}
HWY_INLINE Lanes3 gather(const double (&parts)[3][RayBatch::kPadded], LaneIndices places) {
  return {gather(parts[0], places), gather(parts[1], places), gather(parts[2], places)};
}
/// One part of each hit.
template <double Hit::*kPart>
HWY_INLINE Lanes gather_hits(const Hit* hits, LaneIndices places) {
  static_assert(sizeof(Hit) == 4 * sizeof(double));
  return gather(&(hits->*kPart), hn::ShiftLeft<2>(places));
}
/// Of kLanes places.
HWY_INLINE LaneIndices indices_of(const uint32_t* places) {
  const hn::Rebind<uint32_t, LaneTag> narrow;
  return hn::BitCast(kIndexTag,
                     hn::PromoteTo(hn::RebindToUnsigned<LaneTag>(), hn::LoadU(narrow, places)));
}

// One by one.
template <size_t kPadded>
Vec3 vec_at(const double (&parts)[3][kPadded], size_t at) {
  return {parts[0][at], parts[1][at], parts[2][at]};
}
template <size_t kPadded>
Color color_at(const double (&parts)[3][kPadded], size_t at) {
  return {parts[0][at], parts[1][at], parts[2][at]};
}
template <size_t kPadded>
void put(const Vec3& v, size_t at, double (&parts)[3][kPadded]) {
  for (int axis = 0; axis < 3; ++axis) parts[axis][at] = v[axis];
}
template <size_t kPadded>
void put(const Color& c, size_t at, double (&parts)[3][kPadded]) {
  parts[0][at] = c.r, parts[1][at] = c.g, parts[2][at] = c.b;
}

constexpr uint32_t kAllLanes = (1u << kLanes) - 1;
/// The lanes of `bits`, one after the other; what is behind them may be overwritten. Not by
/// hn::Compress(), for which GCC 12 copies a table of 512 bytes each time.
HWY_INLINE void append(Lanes values, uint32_t bits, double* at) {
  if (bits == kAllLanes) {
    hn::StoreU(values, kLaneTag, at);
    return;
  }
  alignas(64) double each[kLanes];
  hn::Store(values, kLaneTag, each);
  while (bits != 0) *at++ = each[take_lowest_lane(bits)];
}
HWY_INLINE void append(const Lanes3& values, uint32_t bits, size_t at,
                       double (&parts)[3][RayBatch::kPadded]) {
  append(values.x, bits, parts[0] + at);
  append(values.y, bits, parts[1] + at);
  append(values.z, bits, parts[2] + at);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
