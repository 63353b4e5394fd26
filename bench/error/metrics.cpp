#include "bench/error/metrics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

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

/// Calls visit(i) for every value of the pixels from `begin` to `end` that count; returns how many
/// there were.
template <typename Visit>
size_t for_each_value(size_t begin, size_t end, const PixelMask& mask, const Visit& visit) {
  size_t visited = 0;
  for (size_t pixel = begin; pixel < end; ++pixel) {
    if (!counts(mask, pixel)) continue;
    for (size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) visit(i);
    visited += 3;
  }
  return visited;
}

/// The largest of many numbers that are not negative.
class Largest {
 public:
  explicit Largest(size_t most) : most_(most) {
    if (most == 0) least_ = std::numeric_limits<double>::infinity();
  }

  void add(double value) {
    if (value <= least_) return;
    values_.push_back(value);
    if (values_.size() >= 2 * most_) drop_rest();
  }
  void add(const Largest& others) {
    for (const double value : others.values_) add(value);
  }
  /// The least of them, once there are enough; infinite if none is asked for.
  double least() {
    if (most_ > 0) drop_rest();
    return least_;
  }

 private:
  void drop_rest() {
    const auto last = values_.begin() + static_cast<std::ptrdiff_t>(most_) - 1;
    std::nth_element(values_.begin(), last, values_.end(), std::greater<>());
    values_.resize(most_);
    least_ = values_.back();
  }

  size_t most_;
  double least_ = -1;  ///< what is not above it is not among them
  std::vector<double> values_;
};

/// Of many numbers those below a limit.
struct Below {
  void add(double value, double limit) {
    if (value >= limit) return;
    sum += value;
    largest = std::max(largest, value);
    ++count;
  }
  void add(const Below& other) {
    sum += other.sum;
    largest = std::max(largest, other.largest);
    count += other.count;
  }

  double sum = 0, largest = 0;
  size_t count = 0;
};

/// What all values add up to.
struct Sums {
  void add(const Sums& other) {
    squares += other.squares;
    smape += other.smape;
    relative += other.relative;
    picture += other.picture;
    reference += other.reference;
    largest = std::max(largest, other.largest);
    not_finite += other.not_finite;
  }

  double squares = 0, smape = 0, relative = 0, picture = 0, reference = 0, largest = 0;
  size_t not_finite = 0;
};

/// What those add up to that are not among the largest.
struct Trimmed {
  void add(const Trimmed& other) {
    errors.add(other.errors);
    relatives.add(other.relatives);
  }

  Below errors, relatives;
};

double relative_square(double d, double r) { return d * d / (r * r + .01); }

/// What visit(sums, thread, i) adds up over the values that count.
template <typename Sum, typename Visit>
Sum add_up(const Picture& picture, const PixelMask& mask, const Visit& visit) {
  // Parts that depend on the size of the picture alone, and so do the sums then.
  constexpr size_t kPixelsOfPart = size_t{1} << 16;
  std::vector<Sum> of_part((picture.pixels() + kPixelsOfPart - 1) / kPixelsOfPart);
  for_each_of_thread(of_part.size(), core_count(), [&](size_t thread, size_t part) {
    const size_t begin = part * kPixelsOfPart;
    Sum sum;
    for_each_value(begin, std::min(picture.pixels(), begin + kPixelsOfPart), mask,
                   [&](size_t i) { visit(sum, thread, i); });
    of_part[part] = sum;
  });
  Sum all;
  for (const Sum& sum : of_part) all.add(sum);
  return all;
}

}  // namespace

PictureError picture_error(const Picture& picture, const Picture& reference, const PixelMask& mask,
                           bool with_flip) {
  check_alike(picture, reference);
  const size_t values = for_each_value(0, picture.pixels(), mask, [](size_t) {});
  TESSERA_CHECK(values > 0, "no pixel counts");
  const size_t trimmed = values / 1000, kept = values - trimmed;
  std::vector<Largest> errors(static_cast<size_t>(core_count()), Largest(trimmed));
  std::vector<Largest> relatives = errors;
  const Sums sums = add_up<Sums>(picture, mask, [&](Sums& sum, size_t thread, size_t i) {
    if (!std::isfinite(picture.values[i])) ++sum.not_finite;
    const double x = finite(picture.values[i]), r = finite(reference.values[i]), d = x - r;
    const double error = std::abs(d), relative = relative_square(d, r);
    sum.squares += d * d;
    sum.smape += 2 * error / (std::abs(x) + std::abs(r) + .01);
    sum.relative += relative;
    sum.picture += x;
    sum.reference += r;
    sum.largest = std::max(sum.largest, error);
    errors[thread].add(error);
    relatives[thread].add(relative);
  });
  for (size_t thread = 1; thread < errors.size(); ++thread) {
    errors[0].add(errors[thread]);
    relatives[0].add(relatives[thread]);
  }
  const double least_error = errors[0].least(), least_relative = relatives[0].least();
  const Trimmed below = add_up<Trimmed>(picture, mask, [&](Trimmed& sum, size_t, size_t i) {
    const double r = finite(reference.values[i]), d = finite(picture.values[i]) - r;
    sum.errors.add(std::abs(d), least_error);
    sum.relatives.add(relative_square(d, r), least_relative);
  });
  // Of several that equal the least of the largest, some may be kept.
  double relative_kept = below.relatives.sum;
  if (below.relatives.count < kept) {
    relative_kept += static_cast<double>(kept - below.relatives.count) * least_relative;
  }

  const auto count = static_cast<double>(values);
  PictureError out;
  out.mse = sums.squares / count;
  out.rmse = std::sqrt(out.mse);
  out.smape = sums.smape / count;
  out.rel_mse = sums.relative / count;
  out.trimmed_rel_mse = relative_kept / static_cast<double>(kept);
  out.max_error = sums.largest;
  out.error_99_9 = below.errors.count < kept ? least_error : below.errors.largest;
  out.mean_ratio = sums.reference != 0 ? sums.picture / sums.reference : 0;
  out.not_finite = sums.not_finite;
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
