#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "renderer/math/color.h"
#include "renderer/math/vec.h"

namespace tessera {

struct ImageTextureSettings {
  enum class Wrap : uint8_t { repeat, clamp, mirror, black };
  enum class Filter : uint8_t { trilinear, bilinear, nearest };
  uint32_t width = 1, height = 1;
  uint32_t channels = 3;  ///< 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA
  uint32_t bits = 8;      ///< 8, 16 (half float) or 32 (float)
  uint32_t levels = 1;    ///< each half the last, rounded up, one after the other
  Wrap wrap_s = Wrap::repeat, wrap_t = Wrap::repeat;
  Filter filter = Filter::trilinear;
  bool is_srgb = false;            ///< 8-bit colours are sRGB-encoded; alpha never is
  bool texels_at_corners = false;  ///< texel (i, j) stands for the point (i, j), not its centre
  bool is_associated = false;      ///< colours are multiplied by alpha

  bool has_alpha() const { return channels % 2 == 0; }
  bool has_color() const { return channels >= 3; }
  /// Of a level's side.
  static uint32_t halved(uint32_t side) { return side / 2 + side % 2; }
  /// Of all levels together; exact for sides up to 2^16.
  uint64_t bytes() const;
};

struct Texel {
  Color color;  ///< not multiplied by alpha
  double alpha = 1;
};

/// A picture to look colours up in. Immutable; thread-safe.
class ImageTexture {
 public:
  /// `texels` must point to at least settings.bytes(); they are shared, not copied.
  ImageTexture(const ImageTextureSettings& settings, std::shared_ptr<const std::byte> texels);

  const ImageTextureSettings& settings() const { return settings_; }

  /// The finest level at (s, t), s to the right and t downwards from the top left corner, 1 being
  /// the picture's width or height. Bilinear unless the filter says nearest.
  Texel lookup(double s, double t) const;
  /// The same as light that comes from there, with nothing behind: a colour that is multiplied by
  /// alpha stays so, any other is taken for that of a picture without alpha.
  Color light(double s, double t) const;
  /// The mean over a patch around (s, t) that `a` and `b`, in the same units, span: trilinear
  /// look-ups along the longer one at the level of the shorter one (as texture units of graphics
  /// processors do: McCormack et al. 1999), at most 16 of them.
  Texel lookup(double s, double t, const Vec2& a, const Vec2& b) const;

  /// Has what lookup(s, t) will read brought nearer, for `s` and `t` from 0 to 1.
  void prefetch(double s, double t) const {
    const Level& level = levels_.front();
    const size_t texel = settings_.channels * (settings_.bits / 8), row = texel * level.width;
    // What is no number counts as 0.
    const auto column = static_cast<size_t>(std::max(0.0, s * level.width));
    const auto line = static_cast<size_t>(std::max(0.0, t * level.height - 0.5));
    const std::byte* const at = texels_.get() + level.offset + line * row + column * texel;
    __builtin_prefetch(at);
    __builtin_prefetch(at + row);
  }

 private:
  struct Level {
    uint32_t width, height;
    size_t offset;  ///< bytes
  };
  /// What look-ups return for a mean of texels.
  Texel straight(const Texel& mean) const;
  double channel(size_t offset) const;
  Texel texel(const Level& level, int64_t x, int64_t y) const;
  /// As texel() for places that wrapped() gave.
  Texel texel_at(const Level& level, int64_t x, int64_t y) const;
  Texel mix(const Texel& a, const Texel& b, double weight_of_b) const;
  Texel bilinear(const Level& level, double s, double t) const;
  Texel trilinear(double s, double t, double level) const;

  ImageTextureSettings settings_;
  std::shared_ptr<const std::byte> texels_;
  std::vector<Level> levels_;
  std::array<double, 256> linear_{};  ///< of 8-bit colours
};

}  // namespace tessera
