#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"

namespace tessera {

/// A linear picture: rows from the top, red, green and blue of each pixel. A value.
struct Picture {
  int width = 0, height = 0;
  std::vector<float> values;  ///< width * height * 3

  size_t pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

/// The same where it lies elsewhere, which has to outlive this.
struct PictureView {
  PictureView(int w, int h, std::span<const float> rgb) : width(w), height(h), values(rgb) {}
  PictureView(const Picture& picture)
      : PictureView(picture.width, picture.height, picture.values) {}

  int width, height;
  std::span<const float> values;  ///< width * height * 3

  size_t pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

/// Which pixels count, one entry a pixel; empty: all of them.
using PixelMask = std::vector<uint8_t>;

inline bool counts(const PixelMask& mask, size_t pixel) { return mask.empty() || mask[pixel] != 0; }

/// That both have one size.
inline void check_alike(const PictureView& a, const PictureView& b) {
  TESSERA_CHECK(a.width == b.width && a.height == b.height && a.values.size() == b.values.size() &&
                    a.values.size() == 3 * a.pixels(),
                std::to_string(a.values.size()) + " and " + std::to_string(b.values.size()));
}

/// What is no finite number counts as 0.
inline double finite(float value) { return std::isfinite(value) ? double{value} : 0; }

/// Calls visit(i) for every value of the pixels from `begin` to `end` that count; returns how many
/// there were.
template <typename Visit>
size_t for_each_value(size_t begin, size_t end, const PixelMask& mask, const Visit& visit) {
  size_t visited = 0;
  for (size_t pixel = begin; pixel < end; ++pixel) {
    if (!counts(mask, pixel)) continue;
    for (size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) visit(i);
    visited += 3;
  }
  return visited;
}

}  // namespace tessera
