#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/film/film.h"

namespace tessera {

enum class ToneCurve {
  clamp,
  reinhard,            ///< x / (1 + x) per channel (Reinhard et al. 2002, equation 3)
  reinhard_luminance,  ///< the same on Rec. 709 luminance, colours scaled alike
  filmic,              ///< Narkowicz's fit of the ACES curve (2015)
  linear               ///< as clamp for integers; values are left alone for floats
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

/// Exposure, tone curve, response, transfer curve, in that order. Not a number becomes 0, infinity
/// the largest value. Results lie in [0, 1].
std::array<double, 3> tone_map(const OutputSettings& settings, const std::array<float, 3>& linear);

/// `value` in [0, 1] to an integer of [0, largest].
uint32_t quantize(double value, uint32_t largest, Quantization how);

/// The whole film, rows from the top, kFilmChannels a pixel.
std::vector<uint8_t> to_8_bit(const Film& film, const OutputSettings& settings);
std::vector<uint16_t> to_16_bit(const Film& film, const OutputSettings& settings);
/// Tone-mapped values in [0, 1] as floats.
std::vector<float> to_display_float(const Film& film, const OutputSettings& settings);

}  // namespace tessera
