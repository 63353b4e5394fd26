#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "renderer/math/color.h"

namespace tessera {

/// How far the means of a block's pixels are off, estimated from their samples.
///
/// The points of a (0,2)-sequence err less than independent ones, so the spread of a pixel's
/// samples says too much of its error, and how much too much depends on the scene. What tells is
/// the difference of the means of the first and the second half of the samples: the mean of its
/// quarter square is the variance of the mean of all where samples are independent, up to 1.8 times
/// that on edges, where they are better, and never less. A fluke of few pixels does not pass: what
/// edges would have counts as much as the differences of four pixels.
///
/// What was not seen is not known to be absent: a feature of display white that the samples of the
/// whole block miss with chance 1/e is part of the error, and each pixel's mean counts as one
/// more sample for its neighbours. So no block passes by having no variance.
class BlockEstimate {
 public:
  static constexpr int kMaxPixels = 64;

  /// `nets`: samples are of a (0,2)-sequence; or else independent. `gain`: of the filter's signs.
  BlockEstimate(int pixels, bool nets, double gain);

  /// The next sample of a pixel: finite.
  void add(int pixel, const Color& sample);
  /// All pixels have `samples` samples: 2, 4, 8 and so on, each in turn.
  void look(uint32_t samples);

  /// Of the latest look: root mean square of the pixels' means' standard errors over the block and
  /// the three channels.
  double standard_error() const;
  /// Of one pixel's mean, over the three channels: the block's variance in the pixels' shares.
  double standard_error(int pixel) const;

 private:
  struct Pixel {
    Color origin, sum, squares;  ///< of the samples less the first one
    Color half;                  ///< the sum at the look before
    bool begun = false;
  };
  std::array<Pixel, kMaxPixels> pixels_{};
  size_t count_;
  std::array<double, kMaxPixels>
      spread_{};  ///< each pixel's share of the variance, at the latest look
  double spread_sum_ = 0;
  double variance_ = 0, unseen_ = 0;
  bool nets_;
  double gain_squared_;
};

}  // namespace tessera
