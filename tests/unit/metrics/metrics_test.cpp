#include "metrics/picture_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "metrics/difference.h"
#include "metrics/flip.h"
#include "metrics/ssim.h"
#include "metrics/vector_math.h"
#include "metrics/weighted_sum.h"
#include "tests/unit/metrics/made_pictures.h"

namespace tessera {
namespace {

using testing::constant;
using testing::noise;

TEST(ErrorMetrics, AreTheHandWorkedNumbers) {
  // Differences .1, 0, 0 from .1, .2, .3 and 0, -.2, 0 from .1, .4, 0.
  const Picture reference{2, 1, {.1F, .2F, .3F, .1F, .4F, 0}};
  const Picture picture{2, 1, {.2F, .2F, .3F, .1F, .2F, 0}};
  const PictureError e = picture_error(picture, reference);
  EXPECT_NEAR(e.mse, (.01 + .04) / 6, 1e-8);
  EXPECT_NEAR(e.rmse, std::sqrt(.05 / 6), 1e-7);
  EXPECT_NEAR(e.rel_mse, (.01 / .02 + .04 / .17) / 6, 1e-6);
  EXPECT_NEAR(e.smape, (2 * .1 / .31 + 2 * .2 / .61) / 6, 1e-6);
  EXPECT_NEAR(e.max_error, .2, 1e-7);
  EXPECT_NEAR(e.mean_ratio, 1. / 1.1, 1e-6);
  EXPECT_EQ(e.not_finite, 0u);
  EXPECT_NEAR(picture_error(picture, reference, {0, 1}).mse, .04 / 3, 1e-8);
}

TEST(ErrorMetrics, TrimmingTakesTheLargestThousandthOnly) {
  const Picture reference = constant(20, 50, 1, 1, 1);  // 3,000 values: 3 are trimmed
  Picture picture = constant(20, 50, 1.5F, 1, 1);
  for (const size_t i : {1u, 301u, 901u}) picture.values[i] = 101;
  const PictureError e = picture_error(picture, reference, {}, false);
  EXPECT_NEAR(e.rel_mse, (1000 * .25 / 1.01 + 3 * 1e4 / 1.01) / 3000, 1e-4);
  EXPECT_NEAR(e.trimmed_rel_mse, 1000 * .25 / 1.01 / 2997, 1e-8);
  EXPECT_EQ(e.max_error, 100);
  EXPECT_EQ(e.error_99_9, .5);
}

TEST(ErrorMetrics, WeightedSumsHaveTheBitsOfPlainLoops) {
  const Picture values = noise(40, 40, 9, .5, 1);
  const std::vector<float> weights{.1F, .7F, -.3F, .25F, 1e-3F};
  for (size_t count = 0; count < 200; ++count) {
    std::vector<const float*> rows;
    for (size_t k = 0; k < weights.size(); ++k) rows.push_back(&values.values[300 * k + k]);
    std::vector<float> sums(count), expected(count);
    weighted_sum(sums.data(), count, weights, rows);
    for (size_t x = 0; x < count; ++x)
      for (size_t k = 0; k < weights.size(); ++k) expected[x] += weights[k] * rows[k][x];
    ASSERT_EQ(sums, expected) << count;
  }
}

TEST(ErrorMetrics, SimilarityOfFlatPicturesIsThatOfTheirMeans) {
  const auto shown = [](double linear) { return 1.055 * std::pow(linear, 1 / 2.4) - .055; };
  const double a = shown(.5), b = shown(.25), c1 = .01 * .01;
  for (const int size : {1, 2, 11, 30}) {
    const Picture bright = constant(size, 12, .5F, .5F, .5F);
    const Picture dark = constant(size, 12, .25F, .25F, .25F);
    EXPECT_NEAR(mean_ssim(bright, dark), (2 * a * b + c1) / (a * a + b * b + c1), 1e-9) << size;
    EXPECT_NEAR(mean_ssim(dark, dark), 1, 1e-12);
  }
  const Picture first = noise(20, 15, 1, .5, 1), second = noise(20, 15, 2, .5, 1);
  EXPECT_LT(mean_ssim(first, second), .3);
  EXPECT_EQ(mean_ssim(first, second), mean_ssim(second, first));
}

TEST(ErrorMetrics, DifferencesHaveTheirPlace) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> a{0, 0, 1, nan, 0, 2},
      b{0, 0, .5F, nan, 0, 3};  // 3 pixels of 2 channels
  const Difference d = difference_of(a, b, 2, 3, .75);
  EXPECT_EQ(d.greatest, 1);
  EXPECT_EQ(d.mean, .25);
  EXPECT_EQ(d.greatest_of, (std::vector<double>{.5, 1}));
  EXPECT_EQ(d.worst_pixel, 2u);
  EXPECT_EQ(d.pixels_unequal, 2u);
  EXPECT_EQ(d.pixels_beyond, 1u);
  EXPECT_EQ((std::vector<int>{d.x0, d.y0, d.x1, d.y1}), (std::vector<int>{1, 0, 3, 1}));
}

TEST(ErrorMetrics, DifferencesOfTallPicturesAreThoseOfTheirParts) {
  constexpr size_t kWidth = 3, kHeight = 200;
  std::vector<float> a(kWidth * kHeight), b = a;
  b[1 * kWidth + 2] = 1;
  b[70 * kWidth + 1] = 4;
  b[140 * kWidth + 1] = 4;
  b[199 * kWidth + 1] = 2;
  const Difference d = difference_of(a, b, 1, kWidth, 1);
  EXPECT_EQ(d.greatest, 4);
  EXPECT_EQ(d.worst_pixel, 70 * kWidth + 1) << "the first of two";
  EXPECT_EQ(d.mean, 11. / (kWidth * kHeight));
  EXPECT_EQ(d.rmse, std::sqrt(37. / (kWidth * kHeight)));
  EXPECT_EQ(d.greatest_of, std::vector<double>{4});
  EXPECT_EQ(d.pixels_unequal, 4u);
  EXPECT_EQ(d.pixels_beyond, 3u);
  EXPECT_EQ((std::vector<int>{d.x0, d.y0, d.x1, d.y1}), (std::vector<int>{1, 1, 3, 200}));
}

TEST(ErrorMetrics, WhatIsNoNumberCountsAsBlackAndIsCounted) {
  Picture picture = constant(2, 2, .5F, .5F, .5F);
  picture.values[4] = std::numeric_limits<float>::quiet_NaN();
  picture.values[7] = std::numeric_limits<float>::infinity();
  const PictureError e = picture_error(picture, constant(2, 2, .5F, .5F, .5F));
  EXPECT_EQ(e.not_finite, 2u);
  EXPECT_NEAR(e.mse, 2 * .25 / 12, 1e-9);
  EXPECT_TRUE(std::isfinite(e.flip));
}

TEST(ErrorMetrics, PowersAreThoseOfTheLibrary) {
  for (const float base :
       {1e-20F, 1e-6F, .003F, .49F, .5F, .7071F, .999F, 1.F, 1.001F, 50.F, 1000.F}) {
    EXPECT_NEAR(cube_root(base) / std::cbrt(base), 1, 3e-7) << base;
    for (const float exponent : {0.F, 1e-3F, .3F, .7F, 1.F}) {
      EXPECT_NEAR(power(base, exponent) / std::pow(base, exponent), 1, 2e-6)
          << base << " " << exponent;
    }
  }
  EXPECT_EQ(power(0, 0), 1);
  EXPECT_EQ(power(0, .01F), 0);
  EXPECT_EQ(power(1, .7F), 1);
}

TEST(Flip, IsNothingForEqualPicturesAndAllForBlackAgainstWhite) {
  const Picture picture = noise(40, 30, 1, .5, 1);
  for (const float error : flip_map(picture, picture)) EXPECT_EQ(error, 0);
  // A uniform pair has no features: the colour error alone. Black and white are 100 of L* apart,
  // whereas 41.3 of them are the .4 of the range from green to blue where .95 is reached.
  const double white = mean_flip(constant(8, 8, 0, 0, 0), constant(8, 8, 1, 1, 1));
  EXPECT_NEAR(white, .9674, .0005);
  // The farthest pair of colours: by definition all there is.
  EXPECT_NEAR(mean_flip(constant(8, 8, 0, 1, 0), constant(8, 8, 0, 0, 1)), 1, 1e-6);
}

TEST(Flip, IsSymmetricInsideTheUnitIntervalAndClampsFirst) {
  const Picture a = noise(40, 30, 1, .5, 2), b = noise(40, 30, 2, .4, 1);
  const auto forth = flip_map(a, b), back = flip_map(b, a);
  for (size_t i = 0; i < forth.size(); ++i) {
    EXPECT_EQ(forth[i], back[i]);
    EXPECT_GE(forth[i], 0);
    EXPECT_LE(forth[i], 1);
  }
  EXPECT_EQ(mean_flip(constant(8, 8, 1, 1, 1), constant(8, 8, 7, 9, 1.5F)), 0);
}

TEST(Flip, FinePatternsAreSeenLessFromAfar) {
  Picture stripes{64, 64, {}};
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      stripes.values.insert(stripes.values.end(), 3, .5F + (x % 2 == 0 ? .05F : -.05F));
  const Picture grey = constant(64, 64, .5F, .5F, .5F);
  EXPECT_LT(mean_flip(stripes, grey, {}, 100), mean_flip(stripes, grey, {}, 20));
}

TEST(Flip, MoreNoiseIsSeenMore) {
  const Picture truth = constant(48, 48, .4F, .5F, .3F);
  double last = 0;
  for (const double spread : {.02, .08, .3}) {
    Picture noisy = noise(48, 48, 5, 0, spread);
    for (size_t i = 0; i < noisy.values.size(); ++i) noisy.values[i] += truth.values[i];
    const double flip = mean_flip(noisy, truth);
    EXPECT_GT(flip, last);
    last = flip;
  }
}

}  // namespace
}  // namespace tessera
