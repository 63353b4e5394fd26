#include "bench/rays.h"

#include <gtest/gtest.h>

#include <set>

#include "bench/generated_meshes.h"

namespace tessera {
namespace {

RayBenchOptions small() {
  RayBenchOptions options;
  options.accelerators = {AcceleratorKind::bvh, AcceleratorKind::bvh_splits,
                          AcceleratorKind::linear};
  options.image_side = 32;
  options.rounds = 1;
  return options;
}

TEST(RayBench, EveryAcceleratorAnswersAsTheOracleOnEveryKindOfRay) {
  const auto rows =
      bench_rays({{"outside", icosphere(3), {}},
                  {"inside", icosphere(3), BenchView{{0, 0, 1}, {0, 0, 0}, {0, 1, 0}}}},
                 small());
  std::set<std::string> kinds;
  size_t ours = 0;
  for (const RayBenchRow& row : rows) {
    kinds.insert(row.kind);
    EXPECT_GT(row.mrays_per_second, 0);
    if (row.accelerator == "embree-default") continue;
    ++ours;
    EXPECT_EQ(row.mismatches, 0u) << row.scene << row.accelerator << row.kind;
    EXPECT_GT(row.rays_checked, 100u);
    EXPECT_GT(row.primitive_tests_per_ray, 0);
  }
  EXPECT_EQ(kinds,
            (std::set<std::string>{"primary", "packets", "shadow", "diffuse", "ao", "shuffled"}));
  EXPECT_GE(ours, 3u * 11);  // a ball seen from outside has no second bounce
}

TEST(RayBench, MeansAreGeometricAndSumTheMismatches) {
  RayBenchRow a{"a", "bvh", "ao"}, b{"b", "bvh", "ao"}, other{"b", "bvh", "primary"};
  a.ratio_to_embree = 1, b.ratio_to_embree = 4, other.ratio_to_embree = 9;
  a.mismatches = 2, b.mismatches = 3;
  const auto means = geometric_means({a, b, other});
  ASSERT_EQ(means.size(), 2u);
  EXPECT_EQ(means[0].kind, "ao");
  EXPECT_DOUBLE_EQ(means[0].ratio_to_embree, 2);
  EXPECT_EQ(means[0].mismatches, 5u);
  EXPECT_DOUBLE_EQ(means[1].ratio_to_embree, 9);
}

TEST(RayBench, SubdividesToAMillion) {
  const TriangleMesh mesh = icosphere(4);  // 5,120 triangles
  EXPECT_EQ(subdivided_to_a_million(mesh).triangles.size(), 5120u * 256);
}

}  // namespace
}  // namespace tessera
