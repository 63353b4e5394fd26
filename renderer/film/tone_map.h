#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/film/film.h"

namespace tessera {

enum class ToneCurve {
  clamp,
  reinhard,            ///< x / (1 + x) per channel (Reinhard et al. 2002, equation 3)
  reinhard_luminance,  ///< the same on Rec. 709 luminance, colours scaled alike
  filmic,              ///< Narkowicz's fit of the ACES curve (2015)
  linear               ///< as clamp
};
enum class TransferCurve { srgb, display, gamma };
enum class Quantization { round, truncate };

/// How a linear picture becomes numbers to show. A value.
struct OutputSettings {
  ToneCurve tone_curve = ToneCurve::clamp;
  TransferCurve transfer = TransferCurve::srgb;
  double gamma = 2.2;   ///< > 0
  double exposure = 0;  ///< stops
  Quantization quantization = Quantization::round;
  /// a x^2 + b x + c per channel clamped to [0, 1], before the transfer curve.
  bool has_response = false;
  std::array<double, 3> response{0, 1, 0};
  friend bool operator==(const OutputSettings&, const OutputSettings&) = default;
};

/// The whole film, rows from the top, kFilmChannels bytes a pixel: exposure, tone curve, response,
/// transfer curve and quantization, in that order. Not a number becomes 0, infinity the largest
/// value.
std::vector<uint8_t> to_8_bit(const Film& film, const OutputSettings& settings);

}  // namespace tessera
