#include "bench/error/ssim.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/core_count.h"
#include "base/error.h"
#include "base/parallel.h"

namespace tessera {
namespace {

constexpr int kRadius = 5;
constexpr double kStandardDeviation = 1.5;
constexpr size_t kPixelsOfPiece = size_t{1} << 14;
constexpr double kC1 = .01 * .01, kC2 = .03 * .03;  // (K L)^2 of the paper, with L = 1

/// Of windows' values: the means of a, b, a^2, b^2 and ab.
using Moments = std::array<double, 5>;

double srgb_encoded(double linear) {
  return linear <= .0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - .055;
}

std::vector<double> encoded_luminance(const Picture& picture) {
  const auto light = [](float value) {
    return std::isnan(value) ? 0 : std::clamp(double{value}, 0., 1.);
  };
  std::vector<double> out(picture.pixels());
  for_each_piece_parallel(out.size(), kPixelsOfPiece, core_count(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const float* rgb = &picture.values[3 * i];
      out[i] = srgb_encoded(.2126 * light(rgb[0]) + .7152 * light(rgb[1]) + .0722 * light(rgb[2]));
    }
  });
  return out;
}

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

double mean_ssim(const Picture& first, const Picture& second) {
  TESSERA_CHECK(first.width == second.width && first.height == second.height && first.pixels() > 0,
                std::to_string(first.pixels()) + " and " + std::to_string(second.pixels()));
  const std::vector<double> a = encoded_luminance(first), b = encoded_luminance(second);
  const auto width = static_cast<size_t>(first.width), height = static_cast<size_t>(first.height);
  const int radius = std::min(kRadius, (std::min(first.width, first.height) - 1) / 2);
  const std::vector<double> weights = gaussian(radius);
  const size_t size = weights.size();
  // A row of windows each, added in their order for any number of threads.
  std::vector<double> sums(height - size + 1);
  for_each_parallel(sums.size(), core_count(), [&](size_t y) {
    std::array<std::vector<double>, 5> columns;
    for (std::vector<double>& moment : columns) moment.resize(width);
    for (size_t row = 0; row < size; ++row) {
      const double* const p = a.data() + (y + row) * width;
      const double* const q = b.data() + (y + row) * width;
      const double weight = weights[row];
      for (size_t x = 0; x < width; ++x) columns[0][x] += weight * p[x];
      for (size_t x = 0; x < width; ++x) columns[1][x] += weight * q[x];
      for (size_t x = 0; x < width; ++x) columns[2][x] += weight * (p[x] * p[x]);
      for (size_t x = 0; x < width; ++x) columns[3][x] += weight * (q[x] * q[x]);
      for (size_t x = 0; x < width; ++x) columns[4][x] += weight * (p[x] * q[x]);
    }
    std::array<std::vector<double>, 5> windows;
    for (size_t i = 0; i < windows.size(); ++i) {
      windows[i].resize(width - size + 1);
      for (size_t column = 0; column < size; ++column)
        for (size_t x = 0; x < windows[i].size(); ++x)
          windows[i][x] += weights[column] * columns[i][x + column];
    }
    for (size_t x = 0; x < windows[0].size(); ++x)
      sums[y] +=
          similarity({windows[0][x], windows[1][x], windows[2][x], windows[3][x], windows[4][x]});
  });
  const double sum = std::accumulate(sums.begin(), sums.end(), 0.0);
  return sum / static_cast<double>((width - size + 1) * (height - size + 1));
}

}  // namespace tessera
