#include "bench/error/difference.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace tessera {
namespace {

double channel_difference(float a, float b) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b) ? 0 : INFINITY;
  return a == b ? 0 : std::abs(double{a} - double{b});
}

/// Takes a pixel that differs into the part around all of them.
void include(int x, int y, Difference& d) {
  if (d.pixels_unequal++ == 0) d.x0 = x, d.y0 = y;
  d.x0 = std::min(d.x0, x), d.y0 = std::min(d.y0, y);
  d.x1 = std::max(d.x1, x + 1), d.y1 = std::max(d.y1, y + 1);
}

}  // namespace

Difference difference_of(std::span<const float> a, std::span<const float> b, size_t channels,
                         size_t width, double allowed) {
  TESSERA_CHECK(a.size() == b.size(),
                std::to_string(a.size()) + " and " + std::to_string(b.size()));
  Difference result;
  result.greatest_of.resize(channels);
  double sum = 0, sum_of_squares = 0;
  for (size_t pixel = 0; pixel < a.size() / channels; ++pixel) {
    double worst = 0;
    for (size_t i = 0; i < channels; ++i) {
      const double d = channel_difference(a[pixel * channels + i], b[pixel * channels + i]);
      result.greatest_of[i] = std::max(result.greatest_of[i], d);
      worst = std::max(worst, d);
      sum += d;
      sum_of_squares += d * d;
    }
    if (worst > result.greatest) {
      result.greatest = worst;
      result.worst_pixel = pixel;
    }
    if (worst > 0)
      include(static_cast<int>(pixel % width), static_cast<int>(pixel / width), result);
    if (worst > allowed) ++result.pixels_beyond;
  }
  const auto values = static_cast<double>(a.size());
  result.mean = sum / values;
  result.rmse = std::sqrt(sum_of_squares / values);
  return result;
}

}  // namespace tessera
