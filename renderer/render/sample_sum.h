#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "renderer/math/color.h"

namespace tessera {

/// Whether a pixel can hold it: no NaN, and nothing beyond the range of float.
inline bool is_representable(const Color& c) {
  return std::isfinite(static_cast<float>(c.r)) && std::isfinite(static_cast<float>(c.g)) &&
         std::isfinite(static_cast<float>(c.b));
}

/// What a sample found, and the sign of the filter where it looked.
struct Sample {
  Color color;
  bool negative = false;
};

/// The samples of a pixel, added up in the order of their numbers.
///
/// With signs s and the filter's gain g the mean of g s c would spread with the sum of the signs, a
/// constant picture's too. So the rest to a weight of 1 goes to the plain mean: mean of c_i (g s_i
/// + 1 - g mean of s). A constant keeps its bits, no sum is divided by, and the bias is of the
/// order of 1 / n, the covariance of the two means. All is kept as differences from the first
/// sample.
class SampleSum {
 public:
  /// `gain` is 1 where no sample is negative. `spreads`: variance() will be asked for.
  explicit SampleSum(double gain = 1, bool spreads = false) : gain_(gain), spreads_(spreads) {}

  void add(const Sample& sample) {
    ++count_;
    if (spreads_) {
      if (count_ == 1) origin_ = sample.color;
      const Color away = sample.color - origin_;
      spread_sum_ += away;
      squares_ += away * away;
    }
    if (gain_ == 1) {
      sum_ += sample.color;
      return;
    }
    if (count_ == 1) first_ = sample.color;
    const double sign = sample.negative ? -1 : 1;
    const Color away = sample.color - first_;
    sum_ += away;
    signed_sum_ += sign * away;
    signs_ += sign;
  }
  /// Of one sample or more.
  Color mean() const {
    const double share = 1.0 / count_;
    if (gain_ == 1) return sum_ * share;
    return first_ + (sum_ + gain_ * (signed_sum_ - sum_ * (signs_ * share))) * share;
  }
  uint32_t count() const { return count_; }
  /// Of mean(), were the samples independent; 0 for one sample, which tells nothing of it.
  Color variance() const {
    if (count_ < 2) return kBlack;
    const double n = count_;
    const Color spread = squares_ - spread_sum_ * spread_sum_ * (1 / n);
    const double share = gain_ * gain_ / (n * (n - 1));
    return Color{std::max(spread.r, 0.0), std::max(spread.g, 0.0), std::max(spread.b, 0.0)} * share;
  }

 private:
  double gain_;
  bool spreads_;
  uint32_t count_ = 0;
  Color origin_, spread_sum_, squares_;
  Color sum_, first_, signed_sum_;
  double signs_ = 0;
};

}  // namespace tessera
