#include "bench/error/metrics.h"

#include <algorithm>
#include <cmath>

#include "base/core_count.h"
#include "base/error.h"
#include "base/parallel.h"
#include "bench/error/flip.h"

namespace tessera {
namespace {

void check_alike(const Picture& a, const Picture& b) {
  TESSERA_CHECK(a.width == b.width && a.height == b.height && a.values.size() == b.values.size() &&
                    a.values.size() == 3 * a.pixels(),
                std::to_string(a.values.size()) + " and " + std::to_string(b.values.size()));
}

double finite(float value) { return std::isfinite(value) ? double{value} : 0; }

/// Calls visit(i) for every value of the pixels that count; returns how many there were.
template <typename Visit>
size_t for_each_value(size_t pixels, const PixelMask& mask, const Visit& visit) {
  size_t visited = 0;
  for (size_t pixel = 0; pixel < pixels; ++pixel) {
    if (!counts(mask, pixel)) continue;
    for (size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) visit(i);
    visited += 3;
  }
  return visited;
}

/// Moves all but the `kept` smallest behind these, whose largest comes last.
void split_off_largest(std::vector<double>& values, size_t kept) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(kept) - 1,
                   values.end());
}

double mean_of_first(const std::vector<double>& values, size_t count) {
  double sum = 0;
  for (size_t i = 0; i < count; ++i) sum += values[i];
  return sum / static_cast<double>(count);
}

}  // namespace

PictureError picture_error(const Picture& picture, const Picture& reference, const PixelMask& mask,
                           bool with_flip) {
  check_alike(picture, reference);
  PictureError out;
  std::vector<double> errors, relative;
  errors.reserve(picture.values.size());
  relative.reserve(picture.values.size());
  double sum = 0, sum_reference = 0;
  const size_t values = for_each_value(picture.pixels(), mask, [&](size_t i) {
    if (!std::isfinite(picture.values[i])) ++out.not_finite;
    const double x = finite(picture.values[i]), r = finite(reference.values[i]), d = x - r;
    out.mse += d * d;
    out.smape += 2 * std::abs(d) / (std::abs(x) + std::abs(r) + .01);
    errors.push_back(std::abs(d));
    relative.push_back(d * d / (r * r + .01));
    sum += x;
    sum_reference += r;
  });
  TESSERA_CHECK(values > 0, "no pixel counts");
  const auto count = static_cast<double>(values);
  out.mse /= count;
  out.rmse = std::sqrt(out.mse);
  out.smape /= count;
  out.rel_mse = mean_of_first(relative, relative.size());
  out.max_error = *std::max_element(errors.begin(), errors.end());
  // Without the largest thousandth, rounded down.
  const size_t kept = errors.size() - errors.size() / 1000;
  for_each_parallel(2, core_count(),
                    [&](size_t i) { split_off_largest(i == 0 ? relative : errors, kept); });
  out.trimmed_rel_mse = mean_of_first(relative, kept);
  out.error_99_9 = errors[kept - 1];
  out.mean_ratio = sum_reference != 0 ? sum / sum_reference : 0;
  if (with_flip) out.flip = mean_flip(picture, reference, mask);
  return out;
}

Picture Reference::mean() const {
  Picture out = first;
  for (size_t i = 0; i < out.values.size(); ++i)
    out.values[i] = static_cast<float>((double{first.values[i]} + double{second.values[i]}) / 2);
  return out;
}

double Reference::error(const PixelMask& mask) const {
  double sum = 0;
  const size_t values = for_each_value(first.pixels(), mask, [&](size_t i) {
    const double d = finite(first.values[i]) - finite(second.values[i]);
    sum += d * d;
  });
  return std::sqrt(sum / static_cast<double>(values)) / 2;
}

double mean_square_error(const Picture& picture, const Reference& reference,
                         const PixelMask& mask) {
  check_alike(picture, reference.first);
  double sum = 0;
  const size_t values = for_each_value(picture.pixels(), mask, [&](size_t i) {
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
