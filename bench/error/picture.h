#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

/// A linear picture: rows from the top, red, green and blue of each pixel. A value.
struct Picture {
  int width = 0, height = 0;
  std::vector<float> values;  ///< width * height * 3

  size_t pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

/// Which pixels count, one entry a pixel; empty: all of them.
using PixelMask = std::vector<uint8_t>;

inline bool counts(const PixelMask& mask, size_t pixel) { return mask.empty() || mask[pixel] != 0; }

}  // namespace tessera
