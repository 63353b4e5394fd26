#include "renderer/accel/split_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace tessera {
namespace {

AxisStretch random_axis(std::mt19937& random, size_t objects) {
  std::uniform_real_distribution<float> unit(0, 1);
  AxisStretch axis;
  axis.low = -1;
  axis.high = 3;
  const bool whole = random() % 2 == 0;  // many equal ends
  for (size_t i = 0; i < objects; ++i) {
    float low = -1 + 4 * unit(random), high = low + 0.5f * unit(random) * unit(random);
    if (whole) low = std::floor(low * 4) / 4, high = low + 0.25f * static_cast<float>(random() % 2);
    axis.lows.push_back(std::max(low, axis.low));
    axis.highs.push_back(std::min(high, axis.high));
  }
  axis.search_low = -0.5f + unit(random);
  axis.search_high = axis.search_low + 1.5f * unit(random);
  return axis;
}

std::array<AxisStretch, 3> random_axes(std::mt19937& random, size_t objects) {
  return {random_axis(random, objects), random_axis(random, objects), random_axis(random, objects)};
}

TEST(AxisStretch, CostCountsObjectsByWidth) {
  AxisStretch axis;
  axis.low = 0;
  axis.high = 4;
  axis.lows = {0, 1, 2};
  axis.highs = {1, 3, 4};
  // One ends at the split and counts on its low side alone; one begins and one ends beyond it.
  EXPECT_DOUBLE_EQ(axis.cost(1), 0.25 * 1 + 0.75 * 2);
  EXPECT_DOUBLE_EQ(axis.cost(2), 0.5 * 2 + 0.5 * 2);
  EXPECT_DOUBLE_EQ(axis.cost(3), 0.75 * 3 + 0.25 * 1);
}

TEST(SweepSearch, NoPlaceIsCheaper) {
  std::mt19937 random(1);
  const SweepSearch search;
  for (int trial = 0; trial < 200; ++trial) {
    const auto axes = random_axes(random, 1 + random() % 60);
    const auto split = search.find(axes);
    for (size_t a = 0; a < 3; ++a) {
      const AxisStretch& axis = axes[a];
      EXPECT_GE(split[a], axis.search_low);
      EXPECT_LE(split[a], axis.search_high);
      const double least = axis.cost(split[a]);
      for (int i = 0; i <= 1000; ++i) {
        const float at =
            std::min(axis.search_high, axis.search_low + (axis.search_high - axis.search_low) *
                                                             static_cast<float>(i) / 1000);
        EXPECT_LE(least, axis.cost(at) * (1 + 1e-12));
      }
      for (const auto* ends : {&axis.lows, &axis.highs}) {
        for (const float at : *ends) {
          if (at < axis.search_low || at > axis.search_high) continue;
          EXPECT_LE(least, axis.cost(at) * (1 + 1e-12));
        }
      }
    }
  }
}

TEST(SweepSearch, ManyObjectsAreSampledNearlyAsWell) {
  std::mt19937 random(2);
  const SweepSearch search;
  for (int trial = 0; trial < 10; ++trial) {
    const auto axes = random_axes(random, SweepSearch::kExactObjects + 500);
    const auto split = search.find(axes);
    for (size_t a = 0; a < 3; ++a) {
      const AxisStretch& axis = axes[a];
      EXPECT_GE(split[a], axis.search_low);
      EXPECT_LE(split[a], axis.search_high);
      double least = axis.cost(axis.search_low);
      for (const auto* ends : {&axis.lows, &axis.highs})
        for (const float at : *ends)
          if (at >= axis.search_low && at <= axis.search_high)
            least = std::min(least, axis.cost(at));
      // With ends on whole quarters the best place may lie between two samples.
      EXPECT_LE(axis.cost(split[a]), least * 1.25);
    }
  }
}

TEST(NloptSearch, StaysInsideRepeatsItselfAndIsNeverBelowTheMinimum) {
  std::mt19937 random(3);
  const auto nlopt = make_nlopt_search();
  const SweepSearch sweep;
  double nlopt_sum = 0, sweep_sum = 0, centre_sum = 0;
  for (int trial = 0; trial < 100; ++trial) {
    auto axes = random_axes(random, 20 + random() % 100);
    if (trial % 4 == 0) axes[1].search_high = axes[1].search_low;  // an axis without a choice
    const auto split = nlopt->find(axes), again = nlopt->find(axes), best = sweep.find(axes);
    EXPECT_EQ(split, again);
    double f = 1, f_best = 1, f_centre = 1;
    for (size_t a = 0; a < 3; ++a) {
      EXPECT_GE(split[a], axes[a].search_low);
      EXPECT_LE(split[a], axes[a].search_high);
      f *= axes[a].cost(split[a]);
      f_best *= axes[a].cost(best[a]);
      f_centre *= axes[a].cost((axes[a].search_low + axes[a].search_high) / 2);
    }
    EXPECT_GE(f, f_best * (1 - 1e-12));
    nlopt_sum += f / f_best;
    centre_sum += f_centre / f_best;
    sweep_sum += 1;
  }
  EXPECT_LT(nlopt_sum, centre_sum);  // it does search
  EXPECT_LT(nlopt_sum, 1.5 * sweep_sum);
}

}  // namespace
}  // namespace tessera
