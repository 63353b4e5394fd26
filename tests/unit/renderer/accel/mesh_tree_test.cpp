#include "renderer/accel/mesh_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "renderer/accel/bvh.h"
#include "renderer/accel/linear_scan.h"
#include "renderer/accel/make_accelerator.h"

namespace tessera {
namespace {

/// A sheet of hills of side x side cells.
TriangleMesh hills(uint32_t side) {
  TriangleMesh mesh;
  for (uint32_t y = 0; y <= side; ++y) {
    for (uint32_t x = 0; x <= side; ++x) {
      const auto height = static_cast<float>(x * x % 7 + y * y % 5) / 8;
      mesh.positions.push_back({static_cast<float>(x), height, static_cast<float>(y)});
    }
  }
  for (uint32_t y = 0; y < side; ++y) {
    for (uint32_t x = 0; x < side; ++x) {
      const uint32_t a = y * (side + 1) + x, b = a + side + 1;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({a + 1, b, b + 1});
    }
  }
  return mesh;
}

bool same_units(const MeshTree& a, const MeshTree& b) {
  return a.tree.units.size() == b.tree.units.size() &&
         std::memcmp(a.tree.units.data(), b.tree.units.data(), a.tree.units.bytes()) == 0;
}

/// Enough for all threads to work on one node, in no order that is of use.
TriangleMesh many_triangles() {
  TriangleMesh mesh = hills(420);
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), std::mt19937(7));
  return mesh;
}

TEST(MeshTree, IsTheSameForAnyNumberOfThreads) {
  const TriangleMesh mesh = many_triangles();
  const BuiltMeshTree one = build_mesh_tree(mesh, 1, BvhQuality::standard);
  for (const int threads : {2, 3, 7}) {
    const BuiltMeshTree built = build_mesh_tree(mesh, threads, BvhQuality::standard);
    EXPECT_TRUE(same_units(one.tree, built.tree)) << threads;
    EXPECT_EQ(one.statistics.leaves, built.statistics.leaves);
    EXPECT_EQ(one.statistics.depth, built.statistics.depth);
  }
}

TEST(MeshTree, OfManyTrianglesHoldsEach) {
  const TriangleMesh mesh = many_triangles();
  const MeshBvh bvh(build_mesh_tree(mesh, 3, BvhQuality::standard));
  for (uint32_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
    const auto [a, b, c] = mesh.corners(triangle);
    const Vec3 middle = ((a - Point3{}) + (b - Point3{}) + (c - Point3{})) / 3.0;
    Hit hit;
    TraversalCounters counters;
    ASSERT_TRUE(bvh.closest_hit({{middle.x, 50, middle.z}, {0, -1, 0}}, hit, counters)) << triangle;
    ASSERT_EQ(hit.primitive, triangle);
  }
}

TEST(SharedMeshTree, IsTheTreeThatEachWouldBuild) {
  const TriangleMesh mesh = hills(60);
  const OwnedDescriptor memory = SharedArena::create();
  const SharedArena arena(memory.get());
  const SharedTree shared{{.arena = &arena}, Digest::of("hills")};
  const BuiltMeshTree own = build_mesh_tree(mesh, 1, BvhQuality::standard);
  const BuiltMeshTree first = shared_mesh_tree(mesh, 1, BvhQuality::standard, shared);
  const SharedArena::Claim claim = arena.claim(shared.key);
  ASSERT_TRUE(claim.size());
  EXPECT_GT(*claim.size(), own.statistics.bytes);
  const BuiltMeshTree second = shared_mesh_tree(mesh, 1, BvhQuality::standard, shared);
  EXPECT_TRUE(same_units(own.tree, first.tree));
  EXPECT_TRUE(same_units(own.tree, second.tree));
  EXPECT_EQ(second.statistics.primitives, mesh.triangles.size());
  EXPECT_EQ(second.statistics.build_seconds, first.statistics.build_seconds);

  // All beside the array too: it answers as a scan does.
  const MeshBvh bvh(shared_mesh_tree(mesh, 1, BvhQuality::standard, shared));
  const MeshLinearScan scan(std::make_shared<TriangleMesh>(mesh));
  EXPECT_EQ(bvh.bounds().min, scan.bounds().min);
  EXPECT_EQ(bvh.bounds().max, scan.bounds().max);
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    Ray ray{{i * 0.119, 9, 60 - i * 0.119}, {0.01 * (i % 11), -1, 0.02 * (i % 7)}};
    Hit a, b;
    TraversalCounters counters;
    const bool hit = bvh.closest_hit(ray, a, counters);
    ASSERT_EQ(hit, scan.closest_hit(ray, b, counters)) << i;
    EXPECT_EQ(a, b) << i;
    hits += hit ? 1 : 0;
  }
  EXPECT_GT(hits, 400);
}

TEST(SharedMeshTree, IsBuiltOnceAsLongAsSomebodyHasIt) {
  const auto mesh = std::make_shared<const TriangleMesh>(hills(60));
  WeakCache live;
  const SharedTree shared{{.live = &live}, Digest::of("hills")};
  const auto make = [&](const SharedTree& as) {
    return shared_mesh_accelerator(mesh, AcceleratorKind::bvh, 1, as);
  };
  auto first = make(shared), second = make(shared);
  EXPECT_EQ(first, second);
  EXPECT_NE(first, make({{.live = &live}, Digest::of("valleys")}));
  EXPECT_NE(first, make({}));
  const std::weak_ptr<const Accelerator> gone = first;
  first.reset();
  EXPECT_EQ(live.find<Accelerator>(shared.key), second);
  second.reset();
  EXPECT_TRUE(gone.expired());
  EXPECT_EQ(live.find<Accelerator>(shared.key), nullptr);
  EXPECT_NE(make(shared), nullptr);
}

TEST(SharedMeshTree, SmallOnesAreBuiltByEach) {
  const OwnedDescriptor memory = SharedArena::create();
  const SharedArena arena(memory.get());
  const SharedTree shared{{.arena = &arena}, Digest::of("few")};
  shared_mesh_tree(hills(10), 1, BvhQuality::standard, shared);
  EXPECT_FALSE(arena.claim(shared.key).size());
}

}  // namespace
}  // namespace tessera
