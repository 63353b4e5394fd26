#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace tessera {

/// Where and by how much two pictures of one size differ. Numbers that are both no number count as
/// equal, one that is none as infinitely far.
struct Difference {
  double greatest = 0, mean = 0, rmse = 0;  ///< over all channels of all pixels
  std::vector<double> greatest_of;          ///< of each channel
  size_t worst_pixel = 0;                   ///< counts from the first row's left
  size_t pixels_beyond = 0;                 ///< with a channel that differs by more than is allowed
  size_t pixels_unequal = 0;                ///< with a channel that differs
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;       ///< pixels x0 <= x < x1, y0 <= y < y1 around those
};

/// By how much a channel differs; infinitely where one of both is no number.
inline double channel_difference(float a, float b) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b) ? 0 : INFINITY;
  return a == b ? 0 : std::abs(double{a} - double{b});
}

/// Of pictures of that width, their channels side by side, rows from the top.
Difference difference_of(std::span<const float> a, std::span<const float> b, size_t channels,
                         size_t width, double allowed = 0);

}  // namespace tessera
