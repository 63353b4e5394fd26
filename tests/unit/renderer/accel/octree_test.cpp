#include "renderer/accel/octree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "base/error.h"
#include "renderer/accel/linear_scan.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"

namespace tessera {
namespace {

enum class Placing { random, lattice, flat, nested };

std::vector<BuildBox> boxes_of(Placing placing, size_t count, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<BuildBox> boxes;
  for (uint32_t i = 0; i < count; ++i) {
    Point3 at{unit(random), unit(random), unit(random)};
    Vec3 half{0.02, 0.02, 0.02};
    if (placing == Placing::lattice)
      // Boxes that end on, or have no width about, the planes that a uniform octree splits at.
      for (int a = 0; a < 3; ++a) {
        at[a] = static_cast<int>(random() % 9) / 4.0 - 1;
        half[a] = random() % 3 == 0 ? 0 : 0.125 * static_cast<double>(1 + random() % 2);
      }
    if (placing == Placing::flat) at.y = 0.25, half.y = 0;
    if (placing == Placing::nested) {
      half = Vec3{1, 1, 1} * std::ldexp(1, -static_cast<int>(i % 20));
      at = Point3{} + half;
    }
    boxes.emplace_back(Bounds3{at - half, at + half}, i);
  }
  return boxes;
}

/// Whether the boxes on some way down to a slot of number `index` all hold the point.
bool reaches(const WideTree& tree, uint32_t block_size, NodeReference at, const float (&p)[3],
             uint32_t index) {
  if (at.is_leaf()) {
    for (uint32_t b = 0; b < at.blocks(); ++b)
      for (uint32_t s = 0; s < block_size; ++s)
        if (tree.slots[(at.first_block() + b) * block_size + s] == index) return true;
    return false;
  }
  const WideNode& node = tree.nodes.data()[at.bits];
  for (int i = 0; i < 8; ++i) {
    bool inside = true;
    for (int a = 0; a < 3; ++a)
      inside &= node.bounds[2 * a][i] <= p[a] && p[a] <= node.bounds[2 * a + 1][i];
    if (inside && reaches(tree, block_size, {node.child[i]}, p, index)) return true;
  }
  return false;
}

struct Case {
  Placing placing;
  bool uniform;
  uint32_t block_size;
};

class OctreeBuild : public testing::TestWithParam<Case> {
 protected:
  OctreeOptions options() const {
    const SplitSearch* search = GetParam().uniform ? nullptr : &search_;
    return GetParam().block_size == 1 ? instance_octree_options(search)
                                      : mesh_octree_options(search);
  }
  SweepSearch search_;
};

TEST_P(OctreeBuild, EachPointOfEachBoxIsReached) {
  std::mt19937 random(7);
  const auto boxes = boxes_of(GetParam().placing, 800, random);
  AcceleratorStatistics statistics;
  const WideTree tree = build_octree(boxes, options(), 2, statistics);
  for (const BuildBox& box : boxes) {
    for (int i = 0; i < 12; ++i) {
      float p[3];
      for (int a = 0; a < 3; ++a) {
        const auto where = random() % 4;
        const float middle = box.low[a] * 0.5f + box.high[a] * 0.5f;
        p[a] = where == 0 ? box.low[a] : where == 1 ? box.high[a] : middle;
        if (where == 3) p[a] = std::clamp(std::round(middle * 4) / 4, box.low[a], box.high[a]);
      }
      EXPECT_TRUE(reaches(tree, options().block_size, tree.root, p, box.index()));
    }
  }
}

TEST_P(OctreeBuild, KeepsItsLimits) {
  std::mt19937 random(8);
  const auto boxes = boxes_of(GetParam().placing, 3000, random);
  AcceleratorStatistics s;
  OctreeOptions o = options();
  build_octree(boxes, o, 1, s);
  EXPECT_GE(s.references, boxes.size());
  EXPECT_LE(static_cast<double>(s.references),
            o.max_duplication * static_cast<double>(boxes.size()) + 64);
  EXPECT_LE(s.depth, o.max_depth);
  EXPECT_GT(s.leaves, s.nodes);
  o.max_depth = 3;
  AcceleratorStatistics shallow;
  build_octree(boxes, o, 1, shallow);
  EXPECT_LE(shallow.depth, 3);
  EXPECT_LE(shallow.leaves, 64u);
}

uint64_t hash_of(const WideTree& tree) {
  uint64_t h = 1469598103934665603u;
  const auto add = [&h](const void* data, size_t size) {
    for (size_t i = 0; i < size; ++i)
      h = (h ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211u;
  };
  add(tree.nodes.data(), tree.nodes.bytes());
  add(tree.slots.data(), tree.slots.size() * sizeof(uint32_t));
  add(&tree.root, sizeof tree.root);
  return h;
}

TEST_P(OctreeBuild, DoesNotDependOnThreads) {
  std::mt19937 random(9);
  const auto boxes = boxes_of(GetParam().placing, 20000, random);
  AcceleratorStatistics statistics;
  const uint64_t one = hash_of(build_octree(boxes, options(), 1, statistics));
  for (const int threads : {2, 3, 4})
    EXPECT_EQ(hash_of(build_octree(boxes, options(), threads, statistics)), one) << threads;
}

INSTANTIATE_TEST_SUITE_P(
    All, OctreeBuild,
    testing::Values(Case{Placing::random, true, 1}, Case{Placing::random, false, 1},
                    Case{Placing::random, true, 4}, Case{Placing::random, false, 4},
                    Case{Placing::lattice, true, 1}, Case{Placing::lattice, false, 1},
                    Case{Placing::lattice, true, 4}, Case{Placing::lattice, false, 4},
                    Case{Placing::flat, true, 1}, Case{Placing::flat, false, 4},
                    Case{Placing::nested, true, 1}, Case{Placing::nested, false, 1},
                    Case{Placing::nested, false, 4}));

TEST(OctreeBuild, SplitsOnlyWhereThatPays) {
  const SweepSearch search;
  const OctreeOptions options = instance_octree_options(&search);
  const std::vector<BuildBox> same(1000, BuildBox(Bounds3{{0, 0, 0}, {1, 1, 1}}, 0));
  AcceleratorStatistics one;
  build_octree(same, options, 1, one);
  EXPECT_EQ(one.leaves, 1u);
  EXPECT_EQ(one.references, 1000u);
  std::vector<BuildBox> corners;
  for (uint32_t i = 0; i < 800; ++i) {
    const Point3 at{i & 1 ? 10.0 : 0, i & 2 ? 10.0 : 0, i & 4 ? 10.0 : 0};
    corners.emplace_back(Bounds3{at, at + Vec3{1, 1, 1}}, i);
  }
  AcceleratorStatistics eight;
  build_octree(corners, options, 1, eight);
  EXPECT_EQ(eight.leaves, 8u);
  EXPECT_EQ(eight.references, 800u);
  EXPECT_EQ(eight.depth, 2);
}

/// What a hit misses of another, if anything.
testing::AssertionResult same_answers(const Accelerator& a, const Accelerator& b, const Ray& ray) {
  Hit hit_a, hit_b;
  TraversalCounters counters;
  const bool found_a = a.closest_hit(ray, hit_a, counters);
  const bool found_b = b.closest_hit(ray, hit_b, counters);
  if (found_a != found_b || !(hit_a == hit_b) ||
      a.any_hit(ray, counters) != b.any_hit(ray, counters))
    return testing::AssertionFailure() << hit_a.t << " " << hit_b.t;
  return testing::AssertionSuccess();
}

TEST(Octree, RaysAlongAndOnSplitPlanesFindWhatAScanFinds) {
  std::vector<Instance> scene;
  // Equal spheres about the split planes of a box of side 8, so that many hits tie.
  for (int i = 0; i < 125; ++i) {
    const Point3 at{i % 5 * 2.0 - 4, i / 5 % 5 * 2.0 - 4, i / 25 * 2.0 - 4};
    scene.push_back({std::make_shared<Sphere>(at, i % 3 == 0 ? 1.0 : 0.5)});
  }
  scene.push_back({std::make_shared<Plane>(Vec3{0, 1, 0}, -4.5)});
  scene.push_back(scene.front());  // the same place twice: the smaller number wins
  const InstanceLinearScan scan(scene);
  const double parts[] = {0.0, -0.0, 1, -1};
  for (const OctreeKind kind :
       {OctreeKind::uniform, OctreeKind::nonuniform, OctreeKind::nonuniform_nlopt}) {
    const InstanceOctree octree(scene, kind, 1);
    EXPECT_GT(octree.statistics().leaves, 8u);
    for (int d = 1; d < 64; ++d) {
      const Vec3 direction{parts[d & 3], parts[d >> 2 & 3], parts[d >> 4]};
      for (int o = 0; o < 11 * 11 * 11; ++o) {
        const Point3 origin{o % 11 - 5.0, o / 11 % 11 - 5.0, o / 121 - 5.0};
        ASSERT_TRUE(same_answers(octree, scan, {origin, direction}));
      }
    }
  }
}

TEST(Octree, SmallScenesGetWhatTheyNeed) {
  const Ray ray{{0, 0, -5}, {0, 0, 1}};
  Hit hit;
  TraversalCounters counters;
  for (const AcceleratorKind kind : {AcceleratorKind::octree, AcceleratorKind::nonuniform_octree}) {
    const auto none = make_instance_accelerator({}, kind, 2);
    EXPECT_FALSE(none->closest_hit(ray, hit, counters));
    EXPECT_TRUE(none->bounds().empty());
    const auto empty = make_mesh_accelerator(std::make_shared<TriangleMesh>(), kind, 2);
    EXPECT_FALSE(empty->any_hit(ray, counters));
    auto mesh = std::make_shared<TriangleMesh>();
    mesh->positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    for (uint32_t count = 1; count <= 5; ++count) {
      mesh->triangles.push_back({0, 1, 2});
      const auto few = make_mesh_accelerator(mesh, kind, 2);
      hit = {};
      EXPECT_TRUE(few->closest_hit(ray, hit, counters));
      EXPECT_EQ(hit.primitive, 0u);
      EXPECT_EQ(hit.t, 5);
    }
    const auto one = make_instance_accelerator({{std::make_shared<Sphere>(Point3{}, 1)}}, kind, 2);
    hit = {};
    EXPECT_TRUE(one->closest_hit(ray, hit, counters));
    EXPECT_EQ(hit.t, 4);
  }
}

TEST(Octree, AHundredThousandIdenticalTrianglesStayOneVoxel) {
  TriangleMesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0.5f}, {0, 1, 0.25f}};
  mesh.triangles.assign(100000, {0, 1, 2});
  for (const OctreeKind kind : {OctreeKind::uniform, OctreeKind::nonuniform}) {
    const MeshOctree octree(mesh, kind, 1);
    const AcceleratorStatistics s = octree.statistics();
    EXPECT_LE(s.references, 400064u);
    EXPECT_LE(s.depth, 24);
    Hit hit;
    TraversalCounters counters;
    EXPECT_TRUE(octree.closest_hit({{0, 0, -5}, {0, 0, 1}}, hit, counters));
    EXPECT_EQ(hit.primitive, 0u);
  }
}

TEST(MakeAccelerator, MoreTrianglesThanATreeHoldsAreTheScenesFault) {
  EXPECT_NO_THROW(check_triangle_count(kMaxPrimitives));
  EXPECT_THROW(check_triangle_count(kMaxPrimitives + 1), Error);
}

}  // namespace
}  // namespace tessera
