// Compiled once for each instruction set: SampleStream::pair() of many samples, a lane each, to the
// last bit.
#if defined(TESSERA_LANE_SAMPLER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_LANE_SAMPLER_INL_H
#undef TESSERA_LANE_SAMPLER_INL_H
#else
#define TESSERA_LANE_SAMPLER_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "renderer/math/lanes-inl.h"
#include "renderer/sampler/sampler.h"
#include "renderer/sampler/scramble.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

class LaneStream {
 public:
  /// Of kLanes samples.
  explicit LaneStream(const SampleStream* const* streams) : stream_(*streams[0]) {}
  Lanes2 pair(SampleUse use) const {
    const Vec2 u = stream_.pair(use);
    return {broadcast(u.x), broadcast(u.y)};
  }

 private:
  SampleStream stream_;
};

#else

using WordTag = hn::RebindToUnsigned<LaneTag>;
using HalfTag = hn::Repartition<uint32_t, WordTag>;
using Words = hn::Vec<WordTag>;
using Halves = hn::Vec<HalfTag>;  ///< of words, the lower one first
constexpr WordTag kWordTag;
constexpr HalfTag kHalfTag;

HWY_INLINE Words word(uint64_t value) { return hn::Set(kWordTag, value); }
HWY_INLINE Words low_half(Words v) { return hn::And(v, word(0xffffffffu)); }
/// No instruction set before AVX-512 multiplies words.
HWY_INLINE Words multiply_words(Words a, uint64_t b) {
  const Halves lows = hn::BitCast(kHalfTag, a);
  const Halves highs = hn::BitCast(kHalfTag, hn::ShiftRight<32>(a));
  const Halves low = hn::BitCast(kHalfTag, word(b & 0xffffffffu));
  const Halves high = hn::BitCast(kHalfTag, word(b >> 32));
  const Words crossed = hn::Add(hn::MulEven(highs, low), hn::MulEven(lows, high));
  return hn::Add(hn::MulEven(lows, low), hn::ShiftLeft<32>(crossed));
}
HWY_INLINE Words mix(Words v) {
  v = hn::Add(v, word(scramble::kMixStep));
  v = multiply_words(hn::Xor(v, hn::ShiftRight<30>(v)), scramble::kMixFirst);
  v = multiply_words(hn::Xor(v, hn::ShiftRight<27>(v)), scramble::kMixLast);
  return hn::Xor(v, hn::ShiftRight<31>(v));
}
HWY_INLINE Halves scramble_upwards(Halves v, Halves seed) {
  const auto half = [](uint32_t value) HWY_ATTR { return hn::Set(kHalfTag, value); };
  v = hn::Xor(v, hn::Mul(v, half(scramble::kUpwardsFirst)));
  v = hn::Add(v, seed);
  v = hn::Mul(v, hn::Or(hn::ShiftRight<16>(seed), half(1)));
  v = hn::Xor(v, hn::Mul(v, half(scramble::kUpwardsNext)));
  return hn::Xor(v, hn::Mul(v, half(scramble::kUpwardsLast)));
}
template <int kBits>
HWY_INLINE Halves swap_neighbours(Halves v, uint32_t lower) {
  const Halves mask = hn::Set(kHalfTag, lower);
  return hn::Or(hn::And(hn::ShiftRight<kBits>(v), mask), hn::ShiftLeft<kBits>(hn::And(v, mask)));
}
HWY_INLINE Halves reverse_bits(Halves v) {
  v = hn::Or(hn::ShiftRight<16>(v), hn::ShiftLeft<16>(v));
  v = swap_neighbours<8>(v, 0x00ff00ffu);
  v = swap_neighbours<4>(v, 0x0f0f0f0fu);
  v = swap_neighbours<2>(v, 0x33333333u);
  return swap_neighbours<1>(v, 0x55555555u);
}
HWY_INLINE Words sobol_second_reversed(Words index) {
  const auto add = [](Words v, Words shifted, uint64_t mask)
                       HWY_ATTR { return hn::Xor(v, hn::And(shifted, word(mask))); };
  index = add(index, hn::ShiftRight<1>(index), 0x55555555u);
  index = add(index, hn::ShiftRight<2>(index), 0x33333333u);
  index = add(index, hn::ShiftRight<4>(index), 0x0f0f0f0fu);
  index = add(index, hn::ShiftRight<8>(index), 0x00ff00ffu);
  return hn::Xor(index, hn::ShiftRight<16>(index));
}
/// Whole numbers below 2^32, over 2^32.
HWY_INLINE Lanes unit_of(Words v) {
  const Words exponent = word(0x4330000000000000u);  // of 2^52
  const Lanes shifted = hn::BitCast(kLaneTag, hn::Or(v, exponent));
  return hn::Mul(hn::Sub(shifted, broadcast(0x1p52)), broadcast(scramble::kUnit));
}

class LaneStream {
 public:
  /// Of kLanes samples, of one Sampler.
  HWY_INLINE explicit LaneStream(const SampleStream* const* streams)
      : is_independent_(streams[0]->is_independent()) {
    alignas(64) uint64_t keys[kLanes], samples[kLanes];
    for (size_t lane = 0; lane < kLanes; ++lane)
      keys[lane] = streams[lane]->key(), samples[lane] = streams[lane]->sample();
    key_ = hn::Load(kWordTag, keys);
    sample_ = hn::Load(kWordTag, samples);
  }
  HWY_INLINE Lanes2 pair(SampleUse use) const {
    const Words key = mix(hn::Xor(key_, word(static_cast<uint32_t>(use))));
    const Words both = is_independent_ ? mix(hn::Xor(key, mix(sample_))) : owen_sobol(key);
    return {unit_of(low_half(both)), unit_of(hn::ShiftRight<32>(both))};
  }

 private:
  HWY_INLINE Words owen_sobol(Words key) const {
    const Halves order =
        scramble_upwards(hn::BitCast(kHalfTag, sample_), hn::BitCast(kHalfTag, mix(key)));
    const Words index = low_half(hn::BitCast(kWordTag, reverse_bits(order)));
    const Words points = hn::Or(index, hn::ShiftLeft<32>(sobol_second_reversed(index)));
    const Halves scrambled =
        scramble_upwards(hn::BitCast(kHalfTag, points), hn::BitCast(kHalfTag, key));
    return hn::BitCast(kWordTag, reverse_bits(scrambled));
  }

  Words key_, sample_;  ///< SampleStream's
  bool is_independent_;
};

#endif

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
