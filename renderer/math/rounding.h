#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

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

/// a + b exactly (Knuth).
inline DoubleDouble two_sum(double a, double b) {
  const double s = a + b;
  const double from_b = s - a;
  return {s, (a - (s - from_b)) + (b - from_b)};
}
/// a + b exactly where |a| >= |b| or a is 0 (Dekker).
inline DoubleDouble fast_two_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}
/// 2^27 + 1: what Veltkamp multiplies a double with to cut it into halves of 26 bits, whose
/// products are exact.
inline constexpr double kSplit = 134217729;
/// a * b exactly (Veltkamp, Dekker), for |a|, |b| < 2^970 and a product above 2^-960.
inline DoubleDouble two_product(double a, double b) {
  const double p = a * b;
  const double ta = a * kSplit, tb = b * kSplit;
  const double ah = ta - (ta - a), bh = tb - (tb - b);
  const double al = a - ah, bl = b - bh;
  return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}

/// a * b - c * d with the right sign always and at most 2 ulp off, in the range of two_product.
/// Also a lane each in lane_triangle-inl.h, to the bit.
inline double difference_of_products(double a, double b, double c, double d) {
  const DoubleDouble ab = two_product(a, b);
  const DoubleDouble cd = two_product(c, d);
  const DoubleDouble s = two_sum(ab.high, -cd.high);
  const DoubleDouble e = two_sum(ab.low, -cd.low);
  const DoubleDouble t = two_sum(s.low, e.high);
  return s.high + (t.high + (t.low + e.low));
}

}  // namespace tessera
