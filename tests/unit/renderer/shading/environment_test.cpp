#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "renderer/shading/environment_sampler.h"
#include "renderer/shading/sky.h"

namespace tessera {
namespace {

constexpr double kPi = std::numbers::pi;

Background daylight(const Vec3& to_sun) {
  Background background;
  background.kind = BackgroundKind::sun_and_sky;
  background.daylight = std::make_shared<Sky>(normalize(to_sun), 3, 1, Color{0.2, 0.2, 0.2});
  return background;
}

/// Half of the picture bright, and one texel of it very bright.
Background panorama() {
  constexpr uint32_t kWidth = 64, kHeight = 32;
  auto texels = std::shared_ptr<float[]>(new float[kWidth * kHeight * 3]);
  for (uint32_t i = 0; i < kWidth * kHeight; ++i) {
    const float value = i == 700 ? 500.0f : i % kWidth < kWidth / 2 ? 1.0f : 0.01f;
    for (int c = 0; c < 3; ++c) texels[3 * i + c] = value;
  }
  ImageTextureSettings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  settings.bits = 32;
  settings.filter = ImageTextureSettings::Filter::nearest;
  Background background;
  background.kind = BackgroundKind::panorama_equirectangular;
  background.picture = std::make_shared<ImageTexture>(
      settings,
      std::shared_ptr<const std::byte>(texels, reinterpret_cast<const std::byte*>(texels.get())));
  return background;
}

/// Irradiance on a surface that faces `n`, by the rule of mid-points over all directions.
double irradiance(const Background& background, const Vec3& n) {
  constexpr int kSide = 1200;
  double sum = 0;
  for (int i = 0; i < kSide; ++i) {
    const double z = 2 * (i + 0.5) / kSide - 1, r = std::sqrt(1 - z * z);
    for (int j = 0; j < 2 * kSide; ++j) {
      const double phi = 2 * kPi * (j + 0.5) / (2 * kSide);
      const Vec3 d{r * std::cos(phi), r * std::sin(phi), z};
      if (dot(d, n) > 0) sum += background.radiance({}, d, {}).g * dot(d, n);
    }
  }
  return sum * 4 * kPi / (2.0 * kSide * kSide);
}

struct Estimate {
  double mean, error;
};

Estimate estimate(const Background& background, const Vec3& n) {
  const auto sampler = make_environment_sampler(background);
  std::mt19937_64 engine(7);
  const auto random = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  constexpr int kCount = 200000;
  double sum = 0, squares = 0;
  for (int i = 0; i < kCount; ++i) {
    const double x = random(), y = random();
    const EnvironmentSampler::Sample sample = sampler->sample({x, y});
    double value = 0;
    if (sample.density > 0 && dot(sample.wi, n) > 0) {
      EXPECT_NEAR(sampler->density(sample.wi), sample.density, 1e-6 * sample.density);
      value = background.radiance({}, sample.wi, {}).g * dot(sample.wi, n) / sample.density;
    }
    sum += value;
    squares += value * value;
  }
  const double mean = sum / kCount;
  return {mean, std::sqrt((squares / kCount - mean * mean) / kCount)};
}

TEST(EnvironmentSampler, EstimatesTheLightOfAPanorama) {
  const Background background = panorama();
  for (const Vec3& n : {Vec3{0, 1, 0}, normalize(Vec3{-1, 0.3, 0.2})}) {
    const Estimate found = estimate(background, n);
    EXPECT_NEAR(found.mean, irradiance(background, n), 4.5 * found.error + 0.003 * found.mean);
  }
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

TEST(EnvironmentSampler, IsNotMadeForSmoothColours) {
  Background background;
  background.kind = BackgroundKind::gradient_linear;
  background.sky = kWhite;
  EXPECT_EQ(make_environment_sampler(background), nullptr);
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
