#include "bench/error/reference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/metrics/made_pictures.h"

namespace tessera {
namespace {

using testing::constant;
using testing::noise;

TEST(ErrorMetrics, TheReferencesNoiseCancels) {
  const Reference reference{noise(64, 64, 1, .5, .4), noise(64, 64, 2, .5, .4)};
  const Picture picture = noise(64, 64, 3, .5, .4);
  const double variance = .4 * .4 / 12;
  EXPECT_NEAR(mean_square_error(picture, reference), variance, .05 * variance);
  EXPECT_NEAR(reference.error(), std::sqrt(variance / 2), .03 * std::sqrt(variance / 2));
  EXPECT_NEAR(picture_error(picture, reference.mean(), {}, false).mse, 1.5 * variance,
              .05 * variance);
}

TEST(BiasEstimate, FindsAPlantedBiasAndNoOther) {
  const Reference truth{noise(48, 48, 1, .5, .02), noise(48, 48, 2, .5, .02)};
  for (const double planted : {0., .008, .02}) {
    BiasEstimator estimator(truth);
    for (uint64_t seed = 10; seed < 26; ++seed)
      estimator.add(noise(48, 48, seed, .5 + planted, .3));
    const auto found = estimator.result();
    EXPECT_NEAR(found.variance, .09 / 12, .03 * .09 / 12);
    if (planted > 0) {
      EXPECT_NEAR(found.bias, planted, .002) << planted;
    } else {
      EXPECT_LT(std::abs(found.sigmas), 4) << "false alarm in 1 of 16,000";
    }
    if (planted == .02) {
      EXPECT_GT(found.sigmas, 20);
    }
  }
}

TEST(BiasEstimate, SaysNothingBeforeItHasTwo) {
  BiasEstimator estimator({constant(2, 2, 0, 0, 0), constant(2, 2, 0, 0, 0)});
  estimator.add(constant(2, 2, 1, 1, 1));
  EXPECT_EQ(estimator.result().bias, 0);
  estimator.add(constant(2, 2, 1, 1, 1));
  EXPECT_EQ(estimator.result().bias, 1);
}

}  // namespace
}  // namespace tessera
