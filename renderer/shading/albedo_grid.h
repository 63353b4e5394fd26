#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace tessera {

/// What rough facets do on the mean, a Value (which can be added and scaled), over their alpha and
/// the cosine towards which they do it. Worked out at so many steps of the square root of either;
/// between them linear in the root of alpha and in the cosine itself. Immutable once made.
template <typename Value, int kAlphas, int kCosines>
class AlbedoGrid {
 public:
  /// A step, and how far from it to the next one.
  struct Step {
    int index;
    double rest;
  };

  static double cosine_at(int step) {
    const double x = static_cast<double>(step) / kCosines;
    return x * x;
  }
  /// At or below `x`, taken as 0 below that and where it is no number, and as 1 above.
  static Step step_at(double x, int steps) {
    const double scaled = (x > 0 ? std::min(x, 1.0) : 0.0) * steps;
    const int index = std::min(static_cast<int>(scaled), steps - 1);
    return {index, scaled - index};
  }
  static Step step_at_cosine(double cosine) {
    const int index = step_at(std::sqrt(std::max(cosine, 0.0)), kCosines).index;
    const double from = cosine_at(index), to = cosine_at(index + 1);
    return {index, std::clamp((cosine - from) / (to - from), 0.0, 1.0)};
  }

  /// `integrate` is called with the root of alpha, in [0, 1], and a cosine in [0, 1].
  template <typename Integrate>
  explicit AlbedoGrid(const Integrate& integrate) {
    for (int a = 0; a <= kAlphas; ++a) {
      for (int c = 0; c <= kCosines; ++c) {
        at_[a][c] = integrate(static_cast<double>(a) / kAlphas, cosine_at(c));
      }
      // 2 * the integral of cosine * what lies linearly between the steps.
      mean_[a] = at_[a][0] * 0;
      for (int c = 0; c < kCosines; ++c) {
        const double from = cosine_at(c), to = cosine_at(c + 1), third = (to - from) / 3;
        const double low = third * (2 * from + to), high = third * (from + 2 * to);
        mean_[a] = mean_[a] + (at_[a][c] * low + at_[a][c + 1] * high);
      }
    }
  }

  static constexpr int kRows = kAlphas + 1;
  const Value& mean_of(int row) const { return mean_[row]; }
  /// Applies a linear `change` to all values of one step of alpha, and so to their mean.
  template <typename Change>
  void change(int row, const Change& change) {
    for (Value& value : at_[row]) change(value);
    change(mean_[row]);
  }

  Value at(double alpha, double cosine) const {
    const Step a = step_at(std::sqrt(alpha), kAlphas), c = step_at_cosine(cosine);
    const auto along = [&](int row) {
      return between(at_[row][c.index], at_[row][c.index + 1], c.rest);
    };
    return between(along(a.index), along(a.index + 1), a.rest);
  }
  /// Over the hemisphere, by the cosine.
  Value mean(double alpha) const {
    const Step a = step_at(std::sqrt(alpha), kAlphas);
    return between(mean_[a.index], mean_[a.index + 1], a.rest);
  }

 private:
  static Value between(const Value& a, const Value& b, double t) { return a + (b + a * -1) * t; }

  std::array<std::array<Value, kCosines + 1>, kAlphas + 1> at_;
  std::array<Value, kAlphas + 1> mean_;
};

}  // namespace tessera
