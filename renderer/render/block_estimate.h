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
/// What was not seen is not known to be absent. One block in 64 at least is taken to hide a feature
/// of display white that all its samples miss with chance 1/e, so that no block passes by having no
/// variance.
class BlockEstimate {
 public:
  static constexpr int kMaxPixels = kBlockSide * kBlockSide;

  /// `nets`: samples are of a (0,2)-sequence; or else independent. `gain`: of the filter's signs.
  /// The first look is after `first_look` samples: 2, 4, 8 and so on. `by_pixel`: standard_errors()
  /// will be asked for. `by_chance`: the radiance of what is met by chance alone.
  BlockEstimate(int pixels, bool nets, double gain, uint32_t first_look, bool by_pixel = false,
                double by_chance = 1);

  /// The next sample of a pixel: finite.
  void add(int pixel, const Color& sample) {
    Pixel& p = pixels_[static_cast<size_t>(pixel)];
    if (p.count == 0) p.origin = sample;
    const Color away = sample - p.origin;
    p.sum += away;
    p.squares += away * away;
    if (by_pixel_) p.powers.add(away.r + away.g + away.b);
    if ((++p.count & (run_ - 1)) == 0) p.ends[p.count / run_ - 1] = p.sum;
  }
  /// All pixels have `samples` samples: those of the first look, twice as many and so on, in turn.
  /// `hidden`: HiddenLight::square_error() of them.
  void look(uint32_t samples, double hidden = 0);

  /// Of the latest look: root mean square of the pixels' means' standard errors over the block and
  /// the three channels; of a pixel brighter than display white in proportion to it.
  double standard_error() const;
  /// The same of what the second half of the samples took off the error of the first: the root of
  /// the difference of the squares. Were that of independent samples not in doubt it would be
  /// standard_error(); that of others is more, since theirs falls faster. And two standard
  /// deviations above what is found, since few samples of few pixels may find too little by chance.
  double most_taken_off() const;
  /// Of each pixel's mean, over the three channels and whatever its brightness: of the pixels that
  /// vary at all, 95 % are to lie within 1.96 times this of the truth. Pixels that have met what is
  /// rare know their own spread badly, and those that have not know it too small: each takes the
  /// block's for its own as far as the block's pixels are alike. What the block hides may be as
  /// bright as what is met by chance.
  std::array<double, kMaxPixels> standard_errors() const;

 private:
  static constexpr uint32_t kRuns = 8;
  /// Of a pixel's samples, as numbers: sums of their powers.
  struct Powers {
    double second = 0, third = 0, fourth = 0;
    void add(double x) {
      const double square = x * x;
      second += square;
      third += square * x;
      fourth += square * square;
    }
  };
  struct Pixel {
    Color origin, sum, squares;  ///< of the samples less the first one
    /// `sum` at the end of each run of samples.
    std::array<Color, kRuns> ends;
    Powers powers;  ///< of what is added to `sum`, over the channels
    uint32_t count = 0;
  };
  struct Pool;
  struct Left;
  double edge_part(double spread) const;
  double differences_of(const Pixel& pixel, size_t runs, size_t length) const;
  Color mean_of(const Pixel& pixel) const;
  double spread_of(const Pixel& pixel) const;
  double variance_of(const Pixel& pixel) const;
  double kurtosis_of(const Pixel& pixel) const;
  Pool pool() const;
  double left_of_spread(double of_edge) const;
  Left left_of_independent(const Pool& pooled) const;
  double hidden() const;

  std::array<Pixel, kMaxPixels> pixels_{};
  size_t count_;
  uint32_t samples_ = 0;  ///< of each pixel at the latest look
  uint32_t run_;          ///< samples; at a look from `kRuns` samples on, an eighth of them
  double variance_ = 0, taken_off_ = 0, unseen_ = 0;
  double freedom_ = 1;  ///< degrees of it that the spread has
  double edges_ = 0;    ///< the part of the spread that edges have
  bool nets_, by_pixel_;
  double gain_squared_, by_chance_;
};

}  // namespace tessera
