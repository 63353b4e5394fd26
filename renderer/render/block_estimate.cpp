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

/// The coverage of a pixel by an edge has this / sqrt(n) of the variance that independent samples
/// give (measured); that counts as much as the differences of so many pixels.
constexpr double kEdgeGain = 0.68, kPriorPixels = 4;
/// A pixel's neighbours stand for so many samples of it, as four made-up ones do in the interval of
/// a share (Agresti and Coull 1998); two more since they are few themselves.
constexpr double kSamplesBeside = 6;

/// The share of blocks that are taken to hide something from all of their samples: one in 32 x 32
/// pixels.
constexpr double kHidingBlocks = 1.0 / 64;

}  // namespace

BlockEstimate::BlockEstimate(int pixels, bool nets, double gain)
    : count_(static_cast<size_t>(pixels)), nets_(nets), gain_squared_(gain * gain) {}

void BlockEstimate::add(int pixel, const Color& sample) {
  Pixel& p = pixels_[static_cast<size_t>(pixel)];
  if (!p.begun) p.origin = sample;
  p.begun = true;
  const Color away = sample - p.origin;
  p.sum += away;
  p.squares += squared(away);
}

void BlockEstimate::look(uint32_t samples) {
  const double n = samples, count = static_cast<double>(count_);
  const auto mean_of = [&](const Pixel& p) { return p.origin + p.sum * (1 / n); };
  Color block_mean = kBlack;
  for (size_t i = 0; i < count_; ++i) block_mean += mean_of(pixels_[i]) * (1 / count);
  double halves = 0, own_sum = 0, own_squares = 0, between = 0;
  for (size_t i = 0; i < count_; ++i) {
    Pixel& p = pixels_[i];
    const double worth = worth_of(mean_of(p));
    halves += worth * sum_of(squared((p.half * 2.0 - p.sum) * (1 / n)));
    p.half = p.sum;
    spread_[i] = worth * std::max(0.0, sum_of(p.squares - squared(p.sum) * (1 / n))) / (n - 1);
    own_sum += spread_[i];
    own_squares += spread_[i] * spread_[i];
    between += sum_of(squared(mean_of(p) - block_mean));
  }
  variance_ = own_sum / n;
  // Few samples do not know their own spread well: Student's t has this variance.
  unsure_ = n > 3 ? (n - 1) / (n - 3) : 3;
  if (nets_ && own_squares > 0) {
    const double pixels_seen = own_sum * own_sum / own_squares;
    const double edges = kEdgeGain / std::sqrt(n) * variance_;
    const double with_prior =
        (pixels_seen * halves + kPriorPixels * edges) / (pixels_seen + kPriorPixels);
    variance_ = std::max(halves, with_prior);
    // Nor do few pixels know the error of the block well; by this it is covered as often as
    // claimed.
    const double freedom = pixels_seen + kPriorPixels;
    unsure_ *= freedom / (freedom - 1.5);
  }
  variance_ *= gain_squared_ / (count * kChannels);
  unseen_ = kHidingBlocks / (count * n * n);
  share_pixels(n, own_sum / count, between / count, block_mean);
}

void BlockEstimate::share_pixels(double n, double own, double between, const Color& block_mean) {
  for (size_t i = 0; i < count_; ++i) {
    const Color away = pixels_[i].origin + pixels_[i].sum * (1 / n) - block_mean;
    const double beside = own + between + sum_of(squared(away));
    const double all = (n * spread_[i] + kSamplesBeside * beside) / (n + kSamplesBeside);
    spread_[i] = own > 0 ? all / own * unsure_ : 1;
  }
}

double BlockEstimate::standard_error() const { return std::sqrt(variance_ + unseen_); }

double BlockEstimate::standard_error(int pixel) const {
  return std::sqrt(variance_ * spread_[static_cast<size_t>(pixel)] + unseen_);
}

}  // namespace tessera
