#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "renderer/film/block.h"
#include "renderer/math/color.h"

namespace tessera {

/// How far the means of a block's pixels are off, estimated from their samples.
///
/// The points of a (0,2)-sequence err less than independent ones, so the spread of a pixel's
/// samples says too much of its error, and how much too much depends on the scene. What tells is
/// the difference of the means of the first and the second half of the samples: the mean over the
/// block of its quarter square is the variance of a mean of all samples where they are independent,
/// and more where they are better: 1.8 times that on edges, 3 times on edges along an axis. A fluke
/// of few pixels does not pass: what edges would have counts as much as the differences of four.
///
/// Errors of a pixel brighter than display white count in proportion to it.
///
/// What was not seen is not known to be absent. One block in 64 is taken to hide a feature of
/// display white that all its samples miss with chance 1/e, so that no block passes by having no
/// variance; and for each pixel, the block's other samples count as six more of its own.
class BlockEstimate {
 public:
  static constexpr int kMaxPixels = kBlockSide * kBlockSide;

  /// `nets`: samples are of a (0,2)-sequence; or else independent. `gain`: of the filter's signs.
  BlockEstimate(int pixels, bool nets, double gain);

  /// The next sample of a pixel: finite.
  void add(int pixel, const Color& sample);
  /// All pixels have `samples` samples: 2, 4, 8 and so on, each in turn.
  void look(uint32_t samples);

  /// Of the latest look: root mean square of the pixels' means' standard errors over the block and
  /// the three channels; of a pixel brighter than display white in proportion to it.
  double standard_error() const;
  /// Of one pixel's mean, over the three channels: the block's, in the ratio of what its samples
  /// vary. Of the pixels that vary at all, 95 % are to lie within 1.96 times this of the truth.
  double standard_error(int pixel) const;

 private:
  void share_pixels(double n, double own, double between, const Color& block_mean);

  struct Pixel {
    Color origin, sum, squares;  ///< of the samples less the first one
    Color half;                  ///< the sum at the look before
    bool begun = false;
  };
  std::array<Pixel, kMaxPixels> pixels_{};
  size_t count_;
  std::array<double, kMaxPixels> spread_{};  ///< of each pixel, over the block's mean
  double variance_ = 0, unseen_ = 0;
  double unsure_ = 1;  ///< by which a pixel's variance is widened, since little tells it
  bool nets_;
  double gain_squared_;
};

}  // namespace tessera
