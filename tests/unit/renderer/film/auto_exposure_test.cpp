#include "renderer/film/auto_exposure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tessera {
namespace {

/// Grey pixels in a line, of that light, with depth behind them.
Film line_of(const std::vector<float>& light, AovSet aovs = {}) {
  Film film({0, 0, static_cast<int>(light.size()), 1}, aovs);
  const auto channels = static_cast<size_t>(film.channels());
  for (size_t i = 0; i < light.size(); ++i)
    for (size_t c = 0; c < kFilmChannels; ++c) film.values()[i * channels + c] = light[i];
  return film;
}

TEST(AutoExposure, brings_even_light_to_middle_grey) {
  for (const float light : {.18f, .045f, 1.0f, 1000.0f, 1e-6f}) {
    const double stops = auto_exposure(line_of({light, light, light}));
    EXPECT_NEAR(light * std::exp2(stops), .18, .18 * .006) << light;
    EXPECT_EQ(stops, std::stod(std::to_string(stops))) << "no more than its printed digits";
  }
}

TEST(AutoExposure, is_of_the_mean_of_logarithms) {
  // Two stops up and two down.
  EXPECT_NEAR(auto_exposure(line_of({.72f, .045f, .18f, .72f, .045f})), 0, .011);
}

TEST(AutoExposure, few_bright_or_dark_pixels_do_not_count) {
  std::vector<float> light(100, .36f);
  for (size_t i = 0; i < 9; ++i) light[i] = 1e9f, light[99 - i] = 1e-9f;
  EXPECT_NEAR(auto_exposure(line_of(light)), -1, .011);
  light[40] = std::numeric_limits<float>::quiet_NaN();
  light[41] = std::numeric_limits<float>::infinity();
  light[42] = -1;
  EXPECT_NEAR(auto_exposure(line_of(light)), -1, .011);
}

TEST(AutoExposure, is_of_surfaces_where_the_film_tells_them) {
  std::vector<float> light(100, 50.0f);
  for (size_t i = 0; i < 20; ++i) light[i] = .09f;
  EXPECT_LT(auto_exposure(line_of(light)), -3) << "nothing tells the background";
  for (const Aov aov : {Aov::alpha, Aov::depth, Aov::id}) {
    const AovSet aovs = AovSet().with(Aov::samples).with(aov);
    Film film = line_of(light, aovs);
    for (size_t i = 0; i < 20; ++i)
      film.values()[i * 5 + static_cast<size_t>(aovs.first_channel(aov))] = 1;
    EXPECT_NEAR(auto_exposure(film), 1, .011);
  }
}

TEST(AutoExposure, of_black_is_none) {
  EXPECT_EQ(auto_exposure(line_of({0, 0})), 0);
  EXPECT_EQ(auto_exposure(line_of({.5f}, AovSet().with(Aov::depth))), 0) << "no surface";
}

}  // namespace
}  // namespace tessera
