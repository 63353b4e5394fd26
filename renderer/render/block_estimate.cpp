#include "renderer/render/block_estimate.h"

#include <algorithm>
#include <cmath>

namespace tessera {

namespace {

constexpr int kChannels = 3;

double sum_of(const Color& c) { return c.r + c.g + c.b; }
Color squared(const Color& c) { return c * c; }

/// Of a square error beside that of a pixel up to display white: what is brighter errs in
/// proportion, or the rims of lamps would take all the time there is.
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

/// A pixel's neighbours stand for so many samples of it, as made-up ones do in the interval of a
/// share (Agresti and Coull 1998).
constexpr double kSamplesBeside = 6;

/// The share of blocks that are taken to hide something from all of their samples: one in 32 x 32
/// pixels.
constexpr double kHidingBlocks = 1.0 / 64;

}  // namespace

BlockEstimate::BlockEstimate(int pixels, bool nets, double gain, uint32_t first_look)
    : count_(static_cast<size_t>(pixels)),
      run_(std::max(1u, first_look / kRuns)),
      nets_(nets),
      gain_squared_(gain * gain) {}

void BlockEstimate::look(uint32_t samples) {
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
    const double edges = edge_part(spread), edge = kEdgeGain / std::sqrt(n);
    const auto left = [&](double of_edge) {
      return std::max(1 - edges * (1 - of_edge), kLeastOfEdge * of_edge);
    };
    variance_ *= left(edge);
    taken_off_ *= left(edge_difference(n));
  }
  unseen_ = kHidingBlocks / (count * n * n);
  if (samples < kRuns * run_) return;
  run_ *= 2;
  for (size_t i = 0; i < count_; ++i) {
    for (size_t run = 0; run < kRuns / 2; ++run) {
      pixels_[i].ends[run] = pixels_[i].ends[2 * run + 1];
    }
  }
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

/// The variance of a sample, over the three channels.
double BlockEstimate::spread_of(const Pixel& pixel) const {
  const double n = samples_;
  const double squares = sum_of(pixel.squares - squared(pixel.sum) * (1 / n));
  return worth_of(mean_of(pixel)) * std::max(0.0, squares) / (n - 1);
}

double BlockEstimate::standard_error() const { return std::sqrt(variance_ + unseen_); }
double BlockEstimate::most_taken_off() const {
  // The root of a variance of f degrees of freedom deviates by 1 / sqrt(2 f) of itself.
  const double times = 1 + 2 / std::sqrt(2 * freedom_);
  return std::sqrt(taken_off_ * times * times + unseen_);
}

double BlockEstimate::standard_error(int pixel) const {
  const double n = samples_, count = static_cast<double>(count_);
  Color block_mean = kBlack;
  double own = 0, own_squares = 0, between = 0;
  for (size_t i = 0; i < count_; ++i) {
    const double spread = spread_of(pixels_[i]);
    block_mean += mean_of(pixels_[i]) * (1 / count);
    own += spread / count;
    own_squares += spread * spread / count;
  }
  if (!(own > 0)) return standard_error();
  const auto from_block = [&](const Pixel& p) { return sum_of(squared(mean_of(p) - block_mean)); };
  for (size_t i = 0; i < count_; ++i) between += from_block(pixels_[i]) / count;
  const Pixel& one = pixels_[static_cast<size_t>(pixel)];
  const double beside = own + between + from_block(one);
  const double all = (n * spread_of(one) + kSamplesBeside * beside) / (n + kSamplesBeside);
  // Few samples do not know their own spread well, nor few pixels the error of the block: Student's
  // t has the former's variance; by the latter blocks are covered as often as claimed.
  double unsure = n > 3 ? (n - 1) / (n - 3) : 3;
  const double freedom = count * own * own / own_squares + 4;
  if (nets_) unsure *= freedom / (freedom - 1);
  return std::sqrt(variance_ * all / own * unsure + unseen_);
}

}  // namespace tessera
