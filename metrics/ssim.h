#pragma once

#include "metrics/picture.h"

namespace tessera {

/// The mean structural similarity of two pictures of one size (Wang, Bovik, Sheikh, Simoncelli
/// 2004, "Image Quality Assessment: From Error Visibility to Structural Similarity", IEEE TIP): 1
/// for equal pictures, at least -1. Windows are 11 x 11 Gaussians of standard deviation 1.5 pixels
/// that lie wholly in the picture; K1 = .01, K2 = .03. They see the luminance (ITU-R BT.709) of the
/// linear light clamped to [0, 1], encoded as sRGB; what is no number counts as 0. Of a picture
/// that is narrower or lower than 11 pixels the windows are as large as fits. Symmetric in both.
double mean_ssim(const PictureView& a, const PictureView& b);

}  // namespace tessera
