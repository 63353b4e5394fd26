// N13, N14, N22: CSG against exact and quad-precision oracles.
#include <gtest/gtest.h>
#include <functional>

#include "renderer/math/rounding.h"
#include "tests/numerics/shapes/csg_support.h"

namespace tessera::numerics {
namespace {

using N13 = Shard;
INSTANTIATE_TEST_SUITE_P(Seed, N13, kSeeds);
using N14 = Shard;
INSTANTIATE_TEST_SUITE_P(Seed, N14, kSeeds);

/// All changes ahead, by asking again beyond each.
std::vector<Hit> all_hits(const Shape& shape, Ray ray) {
  std::vector<Hit> hits;
  TraversalCounters counters;
  for (;;) {
    Hit hit;
    if (!shape.closest_hit(ray, hit, counters)) return hits;
    hits.push_back(hit);
    ray.t_min = hit.t;
  }
}

/// Compares every change along the ray, their order, sides and places. False where in doubt.
bool compare(const Expression& e, const CsgShape& shape, const Ray& local, const Ray& world,
             double gap) {
  const Truth truth = truth_of(e, local, gap);
  if (truth.doubtful) return false;
  if (!truth.changes.empty() && truth.changes[0] < 4 * gap) return false;
  const std::vector<Hit> hits = all_hits(shape, world);
  EXPECT_EQ(hits.size(), truth.changes.size());
  if (hits.size() != truth.changes.size()) return true;
  bool inside = truth.starts_inside;
  for (size_t i = 0; i < hits.size(); ++i, inside = !inside) {
    EXPECT_LE(fabsq(hits[i].t - truth.changes[i]), std::max(gap, 1e-14));
    const LocalSurface s = shape.surface(world, hits[i]);
    // The normal points out of the whole, whatever operand shows.
    EXPECT_EQ(dot(s.geometric_normal, world.direction) > 0, inside) << "change " << i;
    EXPECT_LE(length(s.point - world.at(hits[i].t)), 1e-13);
  }
  return true;
}

TEST_P(N13, RandomCombinationsWithCoincidingFaces) {
  int64_t compared = 0, doubtful = 0;
  Random random(13, seed());
  for (int64_t i = 0; i < ray_count(40000); ++i) {
    const bool boxes_only = i % 2 == 0;
    const Expression e = random_expression(random, random.below(6), boxes_only);
    const CsgShape shape = e.shape();
    for (int k = 0; k < 30; ++k) {
      const Ray ray = random_ray(random, k % 3 == 0);
      (compare(e, shape, ray, ray, 1e-12) ? compared : doubtful)++;
      ASSERT_FALSE(HasFailure()) << "seed " << seed() << " at " << i << " ray " << k;
    }
  }
  EXPECT_GT(compared, 50 * doubtful);
  EXPECT_GT(compared, ray_count(9000000 / kShards));
}

TEST_P(N13, ExactlyThroughEdgesAndCorners) {
  // Rays through points and along directions of the grid meet edges and corners exactly; quads tell
  // equal places from different ones, as these are fractions of small integers.
  Random random(14, seed());
  for (int64_t i = 0; i < ray_count(40000); ++i) {
    const Expression e = random_expression(random, random.below(5), true);
    const CsgShape shape = e.shape();
    for (int k = 0; k < 30; ++k) {
      // Off the grid of faces, lest the ray runs inside a face.
      Ray ray{{half_steps(random, -12, 12) + 0.125, half_steps(random, -12, 12) + 0.125,
               half_steps(random, -12, 12) + 0.125},
              {}};
      ray.direction =
          Point3{half_steps(random, -3, 3), half_steps(random, -3, 3), half_steps(random, -3, 3)} -
          ray.origin;
      compare(e, shape, ray, ray, 1e-20);
      ASSERT_FALSE(HasFailure()) << "seed " << seed() << " at " << i << " ray " << k;
    }
  }
}

TEST_P(N13, NestedThirtyTwoDeepAndTurned) {
  const Affine turn = rotation({1, 2, 3}, portable::radians(37));
  int64_t compared = 0;
  Random random(15, seed());
  for (int64_t i = 0; i < ray_count(2000); ++i) {
    const int depth = 1 + random.below(32);
    const Expression e = random_expression(random, depth, i % 2 == 0);
    const Transform world(translation({random.uniform(-9, 9), 3, -2}) * turn);
    const CsgShape shape = e.shape(world);
    for (int k = 0; k < 30; ++k) {
      const Ray local = random_ray(random, k % 3 == 0);
      const Ray ray{world.point(local.origin), world.vector(local.direction)};
      if (compare(e, shape, local, ray, 1e-12)) ++compared;
      ASSERT_FALSE(HasFailure()) << "seed " << seed() << " at " << i << " ray " << k;
    }
  }
  EXPECT_GT(compared, ray_count(400000 / kShards));
}

TEST_P(N13, CylinderThroughBoxWithEqualCaps) {
  Expression a, b, difference;
  a.solid.extent = {{-1, -1, -1}, {1, 1, 1}};
  b.solid.kind = OracleSolid::cylinder;
  b.solid.radius = 0.5;
  difference.leaf = false;
  difference.operation = CsgOperation::subtract;
  difference.operands = {a, b};
  Random random(16, seed());
  for (const bool turned : {false, true}) {
    const Transform world(turned ? rotation({1, 2, 3}, portable::radians(37)) : Affine{});
    const CsgShape shape = difference.shape(world);
    for (int64_t i = 0; i < ray_count(600000); ++i) {
      const Ray local = random_ray(random, false);
      const Ray ray{world.point(local.origin), world.vector(local.direction)};
      compare(difference, shape, local, ray, 1e-12);
      ASSERT_FALSE(HasFailure()) << "seed " << seed() << " at " << i;
    }
  }
}

TEST(N13, IdentitiesOfSets) {
  Random random(17);
  TraversalCounters counters;
  for (int64_t i = 0; i < ray_count(40000); ++i) {
    const OracleSolid sa = random_solid(random, false), sb = random_solid(random, false);
    const auto make = [&](CsgOperation op, std::vector<Expression> operands) {
      Expression e;
      e.leaf = false;
      e.operation = op;
      e.operands = std::move(operands);
      return e;
    };
    Expression a, b;
    a.solid = sa, b.solid = sb;
    using enum CsgOperation;
    const CsgShape alone = a.shape();
    const CsgShape minus_self = make(subtract, {a, a}).shape();
    const CsgShape or_self = make(join, {a, a}).shape();
    const CsgShape and_self = make(intersect, {a, a}).shape();
    const CsgShape both = make(intersect, {a, b}).shape();
    const CsgShape double_difference = make(subtract, {a, make(subtract, {a, b})}).shape();
    for (int k = 0; k < 100; ++k) {
      const Ray ray = random_ray(random, k % 3 == 0);
      Hit h0, h1, h2, h3, h4, h5;
      const bool found = alone.closest_hit(ray, h0, counters);
      ASSERT_FALSE(minus_self.closest_hit(ray, h1, counters));
      ASSERT_EQ(or_self.closest_hit(ray, h2, counters), found);
      ASSERT_EQ(and_self.closest_hit(ray, h3, counters), found);
      ASSERT_EQ(h0.t, h2.t);
      ASSERT_EQ(h0.t, h3.t);
      ASSERT_EQ(both.closest_hit(ray, h4, counters),
                double_difference.closest_hit(ray, h5, counters));
      // Where faces of a and b all but coincide, either may be the one that shows.
      if (h4.t < 1e30) {
        ASSERT_NEAR(h4.t, h5.t, 1e-14);
      }
      // A solid alone is what its own test says.
      Hit direct;
      const Transform place = sa.place();
      const Ray local{place.inverse_point(ray.origin), place.inverse_vector(ray.direction)};
      ASSERT_EQ(sa.shape()->closest_hit(local, direct, counters), found);
      ASSERT_EQ(direct.t, h0.t);
    }
  }
}

Expression shuffled(Expression e, Random& random) {
  for (Expression& operand : e.operands) operand = shuffled(operand, random);
  if (e.leaf) return e;
  const size_t first = e.operation == CsgOperation::subtract ? 1 : 0;
  for (size_t i = e.operands.size(); i-- > first + 1;)
    std::swap(e.operands[i], e.operands[first + random.below(i - first + 1)]);
  // Group the last operands anew; what is subtracted is united.
  if (e.operands.size() > first + 1 && random.next() & 1) {
    Expression group;
    group.leaf = false;
    group.operation = e.operation == CsgOperation::subtract ? CsgOperation::join : e.operation;
    group.operands = {e.operands[e.operands.size() - 2], e.operands.back()};
    e.operands.resize(e.operands.size() - 2);
    e.operands.push_back(group);
  }
  return e;
}

TEST(N22, OrderOfCoincidingFacesChangesNoBit) {
  // A few solids, each many times over and slightly off by other transforms: places of many
  // crossings, some equal bit for bit and some not.
  TraversalCounters counters;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(24, seed);
    for (int64_t i = 0; i < ray_count(40000); ++i) {
      Expression e = random_expression(random, 2 + random.below(4), true);
      const OracleSolid solids[] = {random_solid(random, true), random_solid(random, true)};
      const std::function<void(Expression&)> replace = [&](Expression& x) {
        if (x.leaf) x.solid = solids[random.below(2)];
        for (Expression& operand : x.operands) replace(operand);
      };
      replace(e);
      const Affine turn = random.turn(), other_turn = random.turn();
      const Affine frames[] = {turn, turn * other_turn * inverse(other_turn),
                               other_turn * (inverse(other_turn) * turn)};
      const std::function<void(Expression&)> place = [&](Expression& x) {
        if (x.leaf) x.solid.extra = frames[random.below(3)];
        for (Expression& operand : x.operands) place(operand);
      };
      place(e);
      const CsgShape one = e.shape(), other = shuffled(e, random).shape();
      for (int k = 0; k < 30; ++k) {
        const Ray ray = random_ray(random, k % 3 == 0);
        Hit a, b;
        ASSERT_EQ(one.closest_hit(ray, a, counters), other.closest_hit(ray, b, counters));
        ASSERT_EQ(a.t, b.t) << "seed " << seed << " at " << i << " ray " << k;
      }
    }
  }
}

TEST(N22, OrderAndGroupingChangeNoBit) {
  TraversalCounters counters;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(22, seed);
    for (int64_t i = 0; i < ray_count(40000); ++i) {
      const Expression e = random_expression(random, random.below(8), false);
      const Transform world(i % 2 ? rotation({1, 2, 3}, 0.6) : Affine{});
      const CsgShape one = e.shape(world), other = shuffled(e, random).shape(world);
      for (int k = 0; k < 30; ++k) {
        const Ray ray = random_ray(random, k % 3 == 0);
        Hit a, b;
        ASSERT_EQ(one.closest_hit(ray, a, counters), other.closest_hit(ray, b, counters));
        ASSERT_EQ(a.t, b.t) << "seed " << seed << " at " << i << " ray " << k;
      }
    }
  }
}

/// With solids far from every ray, more than a table of what holds has room for.
CsgShape among_many(const Expression& e, const Transform& world) {
  CsgTree tree;
  std::vector<CsgTree::Node> nodes{e.add_to(tree, world)};
  for (size_t i = 0; i <= CsgTable::kMostLeaves; ++i)
    nodes.push_back(
        tree.add(std::make_shared<Sphere>(Point3{1e4, 1e4, 100.0 * static_cast<double>(i)}, 1)));
  const CsgTree::Node root = tree.combine(CsgOperation::join, nodes);
  return CsgShape(tree, root);
}

TEST(N22, FewSolidsAreMetWhereTheyAreAmongMany) {
  int64_t hits = 0;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(222, seed);
    for (int64_t i = 0; i < ray_count(20000); ++i) {
      const Expression e = random_expression(random, random.below(3), i % 2);
      const Transform world(i % 3 ? Affine{} : rotation({1, 2, 3}, 0.6));
      const CsgShape few = e.shape(world), many = among_many(e, world);
      for (int k = 0; k < 30; ++k) {
        const Ray ray = random_ray(random, k % 3 == 0);
        const std::vector<Hit> found = all_hits(few, ray);
        ASSERT_EQ(found, all_hits(many, ray)) << "seed " << seed << " at " << i << " ray " << k;
        hits += static_cast<int64_t>(found.size());
      }
    }
  }
  EXPECT_GT(hits, ray_count(20000) * 30);
}

TEST_P(N14, RaysThatStartInsideOrOnSurfaces) {
  int64_t compared = 0;
  Random random(18, seed());
  for (int64_t i = 0; i < ray_count(40000); ++i) {
    const Expression e = random_expression(random, random.below(4), true);
    const CsgShape shape = e.shape();
    for (int k = 0; k < 30; ++k) {
      // On the grid: on faces, edges and corners, inside solids and holes, where solids overlap.
      const Point3 o{half_steps(random, -3, 3), half_steps(random, -3, 3),
                     half_steps(random, -3, 3)};
      const Ray ray{o, random.direction()};
      const Truth truth = truth_of(e, ray, 1e-12);
      if (truth.doubtful) continue;
      Hit hit;
      TraversalCounters counters;
      const bool found = shape.closest_hit(ray, hit, counters);
      ASSERT_EQ(found, !truth.changes.empty()) << "seed " << seed() << " at " << i;
      if (found) {
        ASSERT_LE(fabsq(hit.t - truth.changes[0]), 1e-13);
      }
      ++compared;
    }
  }
  EXPECT_GT(compared, ray_count(7000000 / kShards));
}

}  // namespace
}  // namespace tessera::numerics
