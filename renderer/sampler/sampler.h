#pragma once

#include <cstdint>

#include "renderer/math/vec.h"

namespace tessera {

enum class SamplePattern { center, owen_sobol, centered_grid, corner_grid, independent };
/// How samples spread about a pixel's centre; each by inverting its cumulative distribution, so
/// that every sample weighs the same and pixels share none.
enum class PixelFilter { box, tent };

struct SamplerSettings {
  SamplePattern pattern = SamplePattern::center;
  uint32_t samples_per_pixel = 1;  ///< 1 to 2^20; a square for the grids
  uint32_t seed = 0;
  PixelFilter filter = PixelFilter::box;
  double filter_radius = 0.5;  ///< pixels
};

/// What a sample's numbers are drawn for: pairs of Sobol dimensions, each scrambled by itself.
enum class SampleUse : uint32_t { pixel = 0, lens = 1, grain = 2 };

/// The numbers of one sample of one pixel. A value, made once a sample so that the pixel is hashed
/// once; each pair then costs a quarter less.
class SampleStream {
 public:
  Vec2 pair(SampleUse use) const;

 private:
  friend class Sampler;
  uint64_t key_ = 0;     ///< of seed and pixel
  uint32_t sample_ = 0;  ///< its number; but for `independent` with its bits reversed
  bool independent_ = false;
};

/// Numbers in [0, 1) keyed by (seed, pixel, sample, use) and nothing else: any sample of any pixel
/// can be drawn alone, in any order, on any host. Owen-scrambled Sobol pairs by hashing (Burley
/// 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4)): every prefix of 2^k samples of a pair
/// is a (0, k, 2)-net in base 2. A value; thread-safe.
class Sampler {
 public:
  explicit Sampler(const SamplerSettings& settings);

  const SamplerSettings& settings() const { return settings_; }
  /// Where sample `sample` of pixel (x, y) looks, in raster coordinates: pixel (x, y) covers
  /// [x, x + 1) x [y, y + 1), y downwards.
  Vec2 raster_point(int x, int y, uint32_t sample) const;
  /// The numbers of a sample, by Owen-scrambled Sobol whatever the pixel pattern, but for
  /// `independent`.
  SampleStream stream(int x, int y, uint32_t sample) const;
  /// stream(x, y, sample).pair(use)
  Vec2 pair(int x, int y, uint32_t sample, SampleUse use) const;

 private:
  Vec2 pixel_square(int x, int y, uint32_t sample) const;

  SamplerSettings settings_;
  uint32_t grid_ = 1;  ///< cells on a side, for the grids
};

}  // namespace tessera
