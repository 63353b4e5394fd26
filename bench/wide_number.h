#pragma once

#include <cmath>

#include "renderer/math/rounding.h"
#include "renderer/math/vec.h"

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

struct WideVec {
  Wide x, y, z;
  WideVec() = default;
  WideVec(const Wide& x_, const Wide& y_, const Wide& z_) : x(x_), y(y_), z(z_) {}
  WideVec(const Vec3& v) : x(v.x), y(v.y), z(v.z) {}
  WideVec(const Point3& p) : x(p.x), y(p.y), z(p.z) {}
};
inline WideVec operator+(const WideVec& a, const WideVec& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline WideVec operator-(const WideVec& a, const WideVec& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline WideVec operator*(const WideVec& a, const Wide& s) { return {a.x * s, a.y * s, a.z * s}; }
inline Wide dot(const WideVec& a, const WideVec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline WideVec cross(const WideVec& a, const WideVec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace tessera
