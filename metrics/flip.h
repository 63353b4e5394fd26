#pragma once

#include <vector>

#include "metrics/picture.h"

namespace tessera {

/// Of a 0.7 m wide screen of 3,840 pixels seen from 0.7 m: the paper's choice.
inline constexpr double kUsualPixelsPerDegree = 67.0206;

/// What a viewer who flips between both pictures notices, 0 to 1 a pixel: LDR-FLIP (Andersson,
/// Nilsson, Akenine-Moeller, Oskarsson, Astroem, Fairchild 2020, "FLIP: A Difference Evaluator for
/// Alternating Images", HPG). The pictures are linear and are clamped to [0, 1]
/// first, which is our default tone curve; what is no number counts as 0. Symmetric in both. In
/// single precision, as the paper's own program, on all processors; their number makes no
/// difference.
std::vector<float> flip_map(const PictureView& a, const PictureView& b,
                            double pixels_per_degree = kUsualPixelsPerDegree);

/// The mean of flip_map over the pixels that count.
double mean_flip(const PictureView& a, const PictureView& b, const PixelMask& mask = {},
                 double pixels_per_degree = kUsualPixelsPerDegree);

}  // namespace tessera
