#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "renderer/math/numbers.h"

namespace tessera {

// Bounds on rounding errors, and arithmetic that knows its own error (Higham, Accuracy and
// Stability of Numerical Algorithms; Ogita, Rump, Oishi 2005). No function here uses a fused
// multiply-add, so the bits are the same on every host.

/// Half an ulp of 1: the largest relative error of one rounding.
inline constexpr double kUnitRoundoff = std::numeric_limits<double>::epsilon() * 0.5;

/// Bound on the relative error of n roundings in a row.
inline constexpr double gamma(int n) { return n * kUnitRoundoff / (1 - n * kUnitRoundoff); }

/// The next larger value; +infinity and NaN stay as they are.
inline double next_up(double x) {
  if (!(x < std::numeric_limits<double>::infinity())) return x;
  if (x == 0) return std::numeric_limits<double>::denorm_min();
  const auto bits = std::bit_cast<int64_t>(x);
  return std::bit_cast<double>(bits + (x > 0 ? 1 : -1));
}
inline double next_down(double x) { return -next_up(-x); }
/// The next larger value where `way` is positive, the next smaller one where it is negative.
inline double next_towards(double x, double way) {
  if (way > 0) return next_up(x);
  if (way < 0) return next_down(x);
  return x;
}
inline float next_up(float x) {
  if (!(x < std::numeric_limits<float>::infinity())) return x;
  if (x == 0) return std::numeric_limits<float>::denorm_min();
  const auto bits = std::bit_cast<int32_t>(x);
  return std::bit_cast<float>(bits + (x > 0 ? 1 : -1));
}
inline float next_down(float x) { return -next_up(-x); }

/// The largest float at most x; NaN stays NaN.
inline float float_down(double x) {
  const float f = static_cast<float>(x);
  return f > x ? next_down(f) : f;
}
/// The smallest float at least x; NaN stays NaN.
inline float float_up(double x) { return -float_down(-x); }

/// A sum high + low of two doubles that do not overlap: about 106 bits.
struct DoubleDouble {
  double high = 0, low = 0;
};

/// 2^27 + 1: what Veltkamp multiplies a double with to cut it into halves of 26 bits, whose
/// products are exact.
inline constexpr double kSplit = 134217729;

using NumPair = DoubleDouble;

#include "renderer/math/exact_sums-inl.h"

}  // namespace tessera
