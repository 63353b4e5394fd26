#include "bench/error/ssim.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"

namespace tessera {
namespace {

constexpr int kRadius = 5;
constexpr double kStandardDeviation = 1.5;
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
  std::vector<double> out;
  out.reserve(picture.pixels());
  for (size_t i = 0; i < picture.values.size(); i += 3) {
    const float* rgb = &picture.values[i];
    out.push_back(
        srgb_encoded(.2126 * light(rgb[0]) + .7152 * light(rgb[1]) + .0722 * light(rgb[2])));
  }
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
  double sum = 0;
  std::vector<Moments> columns(width);
  for (size_t y = 0; y + size <= height; ++y) {
    std::fill(columns.begin(), columns.end(), Moments{});
    for (size_t row = 0; row < size; ++row) {
      for (size_t x = 0; x < width; ++x) {
        const double p = a[(y + row) * width + x], q = b[(y + row) * width + x];
        const Moments terms{p, q, p * p, q * q, p * q};
        for (size_t i = 0; i < terms.size(); ++i) columns[x][i] += weights[row] * terms[i];
      }
    }
    for (size_t x = 0; x + size <= width; ++x) {
      Moments window{};
      for (size_t column = 0; column < size; ++column) {
        for (size_t i = 0; i < window.size(); ++i)
          window[i] += weights[column] * columns[x + column][i];
      }
      sum += similarity(window);
    }
  }
  return sum / static_cast<double>((width - size + 1) * (height - size + 1));
}

}  // namespace tessera
