#pragma once

#include <cstddef>

#include "metrics/picture.h"

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
PictureError picture_error(const PictureView& picture, const PictureView& reference,
                           const PixelMask& mask = {}, bool with_flip = true);

}  // namespace tessera
