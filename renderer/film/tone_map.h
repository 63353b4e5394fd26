#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
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

/// Names of an OpenColorIO configuration. A value.
struct ColorManagement {
  std::string input = "scene_linear";  ///< the colour space of the picture's numbers, or its role
  std::string display, view;           ///< empty: the configuration's defaults
  std::string color_space;             ///< if not empty, in place of a view
  friend bool operator==(const ColorManagement&, const ColorManagement&) = default;
};

/// How a linear picture becomes numbers to show. A value.
struct OutputSettings {
  ToneCurve tone_curve = ToneCurve::clamp;
  TransferCurve transfer = TransferCurve::srgb;
  double gamma = 2.2;   ///< > 0
  double exposure = 0;  ///< stops
  Quantization quantization = Quantization::round;
  int bits = 8;  ///< of a channel in files of integers: 8 or 16
  /// a x^2 + b x + c per channel clamped to [0, 1], before the transfer curve.
  bool has_response = false;
  std::array<double, 3> response{0, 1, 0};
  /// Takes the place of tone curve, response and transfer curve.
  std::optional<ColorManagement> color_management{};
  friend bool operator==(const OutputSettings&, const OutputSettings&) = default;
};

/// The film with the exposure applied; what is no finite number is made one.
void expose(Film& film, const OutputSettings& settings);

/// The whole film, rows from the top, kFilmChannels bytes a pixel: exposure, tone curve, response,
/// transfer curve and quantization, in that order. Not a number becomes 0, infinity the largest
/// value. Colour management is not looked at.
std::vector<uint8_t> to_8_bit(const Film& film, const OutputSettings& settings);
/// Likewise with 16 bits a channel.
std::vector<uint16_t> to_16_bit(const Film& film, const OutputSettings& settings);

}  // namespace tessera
