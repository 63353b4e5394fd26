#include "renderer/film/tone_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tessera {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

OutputSettings display(ToneCurve curve = ToneCurve::clamp) {
  return {.tone_curve = curve, .transfer = TransferCurve::display};
}

uint8_t byte_of(const OutputSettings& settings, float grey) {
  Film film({0, 0, 1, 1});
  film.values()[0] = film.values()[1] = film.values()[2] = grey;
  return to_8_bit(film, settings)[1];
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
  EXPECT_EQ(quantize(tone_map({}, {1, 1, 1})[0], 255, Quantization::truncate), 255u);
}

TEST(ToneMap, srgb_and_gamma) {
  EXPECT_EQ(byte_of({}, 0.5f), 188);
  EXPECT_EQ(byte_of({}, 0.21404114f), 128);
  EXPECT_EQ(byte_of({}, 0.001f), 3);
  EXPECT_EQ(byte_of({}, 1), 255);
  EXPECT_EQ(byte_of({.transfer = TransferCurve::gamma, .gamma = 2}, 0.25f), 128);
  EXPECT_EQ(byte_of({.transfer = TransferCurve::gamma, .gamma = 2}, 0), 0);
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
      const std::vector<uint8_t> bytes = to_8_bit(film, settings);
      for (size_t i = 0; i < bytes.size(); i += 3) {
        const float* v = &film.values()[i];
        const auto exact = tone_map(settings, {v[0], v[1], v[2]});
        for (size_t c = 0; c < 3; ++c) ASSERT_EQ(bytes[i + c], quantize(exact[c], 255, how));
      }
    }
  }
}

TEST(ToneMap, exposure_is_in_stops) {
  OutputSettings settings = display();
  settings.exposure = 2;
  EXPECT_NEAR(tone_map(settings, {0.125f, 0, 0})[0], 0.5, 1e-15);
  settings.exposure = -1;
  EXPECT_NEAR(tone_map(settings, {0.5f, 0, 0})[0], 0.25, 1e-15);
}

TEST(ToneMap, reinhard) {
  const auto mapped = tone_map(display(ToneCurve::reinhard), {1, 3, kInfinite});
  EXPECT_EQ(mapped[0], 0.5);
  EXPECT_EQ(mapped[1], 0.75);
  EXPECT_EQ(mapped[2], 1);
  EXPECT_EQ(tone_map(display(ToneCurve::reinhard), {-1, 0, 0})[0], 0);
}

TEST(ToneMap, reinhard_on_luminance_keeps_the_hue) {
  const auto mapped = tone_map(display(ToneCurve::reinhard_luminance), {2, 1, 0.5f});
  const double y = 2 * 0.2126 + 0.7152 + 0.5 * 0.0722;
  EXPECT_NEAR(mapped[1], 1 / (1 + y), 1e-15);
  EXPECT_NEAR(mapped[1] / mapped[2], 2, 1e-12);
}

TEST(ToneMap, filmic_runs_from_black_to_white) {
  EXPECT_EQ(tone_map(display(ToneCurve::filmic), {0, 0, 0})[0], 0);
  EXPECT_NEAR(tone_map(display(ToneCurve::filmic), {1, 0, 0})[0], 2.54 / 3.16, 1e-12);
  EXPECT_EQ(tone_map(display(ToneCurve::filmic), {kInfinite, 0, 0})[0], 1);
}

TEST(ToneMap, response_polynomial) {
  OutputSettings settings = display();
  settings.has_response = true;
  settings.response = {-1.2, 2.2, 0};
  EXPECT_NEAR(tone_map(settings, {0.5f, 2, -1})[0], 0.8, 1e-15);
  EXPECT_EQ(tone_map(settings, {0.5f, 2, -1})[1], 1);
  EXPECT_EQ(tone_map(settings, {0.5f, 2, -1})[2], 0);
}

TEST(ToneMap, sixteen_bits_and_floats) {
  Film film({0, 0, 1, 1});
  film.values()[0] = 1;
  film.values()[1] = 0.5f;
  EXPECT_EQ(to_16_bit(film, display()), (std::vector<uint16_t>{65535, 32768, 0}));
  EXPECT_EQ(to_display_float(film, display()), (std::vector<float>{1, 0.5f, 0}));
}

}  // namespace
}  // namespace tessera
