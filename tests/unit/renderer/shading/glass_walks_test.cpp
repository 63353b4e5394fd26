#include "renderer/shading/glass_walks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "renderer/shading/bsdf.h"
#include "renderer/shading/glass_albedo.h"
#include "tests/smith_walk.h"

namespace tessera {
namespace {

/// The shares of even light that samples send back and through.
GlassShares shares_of(const Material& material, bool from_inside, double cosine) {
  const Vec3 wo{std::sqrt(1 - cosine * cosine), 0, cosine};
  const Bsdf bsdf({material, kWhite, {0, 0, 1}, {0, 0, 1}, wo, from_inside});
  constexpr int kSide = 256;
  GlassShares sum;
  BsdfSample sample;
  double choice = 0.5;
  for (int i = 0; i < kSide * kSide; ++i) {
    choice = std::fmod(choice + 0.6180339887498949, 1.0);
    const int column = i % kSide, row = i / kSide;
    if (!bsdf.sample(choice, {(column + 0.5) / kSide, (row + 0.5) / kSide}, sample)) continue;
    const double share = sample.weight.g / sample.radiance_scale / (kSide * kSide);
    (sample.is_transmitted ? sum.through : sum.back) += share;
  }
  return sum;
}

TEST(Ggx, FewerFacetsAreSeenFromEitherSideTheLessSteepItIs) {
  const Ggx ggx(0.5);
  const auto towards = [](double z) { return Vec3{std::sqrt(1 - z * z), 0, z}; };
  const Vec3 wo = towards(0.4);
  EXPECT_NEAR(ggx.shadowing_through({0, 0, -1}, {0, 0, 1}), 1, 1e-9);
  double before = ggx.shadowing_through({0, 0, -1}, wo);
  EXPECT_NEAR(before, ggx.masking(wo), 1e-9);
  for (const double z : {0.5, 0.1, 1e-3, 1e-6, 1e-12, 1e-30, 1e-200, 0.0}) {
    const double seen = ggx.shadowing_through(towards(-z), wo);
    EXPECT_EQ(seen, ggx.shadowing_through(wo, towards(-z)));
    EXPECT_LE(seen, before) << z;
    EXPECT_GE(seen, 0) << z;
    before = seen;
  }
  EXPECT_LT(before, 1e-6);
}

TEST(GlassWalks, SayWhatRandomWalksSay) {
  for (const double index : {1.15, 1.33, 1.6}) {
    const GlassAlbedo albedo(index);
    Material material;
    material.model = MaterialModel::dielectric;
    material.transparency = 1;
    material.refractive_index = index;
    material.glass_albedo = &albedo;
    for (const double roughness : {0.4, 0.9}) {
      material.roughness = roughness;
      for (const bool from_inside : {false, true}) {
        SmithWalk walk(from_inside ? 1 / index : index, roughness * roughness, 7);
        for (const double degrees : {0.0, 35.0, 65.0}) {
          SCOPED_TRACE(std::to_string(index) + (from_inside ? " inside, " : " outside, ") +
                       std::to_string(roughness) + " at " + std::to_string(degrees));
          const double cosine = std::cos(degrees * std::numbers::pi / 180);
          constexpr int kWalks = 200'000;
          const GlassShares expected = walk.shares(cosine, kWalks);
          const GlassShares found = shares_of(material, from_inside, cosine);
          const double back = expected.back_at_once + expected.back, through = 1 - back;
          const double noise = std::sqrt(back * through / kWalks);
          // The tables are off by a thousandth between their steps.
          const double within = 4 * noise + 0.001 + 0.02 * std::min(back, through);
          EXPECT_NEAR(found.back, back, within);
          EXPECT_NEAR(found.through, through, within + 0.003);
        }
      }
    }
  }
}

}  // namespace
}  // namespace tessera
