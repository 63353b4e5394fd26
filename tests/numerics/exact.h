#pragma once

#include <cmath>
#include <vector>

#include "renderer/math/rounding.h"

namespace tessera::numerics {

/// A number as an exact sum of doubles (Shewchuk 1997, "Adaptive Precision Floating-Point
/// Arithmetic"), in the range of two_product.
class Exact {
 public:
  Exact() = default;
  Exact(double x) { add(x); }

  friend Exact operator+(Exact a, const Exact& b) {
    for (const double term : b.terms_) a.add(term);
    return a;
  }
  friend Exact operator-(Exact a, const Exact& b) {
    for (const double term : b.terms_) a.add(-term);
    return a;
  }
  friend Exact operator*(const Exact& a, const Exact& b) {
    Exact product;
    for (const double x : a.terms_) {
      for (const double y : b.terms_) {
        const DoubleDouble xy = two_product(x, y);
        product.add(xy.low);
        product.add(xy.high);
      }
    }
    return product;
  }
  /// -1, 0 or 1.
  int sign() const { return terms_.empty() ? 0 : terms_.back() > 0 ? 1 : -1; }

 private:
  void add(double x) {
    size_t kept = 0;
    for (const double term : terms_) {
      const DoubleDouble s = two_sum(x, term);
      if (s.low != 0) terms_[kept++] = s.low;
      x = s.high;
    }
    terms_.resize(kept);
    if (x != 0) terms_.push_back(x);
  }

  std::vector<double> terms_;  ///< none is 0; they do not overlap, the largest is last
};

}  // namespace tessera::numerics
