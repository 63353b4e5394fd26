#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

#include "metrics/picture.h"

namespace tessera::testing {

inline Picture constant(int width, int height, float r, float g, float b) {
  Picture out{width, height, {}};
  for (size_t i = 0; i < out.pixels(); ++i) out.values.insert(out.values.end(), {r, g, b});
  return out;
}

/// Of values around the mean, at most half of `spread` away.
inline Picture noise(int width, int height, uint64_t seed, double mean, double spread) {
  std::mt19937_64 random(seed);
  Picture out{width, height, {}};
  for (size_t i = 0; i < 3 * out.pixels(); ++i) {
    const double unit = static_cast<double>(random() >> 11) * 0x1p-53;
    out.values.push_back(static_cast<float>(mean + spread * (unit - .5)));
  }
  return out;
}

}  // namespace tessera::testing
