#include "bench/error/reference.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tessera {

Picture Reference::mean() const {
  Picture out = first;
  for (size_t i = 0; i < out.values.size(); ++i)
    out.values[i] = static_cast<float>((double{first.values[i]} + double{second.values[i]}) / 2);
  return out;
}

double Reference::error(const PixelMask& mask) const {
  double sum = 0;
  const size_t values = for_each_value(0, first.pixels(), mask, [&](size_t i) {
    const double d = finite(first.values[i]) - finite(second.values[i]);
    sum += d * d;
  });
  return std::sqrt(sum / static_cast<double>(values)) / 2;
}

double mean_square_error(const Picture& picture, const Reference& reference,
                         const PixelMask& mask) {
  check_alike(picture, reference.first);
  double sum = 0;
  const size_t values = for_each_value(0, picture.pixels(), mask, [&](size_t i) {
    const double x = finite(picture.values[i]);
    sum += (x - finite(reference.first.values[i])) * (x - finite(reference.second.values[i]));
  });
  return sum / static_cast<double>(values);
}

BiasEstimator::BiasEstimator(Reference reference, PixelMask mask)
    : reference_(std::move(reference)),
      mask_(std::move(mask)),
      sum_(reference_.first.values.size()),
      sum_of_squares_(sum_.size()) {}

void BiasEstimator::add(const Picture& picture) {
  check_alike(picture, reference_.first);
  ++count_;
  for (size_t i = 0; i < sum_.size(); ++i) {
    const double d = finite(picture.values[i]) - finite(reference_.first.values[i]);
    sum_[i] += d;
    sum_of_squares_[i] += d * d;
  }
}

BiasEstimator::Result BiasEstimator::result() const {
  Result out;
  if (count_ < 2) return out;
  double sum = 0, sum_of_squares = 0;
  size_t pixels = 0;
  for (size_t pixel = 0; pixel < reference_.first.pixels(); ++pixel) {
    if (!counts(mask_, pixel)) continue;
    ++pixels;
    double square = 0;  // an estimate of the pixel's bias^2, its channels' mean
    for (size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      const double mean = sum_[i] / count_;
      const double variance =
          std::max(0.0, (sum_of_squares_[i] - count_ * mean * mean) / (count_ - 1));
      const double between =
          finite(reference_.second.values[i]) - finite(reference_.first.values[i]);
      square += (mean * (mean - between) - variance / count_) / 3;
      out.variance += variance / 3;
    }
    sum += square;
    sum_of_squares += square * square;
  }
  const auto count = static_cast<double>(pixels);
  const double mean = sum / count;
  out.variance /= count;
  out.bias = std::sqrt(std::max(0.0, mean));
  const double spread = std::max(0.0, sum_of_squares / count - mean * mean);
  out.sigmas = spread > 0 ? mean / std::sqrt(spread / count) : 0;
  return out;
}

}  // namespace tessera
