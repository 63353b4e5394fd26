#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "renderer/math/quadratic.h"
#include "renderer/math/rounding.h"

namespace tessera {

// Real roots of polynomials of small degree in an interval: the roots of the derivative cut it into
// monotone pieces, each with at most one root, found by Newton's method kept inside a shrinking
// bracket (Yuksel, High-Performance Polynomial Root Finding for Graphics, HPG 2022). No closed form
// of a cubic or quartic is used: those lose roots where coefficients cancel. Nothing allocates.

/// Coefficients from the constant up.
template <int Degree>
using Polynomial = std::array<double, Degree + 1>;

/// A polynomial's value by Horner's rule in twice the working precision (Graillat, Langlois, Louvet
/// 2009), and the sum of the magnitudes of its terms.
struct PolynomialValue {
  double value = 0, magnitude = 0;
};

template <int Degree>
PolynomialValue evaluate(const Polynomial<Degree>& p, double x) {
  double sum = p[Degree], correction = 0, magnitude = std::abs(p[Degree]);
  const double size = std::abs(x);
  for (int i = Degree - 1; i >= 0; --i) {
    const DoubleDouble product = two_product(sum, x);
    const DoubleDouble next = two_sum(product.high, p[i]);
    correction = correction * x + (product.low + next.low);
    sum = next.high;
    magnitude = magnitude * size + std::abs(p[i]);
  }
  return {sum + correction, magnitude};
}

template <int Degree>
Polynomial<Degree - 1> derivative(const Polynomial<Degree>& p) {
  Polynomial<Degree - 1> d;
  for (int i = 1; i <= Degree; ++i) d[i - 1] = i * p[i];
  return d;
}

/// Where `value` changes sign between `low` and `high`; rises says that it is negative at `low`.
/// `newton(x)` returns {value, slope}. Ends when the bracket or the step is below rounding.
template <typename Newton>
double bracketed_root(double low, double high, bool rises, const Newton& newton) {
  double x = low + 0.5 * (high - low);
  for (int i = 0; i < 200; ++i) {
    const auto [value, slope] = newton(x);
    if (value == 0) return x;
    ((value < 0) == rises ? low : high) = x;
    double next = x - value / slope;
    const double middle = low + 0.5 * (high - low);
    // A step out of the bracket, or one that has not converged after many, gives way to halving.
    if (!(next > low && next < high) || (i > 8 && i % 2 == 0)) next = middle;
    if (next == x || next == low || next == high) return next;
    x = next;
  }
  return x;
}

/// The distinct real roots inside [low, high], ascending; their number. A root that only touches
/// zero, within the rounding of the coefficients, counts once.
template <int Degree>
int roots_between(const Polynomial<Degree>& p, double low, double high,
                  std::array<double, Degree>& roots) {
  static_assert(Degree >= 1);
  if constexpr (Degree == 1) {
    if (p[1] == 0) return 0;
    roots[0] = 0 - p[0] / p[1];
    return roots[0] >= low && roots[0] <= high ? 1 : 0;
  } else if constexpr (Degree == 2) {
    double r[2];
    const int found = solve_quadratic(p[2], p[1], p[0], r);
    int n = 0;
    for (int i = 0; i < found; ++i)
      if (r[i] >= low && r[i] <= high) roots[n++] = r[i];
    return n;
  } else {
    const Polynomial<Degree - 1> slope = derivative<Degree>(p);
    std::array<double, Degree - 1> turns;
    const int turn_count = roots_between<Degree - 1>(slope, low, high, turns);
    const auto newton = [&](double x) {
      return std::pair{evaluate<Degree>(p, x).value, evaluate<Degree - 1>(slope, x).value};
    };
    // The sign of p at a piece's end; 0 where p is zero within the rounding of its coefficients.
    const auto sign = [&](double x) {
      const PolynomialValue v = evaluate<Degree>(p, x);
      if (std::abs(v.value) <= 2 * kUnitRoundoff * v.magnitude) return 0;
      return v.value < 0 ? -1 : 1;
    };
    int n = 0;
    double x0 = low;
    int s0 = sign(low);
    if (s0 == 0) roots[n++] = low;
    for (int i = 0; i <= turn_count; ++i) {
      const double x1 = i < turn_count ? turns[i] : high;
      if (!(x1 > x0)) continue;
      const int s1 = sign(x1);
      if (s0 * s1 < 0 && n < Degree) roots[n++] = bracketed_root(x0, x1, s0 < 0, newton);
      // Two neighbouring ends at zero are one root that the turning points could not tell apart.
      if (s1 == 0 && s0 != 0 && n < Degree) roots[n++] = x1;
      x0 = x1;
      s0 = s1;
    }
    return n;
  }
}

/// The distinct real roots of c[4] x^4 + ... + c[0], c[4] not 0, ascending; their number.
inline int solve_quartic(const Polynomial<4>& c, std::array<double, 4>& roots) {
  // Fujiwara's bound on the magnitude of every root, 2 max |c[4-i] / c[4]|^(1/i), rounded up to a
  // power of two.
  double bound = 0;
  for (int i = 1; i <= 4; ++i) {
    const double ratio = c[4 - i] / c[4];
    if (ratio == 0) continue;
    const int exponent = std::ilogb(ratio) + 1;
    const int root = exponent > 0 ? (exponent + i - 1) / i : -(-exponent / i);
    bound = std::max(bound, std::ldexp(2.0, root));
  }
  return roots_between<4>(c, -bound, bound, roots);
}

}  // namespace tessera
