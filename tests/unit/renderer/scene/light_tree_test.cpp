#include "renderer/scene/light_tree.h"

#include <gtest/gtest.h>

#include <random>

namespace tessera {
namespace {

std::vector<LightTree::Light> lights(int count) {
  std::mt19937_64 engine(11);
  const auto random = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  std::vector<LightTree::Light> result;
  for (int i = 0; i < count; ++i) {
    const double x = 20 * random(), y = 20 * random(), z = 20 * random();
    const Point3 p{x, y, z};
    result.push_back({{p, p + Vec3{0.1, 0.2, 0}}, 0.1 + random()});
  }
  return result;
}

TEST(LightTree, PicksWithTheProbabilityThatItTells) {
  for (const int count : {1, 2, 3, 17, 100}) {
    const LightTree tree(lights(count));
    for (const Point3& p : {Point3{1, 2, 3}, Point3{100, 0, 0}, Point3{10, 10, 10}}) {
      const Vec3 n{0, 0.6, 0.8};
      double total = 0;
      for (uint32_t i = 0; i < static_cast<uint32_t>(count); ++i) {
        EXPECT_GT(tree.probability(p, n, i), 0);
        total += tree.probability(p, n, i);
      }
      EXPECT_NEAR(total, 1, 1e-9);
      constexpr int kSteps = 1 << 14;
      std::vector<double> share(static_cast<size_t>(count));
      for (int i = 0; i < kSteps; ++i) {
        const LightTree::Pick pick = tree.pick(p, n, (i + 0.5) / kSteps);
        ASSERT_NEAR(pick.probability, tree.probability(p, n, pick.index), 1e-12);
        share[pick.index] += 1.0 / kSteps;
      }
      // Each light is an interval of u, to within the ends of it.
      for (uint32_t i = 0; i < static_cast<uint32_t>(count); ++i) {
        EXPECT_NEAR(share[i], tree.probability(p, n, i), 1.01 / kSteps);
      }
    }
  }
}

TEST(LightTree, PrefersWhatIsNearAndBeforeThePoint) {
  const Vec3 small{0.1, 0.1, 0.1};
  const auto at = [&](double x, double power) {
    const Point3 p{x, 0, 0};
    return LightTree::Light{{p - small, p + small}, power};
  };
  const LightTree tree({at(2, 1), at(20, 1), at(-2, 1)});
  const Vec3 n{1, 0, 0};
  EXPECT_GT(tree.probability({}, n, 0), 20 * tree.probability({}, n, 1));
  EXPECT_GT(tree.probability({}, n, 0), 2 * tree.probability({}, n, 2));
  EXPECT_GT(tree.probability({}, -n, 2), 20 * tree.probability({}, -n, 0));
}

TEST(LightTree, LivesWithExtremes) {
  const Point3 far{1e300, 0, 0}, same{1, 1, 1};
  const LightTree tree({{{far, far}, 1e300}, {{same, same}, 1e-300}, {{same, same}, 1e-300}});
  for (const Point3& p : {Point3{}, same, far}) {
    double total = 0;
    for (uint32_t i = 0; i < 3; ++i) {
      EXPECT_GT(tree.probability(p, {0, 0, 1}, i), 0);
      total += tree.probability(p, {0, 0, 1}, i);
    }
    EXPECT_NEAR(total, 1, 1e-12);
  }
}

}  // namespace
}  // namespace tessera
