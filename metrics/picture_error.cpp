#include "metrics/picture_error.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "base/core_count.h"
#include "base/error.h"
#include "base/parallel.h"
#include "metrics/flip.h"

namespace tessera {
namespace {

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
Sum add_up(const PictureView& picture, const PixelMask& mask, const Visit& visit) {
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

PictureError picture_error(const PictureView& picture, const PictureView& reference,
                           const PixelMask& mask, bool with_flip) {
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

}  // namespace tessera
