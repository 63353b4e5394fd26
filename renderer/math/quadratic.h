#pragma once

#include <cmath>
#include <utility>

#include "renderer/math/rounding.h"

namespace tessera {

/// The real roots of a x^2 + b x + c, ascending, each at most 4 ulp off; their number. A double
/// root counts once. The sign of the discriminant is always right where no product leaves the range
/// of two_product (Kahan, On the Cost of Floating-Point Computation Without Extra-Precise
/// Arithmetic). With a = 0 it solves the linear equation; 0 = 0 has no root that could be named.
inline int solve_quadratic(double a, double b, double c, double (&roots)[2]) {
  if (a == 0) {
    if (b == 0) return 0;
    roots[0] = 0 - c / b;
    return 1;
  }
  const double discriminant = difference_of_products(b, b, 4 * a, c);
  if (!(discriminant >= 0)) return 0;
  if (discriminant == 0) {
    roots[0] = 0 - b / (2 * a);
    return 1;
  }
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  roots[0] = q / a;
  roots[1] = c / q;
  if (roots[0] > roots[1]) std::swap(roots[0], roots[1]);
  return roots[0] == roots[1] ? 1 : 2;
}

}  // namespace tessera
