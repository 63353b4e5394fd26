#include "renderer/render/block_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera {

namespace {

constexpr int kChannels = 3;

double sum_of(const Color& c) { return c.r + c.g + c.b; }
Color squared(const Color& c) { return c * c; }

/// Of a square error beside that of a pixel up to display white: what is brighter errs in
/// proportion, or the rims of lights would take all the time there is.
double worth_of(const Color& mean) {
  const double brightness = std::max(1.0, max_component(mean));
  return 1 / (brightness * brightness);
}

/// A mean of n samples of an edge has this / sqrt(n) of the variance that independent samples give:
/// .63 to .82 were measured, the latter where some edges lie along an axis.
constexpr double kEdgeGain = 0.72;
/// Half of the samples have this much more variance than all, in the same unit: n^1.5 says 1.83 of
/// the former, 1.15 to 1.4 were measured; and more where samples are few.
double edge_difference(double n) {
  return std::min(0.95, 1.28 / std::sqrt(n) * (1 + 2.5 / (n * n)));
}
/// What is smooth errs less than edges, but hardly any block is that alone: not taken to have less
/// than this of an edge's.
constexpr double kLeastOfEdge = 0.6;
/// Single pixels are, though seldom quite.
constexpr double kLeastOfEdgeByPixel = 0.03;

constexpr double kNormalKurtosis = 3;
/// The relative variance of what pixels truly vary is not taken to be less.
constexpr double kMostAlike = 1e-3;

/// The share of blocks that are taken to hide something from all of their samples: one in 32 x 32
/// pixels.
constexpr double kHidingBlocks = 1.0 / 64;
/// Of display white: what is hidden is not taken to add more to a pixel's mean, however bright it
/// is.
constexpr double kMostHidden = 1.0 / 3;

}  // namespace

BlockEstimate::BlockEstimate(int pixels, bool nets, double gain, uint32_t first_look, bool by_pixel,
                             double by_chance)
    : count_(static_cast<size_t>(pixels)),
      run_(std::max(1u, first_look / kRuns)),
      nets_(nets),
      by_pixel_(by_pixel),
      gain_squared_(gain * gain),
      by_chance_(by_chance) {}

void BlockEstimate::look(uint32_t samples, double hidden) {
  samples_ = samples;
  const double n = samples, count = static_cast<double>(count_);
  double spread = 0, squares = 0;
  for (size_t i = 0; i < count_; ++i) {
    const double own = spread_of(pixels_[i]);
    spread += own;
    squares += own * own;
  }
  // A few pixels of the block may have nearly all of it.
  if (squares > 0) freedom_ = spread * spread / squares * (n - 1);
  variance_ = taken_off_ = spread / n * gain_squared_ / (count * kChannels);
  if (nets_ && spread > 0) {
    edges_ = edge_part(spread);
    const double edge = kEdgeGain / std::sqrt(n);
    variance_ *= left_of_spread(edge);
    taken_off_ *= left_of_spread(edge_difference(n));
  }
  unseen_ = std::max(hidden, kHidingBlocks / (count * n * n));
  if (samples < kRuns * run_) return;
  run_ *= 2;
  for (size_t i = 0; i < count_; ++i) {
    for (size_t run = 0; run < kRuns / 2; ++run) {
      pixels_[i].ends[run] = pixels_[i].ends[2 * run + 1];
    }
  }
}

/// Of what independent samples of the block would have, where an edge has `of_edge`.
double BlockEstimate::left_of_spread(double of_edge) const {
  return std::max(1 - edges_ * (1 - of_edge), kLeastOfEdge * of_edge);
}

/// Of this spread, the part that edges have.
double BlockEstimate::edge_part(double spread) const {
  const double n = samples_;
  const size_t runs = samples_ / run_;
  constexpr size_t kLevels = 3;
  double covariance = 0, squares = 0;
  for (size_t level = 0, length = runs; level < kLevels && length > 1; ++level) {
    double differences = 0;
    for (size_t i = 0; i < count_; ++i) {
      differences += worth_of(mean_of(pixels_[i])) * differences_of(pixels_[i], runs, length);
    }
    const double expected = 1 - edge_difference(n / static_cast<double>(size_t{1} << level));
    covariance += expected * (1 - differences / (n * spread));
    squares += expected * expected;
    length /= 2;
  }
  return covariance / squares;
}

/// Summed over the stretches of `length` runs: the square of the difference of their halves.
double BlockEstimate::differences_of(const Pixel& pixel, size_t runs, size_t length) const {
  double sum = 0;
  Color begin = kBlack;
  for (size_t end = length; end <= runs; end += length) {
    const Color& middle = pixel.ends[end - length / 2 - 1];
    const Color& last = pixel.ends[end - 1];
    sum += sum_of(squared(middle * 2.0 - begin - last));
    begin = last;
  }
  return sum;
}

Color BlockEstimate::mean_of(const Pixel& pixel) const {
  return pixel.origin + pixel.sum * (1.0 / samples_);
}

/// The variance of a sample, summed over the three channels.
double BlockEstimate::variance_of(const Pixel& pixel) const {
  const double n = samples_;
  return std::max(0.0, sum_of(pixel.squares - squared(pixel.sum) * (1 / n))) / (n - 1);
}

/// The same as far as it counts.
double BlockEstimate::spread_of(const Pixel& pixel) const {
  return worth_of(mean_of(pixel)) * variance_of(pixel);
}

double BlockEstimate::standard_error() const { return std::sqrt(variance_ + unseen_); }
double BlockEstimate::most_taken_off() const {
  // The root of a variance of f degrees of freedom deviates by 1 / sqrt(2 f) of itself.
  const double times = 1 + 2 / std::sqrt(2 * freedom_);
  return std::sqrt(taken_off_ * times * times + unseen_);
}

/// Of a pixel's samples: 3 were they normal, n / k where k of n met what is rare.
double BlockEstimate::kurtosis_of(const Pixel& pixel) const {
  const double n = samples_, mean = sum_of(pixel.sum) / n, square = mean * mean;
  const Powers& of = pixel.powers;
  const double variance = of.second / n - square;
  if (!(variance > 0)) return kNormalKurtosis;
  const double fourth =
      (of.fourth - 4 * mean * of.third + 6 * square * of.second) / n - 3 * square * square;
  return std::clamp(fourth / (variance * variance), 1.0, n);
}

/// What the block's pixels know together of a sample's variance, as if they were more samples of
/// each of them (after Smyth 2004, "Linear models and empirical Bayes methods"). How many degrees
/// of freedom f that is says how alike the pixels are: what their variances vary beyond chance is 2
/// / f of the square of their mean.
struct BlockEstimate::Pool {
  double variance = 0, freedom = 0;
  double sharing = 0;  ///< so many pixels have the variance between them
};
BlockEstimate::Pool BlockEstimate::pool() const {
  const double n = samples_, count = static_cast<double>(count_);
  double mean = 0, squares = 0, fourth = 0;
  for (size_t i = 0; i < count_; ++i) {
    const double variance = variance_of(pixels_[i]), square = variance * variance;
    mean += variance / count;
    squares += square / count;
    fourth += square * kurtosis_of(pixels_[i]) / count;
  }
  if (!(mean > 0)) return {};
  const double square = mean * mean, by_chance = (fourth - squares) / n;
  const double unlike = (squares - square) * count / std::max(1.0, count - 1) - by_chance;
  // By Good and Turing, what was not met is about as much as what was met once: where one sample
  // has nearly all of the variance, as much again; and next to nothing where none stands out.
  const double not_met = fourth / mean / (count * n);
  return {mean + not_met, 2 * square / std::max(unlike, kMostAlike * square),
          count * square / squares};
}

/// Of the variance that independent samples would leave: how much is left, and how sure that is.
struct BlockEstimate::Left {
  double share = 1, freedom = std::numeric_limits<double>::infinity();
};
/// Where the halves of the samples differ less than those of edges would, all is smooth, and each
/// pixel says so alike: by the mean over the pixels, whatever they vary. What falls faster has less
/// left of the same difference: the variance is taken to go by its power of 1.5 (of what falls by
/// n^-2 it would be 1.98 of 16 samples, 1.27 of 256), so the degrees of freedom are 1.5^2 times
/// fewer.
BlockEstimate::Left BlockEstimate::left_of_independent(const Pool& pooled) const {
  if (!nets_) return {};
  const double n = samples_, edge = kEdgeGain / std::sqrt(n);
  const size_t runs = samples_ / run_;
  double of_edges = 0, varying = 0;
  for (size_t i = 0; i < count_; ++i) {
    const double variance = variance_of(pixels_[i]);
    if (!(variance > 0)) continue;
    of_edges += differences_of(pixels_[i], runs, runs) / (n * variance * edge_difference(n));
    ++varying;
  }
  of_edges /= varying;
  if (of_edges < 1) {
    return {std::max(of_edges * std::sqrt(of_edges), kLeastOfEdgeByPixel) * edge, varying / 2.25};
  }
  // The differences of n / 2, n / 4 and n / 8.
  return {left_of_spread(edge), (1 + 2 + 4) * pooled.sharing};
}

/// Of a pixel that hides it, the square error.
double BlockEstimate::hidden() const {
  const double n = samples_, brightness = std::min(by_chance_, kMostHidden * n);
  return std::max(unseen_,
                  kHidingBlocks * brightness * brightness / (static_cast<double>(count_) * n * n));
}

std::array<double, BlockEstimate::kMaxPixels> BlockEstimate::standard_errors() const {
  std::array<double, kMaxPixels> errors{};
  const double n = samples_;
  const Pool pooled = pool();
  if (!(pooled.variance > 0)) {
    std::fill_n(errors.begin(), count_, std::sqrt(hidden()));
    return errors;
  }
  // What a block hides is spread over as many pixels as what it shows.
  const double hides = hidden() / pooled.sharing;
  const Left left = left_of_independent(pooled);
  for (size_t i = 0; i < count_; ++i) {
    const double own = variance_of(pixels_[i]);
    // The relative variance of a variance of f degrees of freedom is 2 / f (Satterthwaite 1946).
    const double knows = own > 0 ? std::min(n, 2 * n / (kurtosis_of(pixels_[i]) - 1)) : 0;
    const double all = knows + pooled.freedom;
    const double variance = (knows * own + pooled.freedom * pooled.variance) / all;
    // The variance of Student's t, but of 3 degrees of freedom, the least, that by which 1.96 times
    // its root has the 95 %.
    const double freedom = std::max(3.2, 1 / (1 / all + 1 / left.freedom));
    const double unsure = freedom / (freedom - 2);
    errors[i] = std::sqrt(variance / (n * kChannels) * gain_squared_ * left.share * unsure + hides);
  }
  return errors;
}

}  // namespace tessera
