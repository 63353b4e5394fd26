// N11, N19: CSG surfaces that rays leave, deep trees; and what a combination refuses and reports.
#include <gtest/gtest.h>

#include "base/error.h"
#include "renderer/shapes/disc.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/surface_interaction.h"
#include "renderer/shapes/torus.h"
#include "tests/numerics/shapes/csg_support.h"

namespace tessera::numerics {
namespace {

TEST(N11, CombinationsDoNotHitThemselvesNorLoseTheFarWall) {
  int64_t tested = 0;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(19, seed);
    for (int64_t i = 0; i < ray_count(100000); ++i) {
      // A convex whole, each operand twice through different transforms: all faces coincide.
      CsgTree tree;
      std::vector<CsgTree::Node> nodes;
      const Affine turn = random.turn();
      const Affine half = random.turn();
      const double scale = std::abs(random.power(-3, 3));
      const Affine frame =
          translation(random.direction() * (10 * scale)) * turn * scaling({scale, scale, scale});
      const std::shared_ptr<const Shape> shapes[] = {
          std::make_shared<Box>(Bounds3{{-1, -1, -1}, {1, 1, 1}}),
          std::make_shared<Sphere>(Point3{}, 1.2), std::make_shared<Cylinder>(0.9, 1.5),
          std::make_shared<Cone>(1.5, 3)};
      const int kind = random.below(4);
      for (int copy = 0; copy < 2; ++copy)
        for (int k = 0; k < 2; ++k)
          nodes.push_back(tree.add(shapes[(kind + k) % 4],
                                   Transform(copy == 0 ? frame : frame * half * inverse(half))));
      const CsgTree::Node root = tree.combine(
          CsgOperation::intersect,
          std::vector{tree.combine(CsgOperation::join, std::vector{nodes[0], nodes[2]}),
                      tree.combine(CsgOperation::join, std::vector{nodes[1], nodes[3]})});
      const CsgShape shape(tree, root);
      for (int k = 0; k < 10; ++k) {
        const Affine& m = frame;
        const Point3 target =
            m(Point3{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
        const Vec3 d = random.direction();
        const Ray ray{target - d * (scale * random.uniform(5, 50)), d};
        Hit hit, again;
        TraversalCounters counters;
        if (!shape.closest_hit(ray, hit, counters)) continue;
        // Without what a further transform adds: the whole's own error bound has to do.
        const SurfaceInteraction s = shape.surface(ray, hit);
        const Vec3 n = static_cast<Vec3>(s.geometric_normal);
        Vec3 away = random.direction();
        if (k % 3 == 0) away = across(n, random) + n * std::abs(random.power(-10, -1));
        if (dot(away, n) < 0) away = -away;
        ++tested;
        ASSERT_FALSE(shape.any_hit(spawn_ray(s, away), counters))
            << "seed " << seed << " at " << i << " kind " << kind;
        ASSERT_TRUE(shape.closest_hit(spawn_ray(s, -away), again, counters))
            << "seed " << seed << " at " << i << " kind " << kind;
      }
    }
  }
  EXPECT_GT(tested, ray_count(4000000));
}

TEST(N11, GrazingRaysOffCoincidingFacesSeeTheWall) {
  // A floor of two boxes with a common top, one of them far off in its own frame and so less exact,
  // and a wall that stands on it.
  Random random(25);
  for (int64_t i = 0; i < ray_count(400000); ++i) {
    CsgTree tree;
    const double off = std::abs(random.power(0, 5));
    const Affine turn = rotation({0, 1, 0}, random.uniform(0, 6.28));
    const Box far_box({{off - 3, off - 1, off - 3}, {off + 3, off, off + 3}});
    const auto near_floor = tree.add(std::make_shared<Box>(Bounds3{{-3, -1, -3}, {3, 0, 3}}));
    const auto far_floor =
        tree.add(std::make_shared<Box>(far_box), Transform(turn * translation({-off, -off, -off})));
    const auto wall = tree.add(std::make_shared<Box>(Bounds3{{1, -0.5, -9}, {2, 1, 9}}));
    const auto root = tree.combine(CsgOperation::join, std::vector{near_floor, far_floor, wall});
    const CsgShape shape(tree, root);
    const Ray down{{random.uniform(-1, 0.5), 5, random.uniform(-1, 1)},
                   {random.uniform(-0.1, 0.1), -1, random.uniform(-0.1, 0.1)}};
    Hit hit, next;
    TraversalCounters counters;
    ASSERT_TRUE(shape.closest_hit(down, hit, counters));
    const SurfaceInteraction s = shape.surface(down, hit);
    if (s.geometric_normal.y < 0.9) continue;
    const Vec3 d{1, std::abs(random.power(-16, -1)), random.uniform(-0.5, 0.5)};
    ASSERT_TRUE(shape.closest_hit(spawn_ray(s, d), next, counters)) << "at " << i;
    ASSERT_NEAR(next.t, 1 - s.point.x, 1e-9) << "at " << i;
  }
}

struct DeepResult {
  size_t hits = 0, wrong = 0;
};

void* trace_deep(void* argument) {
  auto& result = *static_cast<DeepResult*>(argument);
  constexpr int kDepth = 100000;
  Random random(20);
  // ((((B0 op B1) op B2) ...): thin slabs along x, each above the last, alternately joined, cut and
  // subtracted, so that no two operators in a row merge.
  struct Slab {
    CsgOperation operation;
    double from, to;
  };
  std::vector<Slab> slabs;
  CsgTree tree;
  CsgTree::Node node = 0;
  for (int i = 0; i < kDepth; ++i) {
    const double from = random.uniform(0, 100);
    const bool cut = i % 1000 == 999;
    const Slab slab{i % 2 ? CsgOperation::subtract : CsgOperation::join, cut ? 0 : from,
                    cut ? 0.01 : from + random.uniform(0, 0.05)};
    slabs.push_back(slab);
    const CsgTree::Node leaf =
        tree.add(std::make_shared<Box>(Bounds3{{slab.from, -1, -1}, {slab.to, 1, 1}}));
    node = i == 0 ? leaf : tree.combine(slab.operation, std::vector{node, leaf});
  }
  const CsgShape shape(tree, node);
  for (int k = 0; k < 3; ++k) {
    const Ray ray{{-1, random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)}, {1, 0, 0}};
    // Iteratively: the state between all sides, by folding.
    std::vector<double> sides;
    for (const Slab& s : slabs) sides.push_back(s.from), sides.push_back(s.to);
    std::sort(sides.begin(), sides.end());
    Hit hit;
    TraversalCounters counters;
    const bool found = shape.closest_hit(ray, hit, counters);
    double expected = -1;
    for (size_t i = 0; i + 1 < sides.size() && expected < 0; ++i) {
      if (sides[i + 1] == sides[i]) continue;
      const double x = 0.5 * (sides[i] + sides[i + 1]);
      bool inside = false;
      for (const Slab& s : slabs)
        if (x > s.from && x < s.to) inside = s.operation == CsgOperation::join;
      if (inside && sides[i + 1] - sides[i] > 1e-12) expected = sides[i];
    }
    if (found && expected >= 0) ++result.hits;
    if (!found || std::abs(hit.t - 1 - expected) > 1e-12) ++result.wrong;
  }
  return nullptr;
}

TEST(N19, DepthOfAHundredThousandUnderASmallStack) {
  DeepResult result;
  ASSERT_NO_FATAL_FAILURE(run_on_small_stack(trace_deep, &result));
  EXPECT_EQ(result.hits, 3u);
  EXPECT_EQ(result.wrong, 0u);
}

TEST(Csg, RefusesWhatHasNoInside) {
  CsgTree tree;
  EXPECT_THROW(tree.add(std::make_shared<Disc>(Point3{}, Vec3{0, 0, 1}, 1)), Error);
  EXPECT_THROW(tree.add(std::make_shared<Cylinder>(1, 2, OpenParts{.side = true})), Error);
  const auto ball = tree.add(std::make_shared<Sphere>(Point3{}, 1));
  EXPECT_THROW(tree.combine(CsgOperation::join, {}), Error);
  EXPECT_THROW(tree.combine(CsgOperation::join, std::vector{ball, ball}), Error);
  EXPECT_THROW(tree.combine(CsgOperation::join, std::vector{ball, ball + 7}), Error);
}

TEST(Csg, SurfaceNamesItsOperandAndMaterial) {
  CsgTree tree;
  const auto box = tree.add(std::make_shared<Box>(Bounds3{{-1, -1, -1}, {1, 1, 1}}), {}, 3);
  const auto ball =
      tree.add(std::make_shared<Sphere>(Point3{}, 0.5), Transform(translation({0, 1, 0})), 7);
  const CsgShape shape(tree, tree.combine(CsgOperation::subtract, std::vector{box, ball}));
  EXPECT_EQ(shape.primitive_count(), 7u);
  Hit hit;
  TraversalCounters counters;
  Ray ray{{0, 5, 0}, {0, -1, 0}};
  ASSERT_TRUE(shape.closest_hit(ray, hit, counters));
  EXPECT_DOUBLE_EQ(hit.t, 4.5);
  EXPECT_EQ(shape.operand_of(hit.primitive), 1u);
  LocalSurface s = shape.surface(ray, hit);
  EXPECT_EQ(s.material, 7u);
  EXPECT_NEAR(s.geometric_normal.y, 1, 1e-15);
  EXPECT_NEAR(s.point.y, 0.5, 1e-15);
  ray.origin.x = 0.75;
  hit = {};
  ASSERT_TRUE(shape.closest_hit(ray, hit, counters));
  EXPECT_DOUBLE_EQ(hit.t, 4);
  EXPECT_EQ(hit.primitive, 3u);
  EXPECT_EQ(shape.surface(ray, hit).material, 3u);
}

TEST(Csg, HalfSpacesBoundASolid) {
  CsgTree tree;
  std::vector<CsgTree::Node> nodes;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      Vec3 n;
      n[axis] = sign;
      nodes.push_back(tree.add(std::make_shared<Plane>(n, 1)));
    }
  const CsgShape cube(tree, tree.combine(CsgOperation::intersect, nodes));
  const Box box({{-1, -1, -1}, {1, 1, 1}});
  Random random(21);
  TraversalCounters counters;
  for (int i = 0; i < 10000; ++i) {
    const Ray ray = random_ray(random, i % 2);
    Hit a, b;
    ASSERT_EQ(cube.closest_hit(ray, a, counters), box.closest_hit(ray, b, counters));
    if (b.t < 1e30) {
      ASSERT_NEAR(a.t, b.t, 1e-14);
    }
  }
}

TEST(Csg, CombinationsOfCombinations) {
  CsgTree inner;
  const auto a = inner.add(std::make_shared<Torus>(1, 0.4));
  const auto b = inner.add(std::make_shared<Box>(Bounds3{{-2, -1, -2}, {2, 0, 2}}));
  const auto half =
      std::make_shared<CsgShape>(inner, inner.combine(CsgOperation::subtract, std::vector{a, b}));
  CsgTree outer, flat;
  const Transform turn(rotation({1, 1, 0}, 1));
  const auto c = outer.add(half, turn), d = outer.add(half);
  const CsgShape nested(outer, outer.combine(CsgOperation::join, std::vector{c, d}));
  std::vector<CsgTree::Node> parts;
  for (const Transform& t : {turn, Transform()})
    parts.push_back(flat.combine(
        CsgOperation::subtract,
        std::vector{flat.add(std::make_shared<Torus>(1, 0.4), t),
                    flat.add(std::make_shared<Box>(Bounds3{{-2, -1, -2}, {2, 0, 2}}), t)}));
  const CsgShape whole(flat, flat.combine(CsgOperation::join, parts));
  Random random(23);
  TraversalCounters counters;
  int hits = 0;
  for (int i = 0; i < 10000; ++i) {
    const Ray ray = random_ray(random, i % 2);
    Hit x, y;
    ASSERT_EQ(nested.closest_hit(ray, x, counters), whole.closest_hit(ray, y, counters));
    ASSERT_EQ(x.t, y.t);
    hits += x.t < 1e30;
  }
  EXPECT_GT(hits, 1000);
}

}  // namespace
}  // namespace tessera::numerics
