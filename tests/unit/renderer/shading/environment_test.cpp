#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "renderer/math/frame.h"
#include "renderer/math/warp.h"
#include "renderer/shading/environment_sampler.h"
#include "renderer/shading/sky.h"
#include "tests/chi_square.h"
#include "tests/uniform_numbers.h"

namespace tessera {
namespace {

Background daylight(const Vec3& to_sun) {
  Background background;
  background.kind = BackgroundKind::sun_and_sky;
  background.daylight = std::make_shared<Sky>(normalize(to_sun), 3, 1, Color{0.2, 0.2, 0.2});
  return background;
}

constexpr uint32_t kWidth = 64, kHeight = 32;

template <typename Value>
Background panorama_of(const Value& value,
                       BackgroundKind kind = BackgroundKind::panorama_equirectangular) {
  auto texels = std::shared_ptr<float[]>(new float[kWidth * kHeight * 3]);
  for (uint32_t i = 0; i < kWidth * kHeight; ++i)
    std::fill_n(texels.get() + 3 * i, 3, static_cast<float>(value(i)));
  ImageTextureSettings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  settings.bits = 32;
  settings.filter = ImageTextureSettings::Filter::bilinear;
  settings.wrap_t = ImageTextureSettings::Wrap::clamp;
  Background background;
  background.kind = kind;
  background.angle = 0.5;
  background.picture = std::make_shared<ImageTexture>(
      settings,
      std::shared_ptr<const std::byte>(texels, reinterpret_cast<const std::byte*>(texels.get())));
  return background;
}

/// Half of the picture bright, and one texel of it very bright.
Background panorama() {
  return panorama_of([](uint32_t i) {
    return i == 700 ? 500 : i % kWidth < kWidth / 2 ? 1 : 0.01;
  });
}
/// Its faces are as bright as they have numbers, but for the first, which is far brighter.
Background cube() {
  Background background;
  background.has_cube = true;
  for (int face = 0; face < 6; ++face)
    background.cube[static_cast<size_t>(face)] =
        panorama_of([&](uint32_t) { return face == 0 ? 50 : face; }).picture;
  return background;
}

/// A sixth of the texels far brighter than the others, by all degrees.
Background speckles(BackgroundKind kind) {
  UniformNumbers random(3);
  return panorama_of([&](uint32_t) { return 50 * std::pow(random(), 8); }, kind);
}

/// Irradiance on a surface that faces `n`, by the rule of mid-points over all directions.
double irradiance(const Background& background, const Vec3& n) {
  constexpr int kSide = 600;
  double sum = 0;
  for (int i = 0; i < kSide; ++i) {
    const double z = 2 * (i + 0.5) / kSide - 1, r = std::sqrt(1 - z * z);
    for (int j = 0; j < 2 * kSide; ++j) {
      const double phi = 2 * std::numbers::pi * (j + 0.5) / (2 * kSide);
      const Vec3 d{r * std::cos(phi), r * std::sin(phi), z};
      if (dot(d, n) > 0) sum += background.radiance({}, d, {}).g * dot(d, n);
    }
  }
  return sum * 4 * std::numbers::pi / (2.0 * kSide * kSide);
}

struct Estimate {
  double mean, error;
};

/// By directions of the sampler's and as many of all, weighted against each other: what is even it
/// leaves to others.
Estimate estimate(const Background& background, const Vec3& n) {
  const auto sampler = make_environment_sampler(background);
  constexpr double kEvenly = 1 / (4 * std::numbers::pi);
  UniformNumbers random(7);
  const auto light = [&](const Vec3& d, double density) {
    if (!(density > 0) || !(dot(d, n) > 0)) return 0.0;
    return background.radiance({}, d, {}).g * dot(d, n) / (density + kEvenly);
  };
  constexpr int kCount = 200000;
  double sum = 0, squares = 0;
  for (int i = 0; i < kCount; ++i) {
    const double x = random(), y = random(), u = random(), v = random();
    const EnvironmentSampler::Sample sample = sampler->sample({x, y});
    if (sample.density > 0) {
      EXPECT_NEAR(sampler->density(sample.wi), sample.density, 1e-6 * sample.density);
    }
    const Vec3 d = direction_at(1 - 2 * u, v);
    const double value = light(sample.wi, sample.density) + background.radiance({}, d, {}).g *
                                                                std::max(0.0, dot(d, n)) /
                                                                (sampler->density(d) + kEvenly);
    sum += value;
    squares += value * value;
  }
  const double mean = sum / kCount;
  return {mean, std::sqrt((squares / kCount - mean * mean) / kCount)};
}

TEST(EnvironmentSampler, EstimatesTheLightOfPicturesAndOfAnEvening) {
  for (const Background& background :
       {panorama(), speckles(BackgroundKind::panorama_equirectangular),
        speckles(BackgroundKind::panorama_equal_area), cube(), daylight({1, -0.1, 0.3})}) {
    for (const Vec3& n : {Vec3{0, 1, 0}, normalize(Vec3{-1, 0.3, 0.2})}) {
      const Estimate found = estimate(background, n);
      EXPECT_NEAR(found.mean, irradiance(background, n), 4.5 * found.error + 0.003 * found.mean);
    }
  }
}

TEST(EnvironmentSampler, FollowsTheLightOfASmallSunTexelByTexel) {
  const Background background =
      panorama_of([](uint32_t i) { return i == 700 || i == 701 ? 50'000 : 0.1; });
  const auto sampler = make_environment_sampler(background);
  UniformNumbers random(7);
  double least = 1e300, most = 0;
  for (int i = 0; i < 10'000; ++i) {
    const double x = random(), y = random();
    const EnvironmentSampler::Sample sample = sampler->sample({x, y});
    const double light = background.radiance({}, sample.wi, {}).g;
    if (light < 500) continue;  // beside it, where what is left to scattering counts
    least = std::min(least, light / sample.density);
    most = std::max(most, light / sample.density);
  }
  EXPECT_LT(most, 1.25 * least);
}

TEST(EnvironmentSampler, EstimatesTheLightOfSunAndSky) {
  const Vec3 to_sun = normalize(Vec3{0.4, 0.6, -0.3});
  const Background background = daylight(to_sun);
  Background sky_alone = background;
  sky_alone.has_sun_disc = false;
  const Vec3 up{0, 1, 0};
  // The sun is so small that it is the same from all of it.
  const double truth = irradiance(sky_alone, up) +
                       background.daylight->sun_at_center().g * to_sun.y / Sky::sun_density();
  const Estimate found = estimate(background, up);
  EXPECT_NEAR(found.mean, truth, 4.5 * found.error + 0.003 * truth);
  // Most of it is the sun's, and the densest choice is the sun.
  EXPECT_LT(found.error, 0.005 * truth);
}

/// By how many deviations the chi-square of 200,000 directions, over 24 x 48 cells of equal solid
/// angle about +z, is too large for the densities that the sampler tells; `total` becomes their
/// integral. The sun is left out of both.
double direction_sigmas(const EnvironmentSampler& sampler, const Vec3& to_sun, double& total) {
  constexpr int kRows = 24, kColumns = 48, kFine = 32, kCount = 200000;
  const auto is_sun = [&](const Vec3& d) { return dot(d, to_sun) > 0.9999; };
  std::vector<double> expected(kRows * kColumns + 1), found(expected.size());
  total = 0;
  for (int row = 0; row < kRows * kFine; ++row) {
    const double z = 1 - 2 * (row + 0.5) / (kRows * kFine), r = std::sqrt(1 - z * z);
    for (int column = 0; column < kColumns * kFine; ++column) {
      const double phi = 2 * std::numbers::pi * (column + 0.5) / (kColumns * kFine);
      const Vec3 d{r * std::cos(phi), r * std::sin(phi), z};
      if (is_sun(d)) continue;
      const double share =
          sampler.density(d) * 4 * std::numbers::pi / (kRows * kColumns * kFine * kFine);
      const int cell = row / kFine * kColumns + column / kFine;
      expected[static_cast<size_t>(cell)] += share * kCount;
      total += share;
    }
  }
  expected.back() = std::max(0.0, 1 - total) * kCount;
  UniformNumbers random(28);
  for (int i = 0; i < kCount; ++i) {
    const double x = random(), y = random();
    const Vec3 d = sampler.sample({x, y}).wi;
    const double turn = std::atan2(d.y, d.x) / (2 * std::numbers::pi);
    const int row = std::clamp(static_cast<int>((1 - d.z) / 2 * kRows), 0, kRows - 1);
    const int column =
        std::clamp(static_cast<int>((turn < 0 ? turn + 1 : turn) * kColumns), 0, kColumns - 1);
    ++found[is_sun(d) ? found.size() - 1 : static_cast<size_t>(row * kColumns + column)];
  }
  return chi_square_sigmas(found, expected);
}

TEST(EnvironmentSampler,
     DirectionsFollowTheDensityThatItTells) {  // N28; an alarm in 300,000 a case
  double total = 0;
  EXPECT_LT(direction_sigmas(*make_environment_sampler(panorama()), {}, total), kChiSquareAlarm);
  EXPECT_NEAR(total, 1, 1e-3);
  for (const BackgroundKind kind :
       {BackgroundKind::panorama_equirectangular, BackgroundKind::panorama_equal_area}) {
    EXPECT_LT(direction_sigmas(*make_environment_sampler(speckles(kind)), {}, total),
              kChiSquareAlarm);
    EXPECT_NEAR(total, 1, 1e-3);
  }
  for (const Background& background : {cube(), daylight({1, -0.1, 0.3})}) {
    EXPECT_LT(direction_sigmas(*make_environment_sampler(background), {}, total), kChiSquareAlarm);
    EXPECT_NEAR(total, 1, 1e-3);
  }
  const Vec3 to_sun = normalize(Vec3{0.4, 0.6, -0.3});
  const auto with_sun = make_environment_sampler(daylight(to_sun));
  EXPECT_LT(direction_sigmas(*with_sun, to_sun, total), kChiSquareAlarm);
  // The sun has the rest, spread over its disc.
  EXPECT_NEAR(total + with_sun->density(to_sun) / Sky::sun_density(), 1, 1e-3);
}

TEST(Sky, SunIsFilledEvenly) {  // N28
  const Vec3 to_sun = normalize(Vec3{0.4, 0.6, -0.3});
  const Sky sky(to_sun, 3, 1, kBlack);
  constexpr int kCells = 16, kCount = 50000;
  const double one_minus_cosine = 1 / (2 * std::numbers::pi * Sky::sun_density());
  std::vector<double> found(kCells * kCells + 1), expected(found.size());
  std::fill(expected.begin(), expected.end() - 1, double{kCount} / (kCells * kCells));
  UniformNumbers random(28);
  const Frame frame(to_sun);
  for (int i = 0; i < kCount; ++i) {
    const double x = random(), y = random();
    const Vec3 d = sky.sample_sun({x, y}), local = frame.to_local(d);
    EXPECT_TRUE(sky.is_sun(d));
    const double out = (local.x * local.x + local.y * local.y) / (1 + local.z) / one_minus_cosine;
    const double turn = std::atan2(local.y, local.x) / (2 * std::numbers::pi);
    const int row = std::clamp(static_cast<int>(out * kCells), 0, kCells);
    const int column =
        std::clamp(static_cast<int>((turn < 0 ? turn + 1 : turn) * kCells), 0, kCells - 1);
    ++found[row == kCells ? found.size() - 1 : static_cast<size_t>(row * kCells + column)];
  }
  EXPECT_LT(chi_square_sigmas(found, expected), kChiSquareAlarm);
}

TEST(EnvironmentSampler, IsNotMadeForSmoothColours) {
  Background background;
  background.kind = BackgroundKind::gradient_linear;
  background.sky = kWhite;
  EXPECT_EQ(make_environment_sampler(background), nullptr);
  EXPECT_EQ(make_environment_sampler(panorama_of([](uint32_t) { return 0.7; })), nullptr);
}

TEST(Sky, IsBlueAboveAndWarmAtSunset) {
  const Sky noon(normalize(Vec3{0.3, 1, 0}), 3, 1, kBlack);
  const Color zenith = noon.radiance({0, 1, 0});
  EXPECT_GT(zenith.b, 1.5 * zenith.r);
  EXPECT_TRUE(noon.has_sun());
  EXPECT_GT(noon.sun_at_center().b, 0.6 * noon.sun_at_center().r);
  const Sky evening(normalize(Vec3{1, 0.05, 0}), 3, 1, kBlack);
  EXPECT_LT(evening.sun_at_center().b, 0.2 * evening.sun_at_center().r);
  EXPECT_FALSE(Sky(normalize(Vec3{1, -0.1, 0}), 3, 1, kBlack).has_sun());
  // Doubling the intensity doubles all of it.
  const Sky twice(normalize(Vec3{0.3, 1, 0}), 3, 2, kWhite);
  EXPECT_NEAR(twice.radiance({0, 1, 0}).g, 2 * zenith.g, 1e-12);
}

}  // namespace
}  // namespace tessera
