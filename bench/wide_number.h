#pragma once

#include <cmath>

#include "renderer/math/precise_vec.h"
#include "renderer/math/rounding.h"

namespace tessera {

/// A number of about 106 bits (Dekker 1971), to hold double precision against.
struct Wide {
  double high = 0, low = 0;

  Wide() = default;
  Wide(double x) : high(x) {}
  Wide(const DoubleDouble& d) : high(d.high), low(d.low) {}
  explicit operator double() const { return high + low; }
};

inline Wide operator+(const Wide& a, const Wide& b) {
  const DoubleDouble s = two_sum(a.high, b.high), e = two_sum(a.low, b.low);
  const DoubleDouble r = fast_two_sum(s.high, s.low + e.high);
  return fast_two_sum(r.high, r.low + e.low);
}
inline Wide operator-(const Wide& a) { return DoubleDouble{-a.high, -a.low}; }
inline Wide operator-(const Wide& a, const Wide& b) { return a + -b; }
inline Wide operator*(const Wide& a, const Wide& b) {
  const DoubleDouble p = two_product(a.high, b.high);
  return fast_two_sum(p.high, p.low + (a.high * b.low + a.low * b.high));
}
inline Wide operator/(const Wide& a, const Wide& b) {
  const double q = a.high / b.high;
  const Wide rest = a - b * Wide(q);
  return Wide(q) + Wide(double(rest) / b.high);
}
inline Wide sqrt(const Wide& a) {
  if (!(a.high > 0)) return 0;
  const double root = std::sqrt(a.high);
  return Wide(root) + Wide(double(a - Wide(root) * Wide(root)) / (2 * root));
}

using WideVec = PreciseVec<Wide>;

}  // namespace tessera
