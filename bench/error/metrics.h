#pragma once

#include <cstddef>

#include "bench/error/picture.h"

namespace tessera {

/// How far a picture is from the reference. Means are over the channels of all pixels that count. A
/// value that is no finite number is taken as 0 and counted.
struct PictureError {
  double mse = 0, rmse = 0;
  double rel_mse = 0;          ///< mean of (x - r)^2 / (r^2 + .01)
  double trimmed_rel_mse = 0;  ///< the same without the largest thousandth of the terms
  double smape = 0;            ///< mean of 2 |x - r| / (|x| + |r| + .01), 0 to 2
  double flip = 0;             ///< mean of flip_map(), 0 to 1
  double max_error = 0;        ///< greatest |x - r|
  double error_99_9 = 0;       ///< |x - r| that all but a thousandth of the values stay within
  double mean_ratio = 0;       ///< mean of the picture over the mean of the reference
  size_t not_finite = 0;       ///< values, not pixels
};

/// Both must have one size and some pixel that counts.
PictureError picture_error(const Picture& picture, const Picture& reference,
                           const PixelMask& mask = {}, bool with_flip = true);

/// What a picture should be, in two pictures whose errors have nothing to do with each other; or
/// one that has no error, twice.
struct Reference {
  Picture first, second;

  Picture mean() const;
  /// The error of mean(): half of the root mean square of first - second.
  double error(const PixelMask& mask = {}) const;
};

/// The mean square of picture - reference. By (x - first)(x - second), so that the references' own
/// noise cancels: it may be slightly below 0.
double mean_square_error(const Picture& picture, const Reference& reference,
                         const PixelMask& mask = {});

/// Gathers pictures of one estimator under several seeds; bias^2 = MSE - Var (Mueller et al. 2006,
/// "Image quality assessment by path"; Celarek et al. 2019), for each pixel without its own noise.
class BiasEstimator {
 public:
  explicit BiasEstimator(Reference reference, PixelMask mask = {});

  void add(const Picture& picture);

  struct Result {
    double bias = 0;      ///< sqrt(max(0, bias^2)), root mean square over the picture
    double sigmas = 0;    ///< bias^2 in standard errors, pixels taken as independent: an unbiased
                          ///< estimator gives about N(0, 1)
    double variance = 0;  ///< of one picture's values, mean over the picture
  };
  /// Needs two pictures at least; before that all is 0.
  Result result() const;

 private:
  Reference reference_;
  PixelMask mask_;
  int count_ = 0;
  std::vector<double> sum_, sum_of_squares_;  ///< of differences from the first reference
};

}  // namespace tessera
