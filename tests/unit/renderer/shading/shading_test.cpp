#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "renderer/shading/background.h"
#include "renderer/shading/light.h"
#include "renderer/shading/material.h"

namespace tessera {
namespace {

constexpr double kRadiansOfDegree = std::numbers::pi / 180;

TEST(Fresnel, of_glass) {
  EXPECT_NEAR(fresnel_dielectric(1, 1.5), 0.04, 1e-15);
  EXPECT_NEAR(fresnel_dielectric(1, 1 / 1.5), 0.04, 1e-15);
  EXPECT_EQ(fresnel_dielectric(0, 1.5), 1);
  EXPECT_NEAR(fresnel_dielectric(0.3, 1), 0, 1e-30);
  // At Brewster's angle the parallel part is gone: what is left is half of the other.
  const double brewster = 56.3099324740202 * kRadiansOfDegree;
  EXPECT_NEAR(brewster, std::atan(1.5), 1e-12);
  const double perpendicular = (std::cos(brewster) - 1.5 * std::sin(brewster)) /
                               (std::cos(brewster) + 1.5 * std::sin(brewster));
  EXPECT_NEAR(fresnel_dielectric(std::cos(brewster), 1.5), perpendicular * perpendicular / 2,
              1e-15);
}

TEST(Fresnel, total_reflection_beyond_the_critical_angle) {
  const double critical = 41.8103148957786 * kRadiansOfDegree;
  Vec3 out;
  const auto goes_out = [&](double angle) {
    return refract({std::sin(angle), 0, -std::cos(angle)}, {0, 0, 1}, 1 / 1.5, out);
  };
  EXPECT_TRUE(goes_out(critical - 1e-9));
  EXPECT_FALSE(goes_out(critical + 1e-9));
  EXPECT_EQ(fresnel_dielectric(std::cos(critical + 1e-9), 1 / 1.5), 1);
  EXPECT_LT(fresnel_dielectric(std::cos(critical - 1e-4), 1 / 1.5), 1);
}

TEST(Refraction, follows_snell) {
  for (double degrees = 0; degrees < 90; degrees += 7) {
    for (const double eta : {0.75, 1.0, 1.33, 1.5, 2.4}) {
      const double sin_i = std::sin(degrees * kRadiansOfDegree);
      Vec3 out;
      const bool refracted =
          refract({sin_i, 0, -std::cos(degrees * kRadiansOfDegree)}, {0, 0, 1}, eta, out);
      ASSERT_EQ(refracted, sin_i < eta);
      if (!refracted) continue;
      EXPECT_NEAR(out.x, sin_i / eta, 1e-14);
      EXPECT_LT(out.z, 0);
    }
  }
}

TEST(Material, shares) {
  Material m;
  const Vec3 n{0, 0, 1}, up{0, 0, 1};
  const Vec3 slanted{std::sin(60 * kRadiansOfDegree), 0, std::cos(60 * kRadiansOfDegree)};
  EXPECT_NEAR(reflected_share(m, m.diffuse, n, slanted, up).r, 0.4, 1e-15);
  EXPECT_EQ(reflected_share(m, m.diffuse, n, -up, up).r, 0);
  m.specular = kWhite;
  // A highlight of exponent 25.6 ten degrees off: x3d.md, check 3.
  const Vec3 off{std::sin(20 * kRadiansOfDegree), 0, std::cos(20 * kRadiansOfDegree)};
  EXPECT_NEAR(reflected_share(m, kBlack, n, off, up).r,
              std::pow(std::cos(10 * kRadiansOfDegree), 25.6), 1e-13);
  EXPECT_EQ(reflected_share(m, kBlack, n, -off, up).r, 0);
  m.specular_model = SpecularModel::phong;
  EXPECT_NEAR(reflected_share(m, kBlack, n, off, up).r,
              std::pow(std::cos(20 * kRadiansOfDegree), 25.6), 1e-13);
  m.shininess = 0;
  EXPECT_EQ(reflected_share(m, kBlack, n, off, up).r, 1);
}

TEST(Light, spot_factor_is_linear_in_angle) {
  EXPECT_NEAR(spot_factor(.4, .2, .6), .5, 1e-15);
  EXPECT_EQ(spot_factor(.2, .2, .6), 1);
  EXPECT_EQ(spot_factor(.6, .2, .6), 0);
  EXPECT_EQ(spot_factor(.5, .7, .6), 1);  // no soft edge where the beam is the wider
  EXPECT_EQ(spot_factor(.6, .7, .6), 0);
}

TEST(Light, spot_shortcuts_change_nothing) {
  for (const double beam : {0.0, 0.2, 0.6, 1.5, 3.0}) {
    Light plain{.kind = LightKind::spot, .beam_width = beam, .cut_off = 0.6};
    Light quick = plain;
    set_spot_cosines(quick);
    for (int i = 0; i <= 1000; ++i) {
      const double angle = i * std::numbers::pi / 1000;
      const Point3 p{std::sin(angle), 0, -std::cos(angle)};
      LightSample a, b;
      ASSERT_EQ(sample_light(plain, p, 0, a), sample_light(quick, p, 0, b)) << beam << " " << angle;
      ASSERT_EQ(a.factor, b.factor);
      ASSERT_EQ(sample_light(plain, p, 0, a), angle < 0.6) << angle;
    }
  }
}

TEST(Light, cylinder_is_a_round_beam) {
  Light light{.kind = LightKind::cylinder, .direction = {0, -1, 0}, .beam_radius = 1};
  LightSample sample;
  EXPECT_TRUE(sample_light(light, {.5, -3, .5}, 0, sample));
  EXPECT_EQ(sample.wi, (Vec3{0, 1, 0}));
  EXPECT_EQ(sample.distance, 3);
  EXPECT_FALSE(sample_light(light, {.8, -3, .8}, 0, sample));
  EXPECT_FALSE(sample_light(light, {0, 1, 0}, 0, sample));
}

TEST(Light, nothing_arrives_at_its_own_place) {
  LightSample sample;
  EXPECT_FALSE(sample_light({.kind = LightKind::point}, {0, 0, 0}, 0, sample));
}

TEST(Fog, of_x3d) {
  Fog fog{.kind = FogKind::linear, .visibility_range = 10};
  EXPECT_EQ(fog.clearness(5), .5);
  EXPECT_EQ(fog.clearness(10), 0);
  fog.kind = FogKind::exponential;
  EXPECT_NEAR(fog.clearness(5), std::exp(-1), 1e-15);
  EXPECT_EQ(fog.clearness(0), 1);
  EXPECT_EQ(Fog{}.clearness(1e300), 1);
}

TEST(Material, absorbs_by_beer_and_lambert) {
  const Color left = transmittance({0, 1, 2}, 3);
  EXPECT_EQ(left.r, 1);
  EXPECT_NEAR(left.g, std::exp(-3), 1e-16);
  EXPECT_NEAR(left.b, std::exp(-6), 1e-17);
}

}  // namespace
}  // namespace tessera
