#pragma once

#include <cstdint>

namespace tessera {

/// The generator of java.util.Random, as its documentation gives it: the same numbers from the same
/// seed.
class JavaRandom {
 public:
  explicit constexpr JavaRandom(uint64_t seed) : state_((seed ^ kMultiplier) & kMask) {}

  /// Uniform in [0, 1).
  constexpr double next_double() {
    const uint64_t high = next(26), low = next(27);
    return static_cast<double>((high << 27) + low) * 0x1p-53;
  }

 private:
  static constexpr uint64_t kMultiplier = 0x5DEECE66D;
  static constexpr uint64_t kMask = (uint64_t{1} << 48) - 1;

  constexpr uint64_t next(int bits) {
    state_ = (state_ * kMultiplier + 0xB) & kMask;
    return state_ >> (48 - bits);
  }

  uint64_t state_;
};

}  // namespace tessera
