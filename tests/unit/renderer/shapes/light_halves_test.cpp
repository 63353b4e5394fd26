#include "renderer/shapes/light_halves.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "tests/uniform_numbers.h"

namespace tessera {
namespace {

TEST(LightHalves, CentersThatAreNotNumbersHaveAPlaceInTheOrder) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  const double odd[] = {nan, -nan, inf, -inf, 1e308, -1e308, 0, 1};
  UniformNumbers numbers(1);
  for (int round = 0; round < 200; ++round) {
    std::vector<Point3> centers(2 + numbers.below(200));
    for (Point3& p : centers)
      for (int a = 0; a < 3; ++a)
        p[a] = numbers.below(2) ? odd[numbers.below(8)] : numbers.between(-4, 4);
    std::vector<uint32_t> order(centers.size());
    std::iota(order.begin(), order.end(), 0u);
    halve(order, [&](uint32_t i) { return centers[i]; });
    const size_t middle = order.size() / 2;
    // On some axis all of the first half come before all of the second.
    const auto is_halved = [&](int axis) {
      const auto at = [&](uint32_t i) {
        const double x = centers[i][axis];
        return std::pair(std::isnan(x) ? 0 : x, i);
      };
      for (size_t i = 0; i < middle; ++i)
        for (size_t k = middle; k < order.size(); ++k)
          if (at(order[k]) < at(order[i])) return false;
      return true;
    };
    EXPECT_TRUE(is_halved(0) || is_halved(1) || is_halved(2)) << round;
    std::vector<uint32_t> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    for (uint32_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i);
  }
}

}  // namespace
}  // namespace tessera
