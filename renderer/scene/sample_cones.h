#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "renderer/camera/camera.h"

namespace tessera {

/// What each sample of a pixel stands for, and textures are filtered for: a part of the pixel's
/// cone, the smaller the more samples share the pixel.
///
/// How many these will be, adaptive sampling does not know. Filtered for the most, each of its
/// samples would be noisier than those of a picture of few samples everywhere, which is smooth
/// because it is filtered for few. So there the samples up to a power of two n are filtered for
/// 2 n: a pixel that stops soon is smooth, and one that goes on becomes sharper. Twice, since its
/// first samples, filtered for fewer, stay in its mean.
///
/// A sample's cone depends on its number alone. A value; thread-safe.
class SampleCones {
 public:
  SampleCones() = default;
  /// Every pixel has `samples`, one or more.
  SampleCones(const Camera::PixelCone& pixel, uint32_t samples)
      : pixel_(pixel), least_(samples), most_(samples) {}
  /// Pixels have `first_look` samples, a power of two, or twice as many and so on, or `most`, which
  /// may be less.
  SampleCones(const Camera::PixelCone& pixel, uint32_t first_look, uint32_t most)
      : pixel_(pixel), least_(std::min(2 * first_look, most)), most_(most) {}

  /// Of the sample of this number; the first has 0.
  Camera::PixelCone of(uint32_t sample) const {
    const uint32_t count = std::clamp(2 * std::bit_ceil(sample + 1), least_, most_);
    const double share = std::max(1 / std::sqrt(static_cast<double>(count)), kLeastShare);
    return {pixel_.at_eye * share, pixel_.spread * share};
  }

 private:
  /// Few samples look at exactly their own part of the pixel.
  static constexpr double kLeastShare = 0.125;

  Camera::PixelCone pixel_;
  uint32_t least_ = 1, most_ = 1;
};

}  // namespace tessera
