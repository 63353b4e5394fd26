#pragma once

#include <cstdint>

#include "renderer/math/vec.h"

namespace tessera {

/// SplitMix64 (Steele et al. 2014): the same numbers on every machine.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t bits() {
    uint64_t z = state_ += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return z ^ z >> 31;
  }
  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  /// Uniform in [-1, 1)^3.
  Vec3 in_cube() {
    const double x = uniform(), y = uniform(), z = uniform();
    return {2 * x - 1, 2 * y - 1, 2 * z - 1};
  }

 private:
  uint64_t state_;
};

}  // namespace tessera
