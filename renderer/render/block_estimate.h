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
/// by how much the means of neighbouring runs of samples differ: the mean quarter square of the
/// difference of two runs of n / 2 is the variance of a mean of n / 2 less that of a mean of n. Of
/// the spread we take a part to be that of edges, whose variance falls by n^-1.5, and the rest to
/// fall by 1 / n as that of independent samples; which part, the differences of runs of n / 2, n /
/// 4 and n / 8 tell by least squares over the block.
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
  /// The first look is after `first_look` samples: 2, 4, 8 and so on.
  BlockEstimate(int pixels, bool nets, double gain, uint32_t first_look);

  /// The next sample of a pixel: finite.
  void add(int pixel, const Color& sample) {
    Pixel& p = pixels_[static_cast<size_t>(pixel)];
    if (p.count == 0) p.origin = sample;
    const Color away = sample - p.origin;
    p.sum += away;
    p.squares += away * away;
    if ((++p.count & (run_ - 1)) == 0) p.ends[p.count / run_ - 1] = p.sum;
  }
  /// All pixels have `samples` samples: those of the first look, twice as many and so on, in turn.
  void look(uint32_t samples);

  /// Of the latest look: root mean square of the pixels' means' standard errors over the block and
  /// the three channels; of a pixel brighter than display white in proportion to it.
  double standard_error() const;
  /// The same of what the second half of the samples took off the error of the first: the root of
  /// the difference of the squares. Were that of independent samples not in doubt it would be
  /// standard_error(); that of others is more, since theirs falls faster. And two standard
  /// deviations above what is found, since few samples of few pixels may find too little by chance.
  double most_taken_off() const;
  /// Of one pixel's mean, over the three channels: the block's, in the ratio of what its samples
  /// vary. Of the pixels that vary at all, 95 % are to lie within 1.96 times this of the truth.
  double standard_error(int pixel) const;

 private:
  static constexpr uint32_t kRuns = 8;
  struct Pixel {
    Color origin, sum, squares;  ///< of the samples less the first one
    /// `sum` at the end of each run of samples.
    std::array<Color, kRuns> ends;
    uint32_t count = 0;
  };
  double edge_part(double spread) const;
  double differences_of(const Pixel& pixel, size_t runs, size_t length) const;
  Color mean_of(const Pixel& pixel) const;
  double spread_of(const Pixel& pixel) const;

  std::array<Pixel, kMaxPixels> pixels_{};
  size_t count_;
  uint32_t samples_ = 0;  ///< of each pixel at the latest look
  uint32_t run_;          ///< samples; at a look from `kRuns` samples on, an eighth of them
  double variance_ = 0, taken_off_ = 0, unseen_ = 0;
  double freedom_ = 1;  ///< degrees of it that the spread has
  bool nets_;
  double gain_squared_;
};

}  // namespace tessera
