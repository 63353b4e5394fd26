#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "renderer/math/color.h"

namespace tessera {

struct ImageTextureSettings {
  enum class Wrap : uint8_t { repeat, clamp, mirror, black };
  uint32_t width = 1, height = 1;
  uint32_t channels = 3;  ///< 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA
  uint32_t bits = 8;      ///< 8 or 32 (float)
  Wrap wrap_s = Wrap::repeat, wrap_t = Wrap::repeat;
  bool is_srgb = false;            ///< 8-bit texels are sRGB-encoded
  bool is_nearest = false;         ///< else bilinear
  bool texels_at_corners = false;  ///< texel (i, j) stands for the point (i, j), not its centre
};

/// A picture to look colours up in. Immutable; thread-safe.
class ImageTexture {
 public:
  /// `texels` must hold at least the width * height of the settings; they are shared, not copied.
  ImageTexture(const ImageTextureSettings& settings,
               std::shared_ptr<const std::vector<std::byte>> texels);

  /// The colour at (s, t), s to the right and t downwards from the top left corner, 1 being the
  /// picture's width or height.
  Color lookup(double s, double t) const;

 private:
  Color texel(int64_t x, int64_t y) const;

  ImageTextureSettings settings_;
  std::shared_ptr<const std::vector<std::byte>> texels_;
  std::array<double, 256> linear_{};  ///< of 8-bit values
};

}  // namespace tessera
