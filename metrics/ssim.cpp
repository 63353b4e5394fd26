#include "metrics/ssim.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/core_count.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/targets.h"
#include "metrics/vector_math.h"
#include "metrics/weighted_sum.h"
// This file is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "metrics/ssim.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {
namespace {

constexpr int kRadius = 5;
constexpr double kStandardDeviation = 1.5;
constexpr size_t kBand = 64;  // rows of windows, whose pixels a processor's cache may hold
constexpr double kC1 = .01 * .01, kC2 = .03 * .03;  // (K L)^2 of the paper, with L = 1

/// Of windows' values: the means of a, b, a^2, b^2 and ab.
using Moments = std::array<double, 5>;

/// Of light in [0, 1].
double srgb_encoded(double linear) {
  constexpr double kKnee = .0031308;
  const double bright = std::max(linear, kKnee);
  // One more of Halley's steps makes it exact. The power 1 / 2.4 is a half of a half and a third.
  double root = double{cube_root(static_cast<float>(bright))};
  const double cube = root * root * root;
  root *= (cube + 2 * bright) / (2 * cube + bright);
  const double power = std::sqrt(std::sqrt(bright) * root);
  return linear <= kKnee ? 12.92 * linear : 1.055 * power - .055;
}

/// Of a row of the picture.
void encode_luminance(const PictureView& picture, size_t y, double* out) {
  const auto light = [](float value) {
    return std::isnan(value) ? 0 : std::clamp(double{value}, 0., 1.);
  };
  const auto width = static_cast<size_t>(picture.width);
  const float* rgb = &picture.values[3 * y * width];
  for (size_t x = 0; x < width; ++x, rgb += 3)
    out[x] = .2126 * light(rgb[0]) + .7152 * light(rgb[1]) + .0722 * light(rgb[2]);
  for (size_t x = 0; x < width; ++x) out[x] = srgb_encoded(out[x]);
}

/// For each pixel of some rows of two pictures what Moments are the means of, in planes; its
/// buffers serve for other rows later.
class Products {
 public:
  void compute(const PictureView& a, const PictureView& b, size_t begin, size_t end) {
    width_ = static_cast<size_t>(a.width);
    for (std::vector<double>& plane : planes_) plane.resize((end - begin) * width_);
    for (size_t row = 0; row < end - begin; ++row) {
      std::array<double*, 5> to{};
      for (size_t i = 0; i < to.size(); ++i) to[i] = planes_[i].data() + row * width_;
      encode_luminance(a, begin + row, to[0]);
      encode_luminance(b, begin + row, to[1]);
      for (size_t x = 0; x < width_; ++x) to[2][x] = to[0][x] * to[0][x];
      for (size_t x = 0; x < width_; ++x) to[3][x] = to[1][x] * to[1][x];
      for (size_t x = 0; x < width_; ++x) to[4][x] = to[0][x] * to[1][x];
    }
  }
  const double* row(size_t plane, size_t y) const { return planes_[plane].data() + y * width_; }

 private:
  size_t width_ = 0;
  std::array<std::vector<double>, 5> planes_;
};

/// Weights from -radius to radius, whose sum is 1.
std::vector<double> gaussian(int radius) {
  std::vector<double> weights;
  double sum = 0;
  for (int i = -radius; i <= radius; ++i) {
    weights.push_back(std::exp(-i * i / (2 * kStandardDeviation * kStandardDeviation)));
    sum += weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

double similarity(const Moments& m) {
  const auto [a, b, aa, bb, ab] = m;
  return (2 * a * b + kC1) * (2 * (ab - a * b) + kC2) /
         ((a * a + b * b + kC1) * ((aa - a * a) + (bb - b * b) + kC2));
}

}  // namespace

double mean_ssim(const PictureView& first, const PictureView& second) {
  TESSERA_CHECK(first.width == second.width && first.height == second.height && first.pixels() > 0,
                std::to_string(first.pixels()) + " and " + std::to_string(second.pixels()));
  const auto width = static_cast<size_t>(first.width), height = static_cast<size_t>(first.height);
  const int radius = std::min(kRadius, (std::min(first.width, first.height) - 1) / 2);
  const std::vector<double> weights = gaussian(radius);
  const size_t size = weights.size();
  // A row of windows each, added in their order for any number of threads.
  std::vector<double> sums(height - size + 1);
  const size_t bands = (sums.size() + kBand - 1) / kBand;
  std::vector<Products> of_threads(static_cast<size_t>(core_count()));
  for_each_of_thread(bands, core_count(), [&](size_t thread, size_t band) {
    const size_t begin = band * kBand, end = std::min(sums.size(), begin + kBand);
    Products& products = of_threads[thread];
    products.compute(first, second, begin, end + size - 1);
    std::vector<double> columns(width);
    std::array<std::vector<double>, 5> windows;
    for (std::vector<double>& moment : windows) moment.resize(width - size + 1);
    std::vector<const double*> rows(size);
    for (size_t y = begin; y < end; ++y) {
      for (size_t i = 0; i < windows.size(); ++i) {
        for (size_t k = 0; k < size; ++k) rows[k] = products.row(i, y - begin + k);
        weighted_sum(columns.data(), width, weights, rows);
        for (size_t k = 0; k < size; ++k) rows[k] = columns.data() + k;
        weighted_sum(windows[i].data(), windows[i].size(), weights, rows);
      }
      for (size_t x = 0; x < windows[0].size(); ++x)
        sums[y] +=
            similarity({windows[0][x], windows[1][x], windows[2][x], windows[3][x], windows[4][x]});
    }
  });
  const double sum = std::accumulate(sums.begin(), sums.end(), 0.0);
  return sum / static_cast<double>((width - size + 1) * (height - size + 1));
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {

double mean_ssim(const PictureView& first, const PictureView& second) {
  static const auto best = best_code_of_machine(TESSERA_EACH_TARGET(mean_ssim));
  return best(first, second);
}

}  // namespace tessera
#endif  // HWY_ONCE
