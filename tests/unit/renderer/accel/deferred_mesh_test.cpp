// A mesh is built once, by the first ray that may hit it, whatever the number of threads.
#include "renderer/accel/deferred_mesh.h"

#include <gtest/gtest.h>

#include <random>
#include <thread>
#include <vector>

#include "bench/generated_meshes.h"
#include "renderer/accel/linear_scan.h"

namespace tessera {
namespace {

TEST(DeferredMesh, IsBuiltByTheFirstRayThatComesNear) {
  const auto built = std::make_shared<DeferredBuilds>();
  const DeferredMesh mesh(std::make_shared<TriangleMesh>(icosphere(3)), AcceleratorKind::bvh, 1,
                          built);
  TraversalCounters counters;
  Hit hit;
  EXPECT_FALSE(mesh.closest_hit({{0, 0, 9}, {1, 0, 0}}, hit, counters));
  EXPECT_FALSE(mesh.any_hit({{3, 3, 9}, {0, 0, -1}}, counters));
  EXPECT_FALSE(mesh.any_hit({{0, 9, 9}, {1, 1, 1}}, counters));
  EXPECT_EQ(built->built, 0u);
  EXPECT_EQ(mesh.statistics().nodes, 0u);
  EXPECT_EQ(mesh.bounds().max.x, icosphere(3).bounds().max.x);
  EXPECT_TRUE(mesh.any_hit({{0, 0, 9}, {0.01, 0.02, -1}}, counters));
  EXPECT_TRUE(mesh.closest_hit({{0, 0, 9}, {0.01, 0.02, -1}}, hit, counters));
  EXPECT_EQ(built->built, 1u);
  EXPECT_GT(mesh.statistics().nodes, 0u);
}

TEST(DeferredMesh, GivesTheBitsOfTheScanWhetherBuiltOrNot) {
  const auto shared = std::make_shared<const TriangleMesh>(triangle_soup(200, 4));
  const MeshLinearScan scan(shared);
  std::mt19937_64 random(9);
  std::uniform_real_distribution<> unit(-2, 3);
  size_t hits = 0;
  for (int i = 0; i < 3000; ++i) {
    const DeferredMesh mesh(shared, AcceleratorKind::bvh, 1, nullptr);
    Ray ray{{unit(random), unit(random), unit(random)},
            {unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5}};
    if (i % 2) ray.direction = shared->corners(random() % 200)[i % 3] - ray.origin;
    if (i % 16 == 5) ray.direction.y = 0;
    if (i % 200 == 7) ray.direction.x = std::nan("");
    if (i % 16 == 9) ray.origin = ray.origin - ray.direction * 1e9;
    TraversalCounters counters;
    Hit expected, hit;
    EXPECT_EQ(mesh.closest_hit(ray, hit, counters), scan.closest_hit(ray, expected, counters));
    EXPECT_EQ(hit, expected);
    EXPECT_EQ(mesh.any_hit(ray, counters), scan.any_hit(ray, counters));
    hits += std::isfinite(hit.t);
  }
  EXPECT_GT(hits, 700u);
}

TEST(DeferredMesh, TellsThatItIsBeingBuilt) {
  const auto shared = std::make_shared<const TriangleMesh>(icosphere(6));
  bool seen = false;
  for (int turn = 0; turn < 100 && !seen; ++turn) {
    const auto builds = std::make_shared<DeferredBuilds>();
    const DeferredMesh mesh(shared, AcceleratorKind::bvh, 1, builds);
    EXPECT_EQ(builds->under_way, 0);
    std::thread first([&] {
      TraversalCounters counters;
      mesh.any_hit({{0, 0, 9}, {0.01, 0.02, -1}}, counters);
    });
    while (builds->built == 0) seen |= builds->under_way == 1;
    first.join();
    EXPECT_EQ(builds->under_way, 0);
  }
  EXPECT_TRUE(seen);
}

TEST(DeferredMesh, IsBuiltOnceByManyThreads) {
  const auto built = std::make_shared<DeferredBuilds>();
  const DeferredMesh mesh(std::make_shared<TriangleMesh>(icosphere(5)), AcceleratorKind::bvh, 2,
                          built);
  std::atomic<int> hits{0};
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i) {
      threads.emplace_back([&] {
        TraversalCounters counters;
        if (mesh.any_hit({{0, 0, 9}, {0.01, 0.02, -1}}, counters)) ++hits;
      });
    }
  }
  EXPECT_EQ(hits, 8);
  EXPECT_EQ(built->built, 1u);
}

}  // namespace
}  // namespace tessera
