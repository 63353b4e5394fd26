#include "renderer/render/block_estimate.h"

#include <algorithm>
#include <cmath>

namespace tessera {

namespace {

constexpr int kChannels = 3;

double sum_of(const Color& c) { return c.r + c.g + c.b; }
Color squared(const Color& c) { return c * c; }

/// The coverage of a pixel by an edge has this / sqrt(n) of the variance that independent samples
/// give (measured); that counts as much as the differences of so many pixels.
constexpr double kEdgeGain = 0.68, kPriorPixels = 4;

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
  Color block_mean = kBlack;
  for (size_t i = 0; i < count_; ++i) {
    block_mean += (pixels_[i].origin + pixels_[i].sum * (1 / n)) * (1 / count);
  }
  double halves = 0, own_sum = 0, own_squares = 0, spread = 0;
  for (size_t i = 0; i < count_; ++i) {
    Pixel& p = pixels_[i];
    halves += sum_of(squared((p.half * 2.0 - p.sum) * (1 / n)));
    p.half = p.sum;
    const double own = std::max(0.0, sum_of(p.squares - squared(p.sum) * (1 / n))) / (n - 1);
    own_sum += own;
    own_squares += own * own;
    spread_[i] = own + sum_of(squared(p.origin + p.sum * (1 / n) - block_mean)) / n;
    spread += spread_[i];
  }
  variance_ = own_sum / n;
  if (nets_ && own_squares > 0) {
    const double pixels_seen = own_sum * own_sum / own_squares;
    const double edges = kEdgeGain / std::sqrt(n) * variance_;
    variance_ = (pixels_seen * halves + kPriorPixels * edges) / (pixels_seen + kPriorPixels);
  }
  variance_ *= gain_squared_ / (count * kChannels);
  unseen_ = 1 / (count * n * n);
  // An edge's error goes with its length more than with the variance of what it covers.
  spread_sum_ = 0;
  for (size_t i = 0; i < count_; ++i) {
    double& share = spread_[i];
    share += std::sqrt(share * (spread / count));
    spread_sum_ += share;
  }
}

double BlockEstimate::standard_error() const { return std::sqrt(variance_ + unseen_); }

double BlockEstimate::standard_error(int pixel) const {
  const double share = spread_sum_ > 0 ? spread_[static_cast<size_t>(pixel)] *
                                             static_cast<double>(count_) / spread_sum_
                                       : 1;
  return std::sqrt(variance_ * share + unseen_);
}

}  // namespace tessera
