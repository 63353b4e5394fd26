#include "renderer/film/tone_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace tessera {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

OutputSettings display(ToneCurve curve = ToneCurve::clamp) {
  return {.tone_curve = curve, .transfer = TransferCurve::display};
}

using Bytes = std::vector<uint8_t>;

Bytes bytes_of(const OutputSettings& settings, const std::array<float, 3>& pixel) {
  Film film({0, 0, 1, 1});
  std::copy(pixel.begin(), pixel.end(), film.values().begin());
  return to_8_bit(film, settings);
}

uint8_t byte_of(const OutputSettings& settings, float grey) {
  return bytes_of(settings, {grey, grey, grey})[1];
}

TEST(ToneMap, display_numbers_are_written_as_they_are) {
  EXPECT_EQ(byte_of(display(), 0.8f), 204);
  EXPECT_EQ(byte_of(display(), 0), 0);
  EXPECT_EQ(byte_of(display(), -3), 0);
  EXPECT_EQ(byte_of(display(), 7), 255);
  EXPECT_EQ(byte_of(display(), kInfinite), 255);
  EXPECT_EQ(byte_of(display(), -kInfinite), 0);
  EXPECT_EQ(byte_of(display(), kNotANumber), 0);
}

TEST(ToneMap, truncation_and_rounding_part_at_the_half) {
  OutputSettings settings = display();
  EXPECT_EQ(byte_of(settings, 100.6f / 255), 101);
  settings.quantization = Quantization::truncate;
  EXPECT_EQ(byte_of(settings, 100.6f / 255), 100);
  EXPECT_EQ(byte_of(settings, 1), 255);
  EXPECT_EQ(byte_of({.quantization = Quantization::truncate}, 1), 255);
}

TEST(ToneMap, srgb_and_gamma) {
  EXPECT_EQ(byte_of({}, 0.5f), 188);
  EXPECT_EQ(byte_of({}, 0.21404114f), 128);
  EXPECT_EQ(byte_of({}, 0.001f), 3);
  EXPECT_EQ(byte_of({}, 1), 255);
  EXPECT_EQ(byte_of({.transfer = TransferCurve::gamma, .gamma = 2}, 0.25f), 128);
  EXPECT_EQ(byte_of({.transfer = TransferCurve::gamma, .gamma = 2}, 0), 0);
}

/// The curves once more, by the C library.
double expected(const OutputSettings& settings, double v) {
  if (settings.tone_curve == ToneCurve::filmic) {
    v = std::min(v * (2.51 * v + 0.03) / (v * (2.43 * v + 0.59) + 0.14), 1.0);
  }
  v = std::min(v, 1.0);
  if (settings.transfer == TransferCurve::gamma) return std::pow(v, 1 / settings.gamma);
  if (settings.transfer == TransferCurve::display) return v;
  return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

TEST(ToneMap, bytes_are_the_quantized_values_of_each_pixel) {
  Film film({0, 0, 5000, 1});
  for (size_t i = 0; i < film.values().size(); ++i) {
    film.values()[i] = static_cast<float>(i) * 1.3f / static_cast<float>(film.values().size());
  }
  for (const TransferCurve transfer :
       {TransferCurve::srgb, TransferCurve::gamma, TransferCurve::display}) {
    for (const Quantization how : {Quantization::round, Quantization::truncate}) {
      const OutputSettings settings{
          .tone_curve = ToneCurve::filmic, .transfer = transfer, .quantization = how};
      const Bytes bytes = to_8_bit(film, settings);
      for (size_t i = 0; i < bytes.size(); ++i) {
        const double scaled = 255 * expected(settings, double{film.values()[i]});
        const double low = how == Quantization::round ? scaled - 0.5 : scaled - 1;
        ASSERT_NEAR(bytes[i], low + 0.5, 0.5 + 1e-9) << film.values()[i];
      }
      const std::vector<uint16_t> integers = to_16_bit(film, settings);
      for (size_t i = 0; i < integers.size(); ++i) {
        const double scaled = 65535 * expected(settings, double{film.values()[i]});
        const double low = how == Quantization::round ? scaled - 0.5 : scaled - 1;
        ASSERT_NEAR(integers[i], low + 0.5, 0.5 + 1e-7) << film.values()[i];
      }
    }
  }
}

TEST(ToneMap, exposure_is_in_stops) {
  OutputSettings settings = display();
  settings.exposure = 2;
  EXPECT_EQ(byte_of(settings, 0.125f), 128);
  settings.exposure = -1;
  EXPECT_EQ(byte_of(settings, 0.5f), 64);
}

TEST(ToneMap, linear_is_clamped) { EXPECT_EQ(byte_of(display(ToneCurve::linear), 3), 255); }

TEST(ToneMap, reinhard) {
  EXPECT_EQ(bytes_of(display(ToneCurve::reinhard), {1, 3, kInfinite}), (Bytes{128, 191, 255}));
  EXPECT_EQ(byte_of(display(ToneCurve::reinhard), -1), 0);
}

TEST(ToneMap, reinhard_on_luminance_keeps_the_hue) {
  // 2 * .2126 + .7152 + .5 * .0722 = 1.1765: over 2.1765 each.
  EXPECT_EQ(bytes_of(display(ToneCurve::reinhard_luminance), {2, 1, 0.5f}), (Bytes{234, 117, 59}));
}

TEST(ToneMap, filmic_runs_from_black_to_white) {
  EXPECT_EQ(bytes_of(display(ToneCurve::filmic), {0, 1, kInfinite}), (Bytes{0, 205, 255}));
}

TEST(ToneMap, response_polynomial) {
  OutputSettings settings = display();
  settings.has_response = true;
  settings.response = {-1.2, 2.2, 0};
  EXPECT_EQ(bytes_of(settings, {0.5f, 2, -1}), (Bytes{204, 255, 0}));
  settings.response = {0.476, 0.5239, 0};
  EXPECT_EQ(byte_of(settings, 0.5f), 97);  // .38095
}

}  // namespace
}  // namespace tessera
