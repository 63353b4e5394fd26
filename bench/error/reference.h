#pragma once

#include <vector>

#include "metrics/picture.h"

namespace tessera {

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
