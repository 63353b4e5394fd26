#pragma once

#include <cstdint>
#include <memory>

#include "renderer/math/vec.h"
#include "renderer/sampler/pixel_filter.h"

namespace tessera {

enum class SamplePattern {
  center,
  owen_sobol,
  centered_grid,
  corner_grid,
  independent,
  blue_noise
};
struct SamplerSettings {
  SamplePattern pattern = SamplePattern::center;
  uint32_t samples_per_pixel = 1;  ///< 1 to 2^20; a square for the grids
  uint32_t seed = 0;
  PixelFilter filter = PixelFilter::box;
  double filter_radius = 0.5;  ///< pixels
};

/// The key of a sample's numbers.
struct SampleKey {
  int x = 0, y = 0;  ///< the pixel
  uint32_t sample = 0;
};

/// What a sample's numbers are drawn for: pairs of Sobol dimensions, each scrambled by itself.
enum class SampleUse : uint32_t { pixel = 0, lens = 1, grain = 2 };

/// The numbers of one sample of one pixel. A value, made once a sample so that the pixel is hashed
/// once; each pair then costs a quarter less.
class SampleStream {
 public:
  /// Also a lane each in lane_sampler-inl.h, bit for bit.
  Vec2 pair(SampleUse use) const;

  uint64_t key() const { return key_; }  ///< of seed and pixel
  uint32_t sample() const {
    return sample_;
  }  ///< its number; bits reversed unless is_independent()
  bool is_independent() const { return independent_; }

 private:
  friend class Sampler;
  uint64_t key_ = 0;
  uint32_t sample_ = 0;
  bool independent_ = false;
};

/// Numbers in [0, 1) keyed by (seed, pixel, sample, use) and nothing else: any sample of any pixel
/// can be drawn alone, in any order, on any host. Owen-scrambled Sobol pairs by hashing (Burley
/// 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4)): every prefix of 2^k samples of a pair
/// is a (0, k, 2)-net in base 2.
///
/// `blue_noise` is one such sequence over the picture: pixels in z-order take 2^k of its points
/// each (Ahmed and Wonka 2020, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via
/// Hierarchical Ordering of Pixels", TOG 39(6)), so that the points of 2 x 2, 4 x 4 ... pixels are
/// nets too, and their errors cancel. The Owen scramble of the index, hashed, does for the shuffle
/// of each level. A pixel's own points are as good as before.
/// A value; thread-safe.
class Sampler {
 public:
  explicit Sampler(const SamplerSettings& settings);

  const SamplerSettings& settings() const { return settings_; }
  /// Where sample `sample` of pixel (x, y) looks, in raster coordinates: pixel (x, y) covers
  /// [x, x + 1) x [y, y + 1), y downwards. What it finds counts with the filter's sign there.
  struct RasterSample {
    Vec2 point;
    bool negative = false;
  };
  /// Also of many at once, a lane each, bit for bit: draw_rasters.h.
  RasterSample raster_sample(int x, int y, uint32_t sample) const {
    if (is_centered_ && sample == 0) return {{x + 0.5, y + 0.5}, false};
    return drawn_raster_sample(x, y, sample);
  }
  /// raster_sample() where the pixel pattern chose the point `u` of the unit square.
  RasterSample filtered(int x, int y, Vec2 u) const {
    return is_plain_box_ ? RasterSample{{x + u.x, y + u.y}, false} : widely_filtered(x, y, u);
  }
  /// Whether that point is pair(SampleUse::pixel).
  bool draws_points() const {
    return settings_.pattern == SamplePattern::owen_sobol ||
           settings_.pattern == SamplePattern::independent ||
           settings_.pattern == SamplePattern::blue_noise;
  }
  /// raster_sample(x, y, sample).point
  Vec2 raster_point(int x, int y, uint32_t sample) const {
    return raster_sample(x, y, sample).point;
  }
  /// By which the mean of signed samples is too small: the integral of |f| over that of f. Above 1
  /// where some samples are negative.
  double filter_gain() const { return table_ ? table_->gain() * table_->gain() : 1; }
  /// The numbers of a sample, by Owen-scrambled Sobol whatever the pixel pattern, but for
  /// `independent`.
  SampleStream stream(int x, int y, uint32_t sample) const;
  /// stream(x, y, sample).pair(use)
  Vec2 pair(int x, int y, uint32_t sample, SampleUse use) const;

 private:
  RasterSample drawn_raster_sample(int x, int y, uint32_t sample) const;
  RasterSample widely_filtered(int x, int y, Vec2 u) const;
  Vec2 pixel_square(int x, int y, uint32_t sample) const;
  SampleStream picture_stream(uint32_t column, uint32_t row, uint32_t sample) const;

  SamplerSettings settings_;
  uint32_t grid_ = 1;                         ///< cells on a side, for the grids
  bool is_centered_ = false;                  ///< a pixel's first sample is in its centre
  bool is_plain_box_ = false;                 ///< the filter is the pixel itself
  uint32_t sample_bits_ = 0;                  ///< that number a pixel's samples
  std::shared_ptr<const FilterTable> table_;  ///< null for box and tent, which have closed forms
};

}  // namespace tessera
