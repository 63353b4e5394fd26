// N10, N11, N12: rays that leave a surface do not meet it again, and find the far wall.
#include <gtest/gtest.h>

#include "renderer/accel/instance.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/disc.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/half_plane.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/torus.h"
#include "tests/numerics/support.h"

namespace tessera::numerics {
namespace {

using N11 = Shard;
INSTANTIATE_TEST_SUITE_P(Seed, N11, kSeeds);

Transform random_transform(Random& random, double exponent) {
  const double scale = std::abs(random.power(-exponent, exponent));
  Affine a;
  do {
    for (auto& row : a.m)
      for (size_t c = 0; c < 3; ++c) row[c] = random.uniform(-1, 1);
  } while (std::abs(a.determinant()) < 0.05);
  for (auto& row : a.m) {
    for (double& entry : row) entry *= scale;
    row[3] = random.uniform(-1, 1) * scale * std::abs(random.power(-1, 3));
  }
  return Transform(a);
}

Ray to_local(const Instance& instance, const Ray& ray) {
  return {instance.world_from_object.inverse_point(ray.origin),
          instance.world_from_object.inverse_vector(ray.direction)};
}

/// A ray in world space that aims at the local point `target`.
Ray aimed(const Instance& instance, const Point3& target, Random& random) {
  const Point3 at = instance.world_from_object.point(target);
  const Vec3 d = random.direction();
  const double far = length(at - Point3{}) * random.uniform(0.1, 3) + 1e-6;
  return {at - d * far, d};
}

bool hit_of(const Instance& instance, const Ray& ray, Hit& hit) {
  TraversalCounters counters;
  hit = {};
  const bool found = closest_hit_of(instance, 0, ray, hit, counters);
  EXPECT_EQ(found, any_hit_of(instance, ray, counters));
  return found;
}

/// A direction to the side of the normal, often grazing.
Vec3 leaving(const Vec3& n, bool outward, Random& random) {
  Vec3 d = random.direction();
  if (random.below(3) == 0) d = across(n, random) + n * std::abs(random.power(-12, -1));
  return (dot(n, d) > 0) == outward ? d : -d;
}

Point3 sliver_scale(Random& random, double e) {
  return {random.power(-e, e), random.power(-e, e), random.power(-e, e)};
}

TEST(N10, FlatShapesDoNotHitThemselves) {
  int64_t tested = 0, self_hits = 0;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(10, seed);
    for (int64_t i = 0; i < ray_count(1250000); ++i) {
      const double exponents[] = {0.5, 2, 4, 6, 8};
      const double e = exponents[random.below(5)];
      const Point3 a = sliver_scale(random, e), b = sliver_scale(random, e),
                   c = sliver_scale(random, e);
      Instance instance;
      Point3 target = a + (b - a) * random.uniform(0, 1) + (c - a) * random.uniform(0, 1);
      const Vec3 n = cross(b - a, c - a);
      if (n == Vec3{}) continue;
      try {
        switch (random.below(4)) {
          case 0:
            instance.shape = std::make_shared<Rectangle>(a, b - a, c - a);
            break;
          case 1:
            instance.shape = std::make_shared<Disc>(a, n, length(target - a) * 2 + 1e-30);
            break;
          case 2:
            instance.shape = std::make_shared<HalfPlane>(a, n, b - a);
            break;
          default:
            instance.shape =
                std::make_shared<ConvexPolygon>(std::vector<Point3>{a, b, b + (c - a), c});
        }
      } catch (const std::exception&) {
        continue;  // too thin to have a normal
      }
      if (random.next() & 1) instance.world_from_object = random_transform(random, 4);
      const Ray ray = aimed(instance, target, random);
      Hit hit;
      if (!hit_of(instance, ray, hit)) continue;
      const SurfaceInteraction s = surface_at({&instance, 1}, ray, hit);
      for (const bool outward : {true, false}) {
        const Vec3 d = leaving(static_cast<Vec3>(s.geometric_normal), outward, random);
        Hit again;
        ++tested;
        if (hit_of(instance, spawn_ray(s, d), again)) ++self_hits;
        const Ray local = to_local(instance, ray);
        const LocalSurface at = instance.shape->surface(local, hit);
        TraversalCounters counters;
        if (instance.shape->any_hit(
                spawn_ray(at, leaving(static_cast<Vec3>(at.geometric_normal), outward, random)),
                counters))
          ++self_hits;
      }
    }
  }
  EXPECT_EQ(self_hits, 0);
  EXPECT_GT(tested, ray_count(2000000));
}

/// No bound on a hit's error has moved these origins: they are the points of a plane as nearly as
/// double precision has them.
TEST(N10, OriginsOnAPlaneDoNotMeetIt) {
  int64_t tested = 0, hits = 0;
  Random random(110, 1);
  for (int64_t i = 0; i < ray_count(2000000); ++i) {
    // Of small whole numbers, so that the normal is exact.
    const auto corner = [&] {
      return Vec3{random.below(21) - 10.0, random.below(21) - 10.0, random.below(21) - 10.0};
    };
    const Vec3 a = corner(), b = corner(), n = cross(a, b);
    if (n == Vec3{}) continue;
    const Point3 zero;
    const std::unique_ptr<Shape> shapes[] = {
        std::make_unique<Rectangle>(zero, a, b), std::make_unique<Disc>(zero, n, 100),
        std::make_unique<HalfPlane>(zero, n, cross(n, a)), std::make_unique<Plane>(n, 0),
        std::make_unique<ConvexPolygon>(
            std::vector<Point3>{zero, zero + a, zero + (a + b), zero + b})};
    const QuadVec p = QuadVec(a) * random.uniform() + QuadVec(b) * random.uniform();
    const Ray ray{{static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)},
                  leaving(n, random.next() & 1, random)};
    TraversalCounters counters;
    for (const auto& shape : shapes) {
      ++tested;
      hits += shape->any_hit(ray, counters);
    }
  }
  EXPECT_EQ(hits, 0);
  EXPECT_GT(tested, ray_count(9000000));
}

TEST(N11, RoundSolidsDoNotHitThemselvesNorLoseTheFarWall) {
  int64_t outward_rays = 0, inward_rays = 0, self_hits = 0, lost = 0;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(11, seed);
    for (int64_t i = 0; i < ray_count(1250000); ++i) {
      const double r = std::abs(random.power(-3, 3)), h = r * std::abs(random.power(-2, 2));
      Instance instance;
      const int kind = random.below(3);
      if (kind == 0) instance.shape = std::make_shared<Cylinder>(r, h);
      if (kind == 1) instance.shape = std::make_shared<Cone>(r, h);
      if (kind == 2) instance.shape = std::make_shared<Cone>(r, h, r * random.uniform(0.01, 2));
      if (random.next() & 1) instance.world_from_object = random_transform(random, 4);
      const Point3 target{r * random.uniform(-1, 1), h * random.uniform(-0.5, 0.5),
                          r * random.uniform(-1, 1)};
      const Ray ray = aimed(instance, target, random);
      Hit hit;
      if (!hit_of(instance, ray, hit)) continue;
      const SurfaceInteraction s = surface_at({&instance, 1}, ray, hit);
      const Vec3 n = static_cast<Vec3>(s.geometric_normal);
      Hit again;
      ++outward_rays;
      if (hit_of(instance, spawn_ray(s, leaving(n, true, random)), again)) ++self_hits;
      ++inward_rays;
      if (!hit_of(instance, spawn_ray(s, leaving(n, false, random)), again)) ++lost;
      const LocalSurface at = instance.shape->surface(to_local(instance, ray), hit);
      const Vec3 local_n = static_cast<Vec3>(at.geometric_normal);
      TraversalCounters counters;
      if (instance.shape->any_hit(spawn_ray(at, leaving(local_n, true, random)), counters))
        ++self_hits;
      if (!instance.shape->any_hit(spawn_ray(at, leaving(local_n, false, random)), counters))
        ++lost;
    }
  }
  EXPECT_EQ(self_hits, 0);
  EXPECT_EQ(lost, 0);
  EXPECT_GT(outward_rays, ray_count(3000000));
}

Quad torus_distance(double minor, const Ray& ray, Quad t) {
  const QuadVec p = QuadVec(ray.origin) + QuadVec(ray.direction) * t;
  const Quad ring = sqrtq(p.x * p.x + p.z * p.z) - 1;
  return sqrtq(ring * ring + p.y * p.y) - minor;
}

TEST_P(N11, ToriDoNotHitThemselvesNorLoseTheFarWall) {
  const double minors[] = {1e-4, 0.01, 0.25, 0.9, 1, 1.5};
  int64_t tested = 0, self_hits = 0, lost = 0, wrong_side = 0;
  Random random(12, seed());
  for (int64_t i = 0; i < ray_count(1250000); ++i) {
    const double minor = minors[random.below(6)];
    Instance instance;
    instance.shape = std::make_shared<Torus>(1, minor);
    if (random.next() & 1) instance.world_from_object = random_transform(random, 4);
    const double turn = random.uniform(0, 6.3);
    const Point3 target = Point3{std::cos(turn), 0, std::sin(turn)} +
                          random.direction() * (minor * random.uniform(0, 1));
    const Ray ray = aimed(instance, target, random);
    Hit hit;
    if (!hit_of(instance, ray, hit)) continue;
    const SurfaceInteraction s = surface_at({&instance, 1}, ray, hit);
    const Vec3 n = static_cast<Vec3>(s.geometric_normal);
    ++tested;
    Hit again;
    const Ray out = spawn_ray(s, leaving(n, true, random));
    const Ray local = to_local(instance, out);
    if (!(torus_distance(minor, local, 0) > 0)) ++wrong_side;
    // A torus can be met again from outside; then the line is inside beyond the hit.
    if (hit_of(instance, out, again)) {
      bool inside = false;
      for (const double beyond : {1 + 1e-9, 1.001, 2.0, 10.0})
        inside |= torus_distance(minor, local, Quad(again.t) * beyond) < 0;
      if (!inside) ++self_hits;
    }
    const Ray in = spawn_ray(s, leaving(n, false, random));
    if (!(torus_distance(minor, to_local(instance, in), 0) < 0)) ++wrong_side;
    if (!hit_of(instance, in, again)) ++lost;
  }
  EXPECT_EQ(self_hits, 0);
  EXPECT_EQ(lost, 0);
  EXPECT_EQ(wrong_side, 0);
  EXPECT_GT(tested, ray_count(2000000 / kShards));
}

TEST(N12, BothSidesOfAThinGapAreSeenInOrder) {
  Random random(12);
  for (int64_t i = 0; i < ray_count(1000000); ++i) {
    const double scale = std::pow(10.0, 3 * (random.below(3) - 1));
    const double gap = std::pow(10.0, random.uniform(-13, -1));
    // Two coaxial cylinders, two concentric spheres and two parallel discs.
    const Sphere small({0, 0, 0}, scale), large({0, 0, 0}, (1 + gap) * scale);
    const Cylinder inner(scale, 4 * scale), outer((1 + gap) * scale, 4 * scale);
    const Disc low({0, 0, 0}, {0, 0, 1}, 4 * scale),
        high({0, 0, gap * scale}, {0, 0, 1}, 4 * scale);
    const Vec3 d = normalize(Vec3{-1, random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)});
    const Ray ray{Point3{} - d * (random.uniform(3, 5) * scale), d};
    const Vec3 e = normalize(Vec3{random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), -1});
    const Ray down{Point3{} - e * (random.uniform(1, 5) * scale), e};
    TraversalCounters counters;
    Hit a, b, c, f, g, h;
    ASSERT_TRUE(small.closest_hit(ray, g, counters) && large.closest_hit(ray, h, counters));
    ASSERT_LE(h.t, g.t + 4 * kUnitRoundoff * g.t);
    ASSERT_TRUE(inner.closest_hit(ray, a, counters) && outer.closest_hit(ray, b, counters));
    ASSERT_TRUE(low.closest_hit(down, c, counters) && high.closest_hit(down, f, counters));
    const double resolved = 64 * kUnitRoundoff * 6;
    ASSERT_LE(b.t, a.t + 4 * kUnitRoundoff * a.t);
    ASSERT_LE(f.t, c.t);
    if (gap >= resolved) {
      ASSERT_LT(b.t, a.t) << "gap " << gap;
      ASSERT_LT(f.t, c.t) << "gap " << gap;
      ASSERT_LT(h.t, g.t) << "gap " << gap;
      // A ray that leaves the inner one outward meets the outer one from inside.
      const Instance instance{std::make_shared<Cylinder>(inner), {}};
      const SurfaceInteraction s = to_world(inner.surface(ray, a), {}, false, 0);
      const Ray out = spawn_ray(s, -d);
      Hit again;
      ASSERT_FALSE(inner.closest_hit(out, again, counters));
      ASSERT_TRUE(outer.closest_hit(out, again, counters)) << "gap " << gap;
    }
  }
}

}  // namespace
}  // namespace tessera::numerics
