#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace tessera {

// Functions that compilers, unlike those of the C library, make run for several numbers at a time.

/// As std::min and std::max, whose references keep them from that.
inline float smaller(float a, float b) { return b < a ? b : a; }
inline float larger(float a, float b) { return a < b ? b : a; }

/// Of a positive number that is not tiny, within two units in the last place.
inline float cube_root(float v) {
  constexpr uint32_t kThirdOfBias = 0x2a5137a0;
  auto root = std::bit_cast<float>(std::bit_cast<uint32_t>(v) / 3 + kThirdOfBias);
  for (int i = 0; i < 2; ++i) {  // Halley's steps
    const float cube = root * root * root;
    root *= (cube + 2 * v) / (2 * cube + v);
  }
  return root;
}

/// Of a positive number that is not tiny, within 1e-7 and as much of the result.
inline float log2_of(float v) {
  // The exponent is that of v over the root of a half, so that the rest is around 1.
  constexpr uint32_t kRootOfHalf = 0x3f3504f3;
  const uint32_t bits = std::bit_cast<uint32_t>(v) - kRootOfHalf;
  const auto exponent = static_cast<float>(static_cast<int32_t>(bits) >> 23);
  const auto rest = std::bit_cast<float>((bits & 0x7fffff) + kRootOfHalf);
  // ln x is twice the area tangent of this.
  const float t = (rest - 1) / (rest + 1), tt = t * t;
  constexpr float kScale = 2.88539008F;  // 2 / ln 2
  return exponent + kScale * t * (1 + tt * (1.F / 3 + tt * (1.F / 5 + tt * (1.F / 7 + tt / 9))));
}

/// Of a number between -100 and 100, within 1e-7 of the result.
inline float exp2_of(float v) {
  const auto whole = static_cast<int32_t>(v + std::copysign(.5F, v));
  constexpr float kLn2 = .693147181F;
  const float x = (v - static_cast<float>(whole)) * kLn2;
  const float power =
      1 +
      x * (1 + x * (1.F / 2 +
                    x * (1.F / 6 + x * (1.F / 24 + x * (1.F / 120 + x * (1.F / 720 + x / 5040))))));
  return power * std::bit_cast<float>(static_cast<uint32_t>(whole + 127) << 23);
}

/// base^exponent of a base from 0 to 1000 and an exponent from 0 to 1, within 2e-6 of the result.
/// 0^0 is 1.
inline float power(float base, float exponent) {
  constexpr float kTiny = 1e-30F;
  const float result = exp2_of(exponent * log2_of(larger(base, kTiny)));
  const bool is_zero = (base <= kTiny) & (exponent != 0);
  return result * (is_zero ? 0.F : 1.F);  // a choice between two results would be a branch
}

}  // namespace tessera
