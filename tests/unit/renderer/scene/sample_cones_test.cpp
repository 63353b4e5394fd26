#include "renderer/scene/sample_cones.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tessera {
namespace {

constexpr Camera::PixelCone kPixel{2, 3};

/// How many samples the sample of this number is filtered for.
double count_of(const SampleCones& cones, uint32_t sample) {
  const Camera::PixelCone cone = cones.of(sample);
  const double share = cone.at_eye / kPixel.at_eye;
  EXPECT_EQ(cone.spread, kPixel.spread * share);
  return 1 / (share * share);
}

TEST(SampleCones, of_a_known_number_of_samples_are_alike) {
  for (const uint32_t samples : {1u, 2u, 9u, 37u}) {
    const SampleCones cones(kPixel, samples);
    for (const uint32_t sample : {0u, 1u, 5u, samples - 1}) {
      EXPECT_DOUBLE_EQ(count_of(cones, sample), samples);
    }
  }
  EXPECT_DOUBLE_EQ(count_of(SampleCones(kPixel, 1000), 999), 64) << "no less than an eighth";
}

TEST(SampleCones, of_an_unknown_number_are_for_twice_the_samples_so_far) {
  const SampleCones cones(kPixel, 4, 50);
  for (uint32_t sample = 0; sample < 50; ++sample) {
    const double expected = sample < 4 ? 8 : sample < 8 ? 16 : sample < 16 ? 32 : 50;
    EXPECT_NEAR(count_of(cones, sample), expected, 1e-9) << sample;
  }
  EXPECT_DOUBLE_EQ(count_of(SampleCones(kPixel, 16, 3), 2), 3);
}

}  // namespace
}  // namespace tessera
