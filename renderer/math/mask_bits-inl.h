// Compiled once for each instruction set.
#if defined(TESSERA_MASK_BITS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_MASK_BITS_INL_H
#undef TESSERA_MASK_BITS_INL_H
#else
#define TESSERA_MASK_BITS_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A bit for each of at most 8 lanes, the first the lowest.
template <typename Tag, typename Mask>
HWY_INLINE uint32_t movemask(Tag tag, Mask mask) {
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(tag, mask, bytes);
  return bytes[0];
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
