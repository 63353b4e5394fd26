// N05, N07: tori of every kind against quad precision.
#include <gtest/gtest.h>

#include <vector>

#include "renderer/math/rounding.h"
#include "renderer/shapes/torus.h"
#include "tests/numerics/support.h"

namespace tessera::numerics {
namespace {

using N07 = Shard;
INSTANTIATE_TEST_SUITE_P(Seed, N07, kSeeds);

using Roots = std::vector<Quad>;

Quad value(const Roots& p, Quad x) {
  Quad sum = 0;
  for (size_t i = p.size(); i-- > 0;) sum = sum * x + p[i];
  return sum;
}

template <typename F>
Quad bisect(Quad low, Quad high, const F& f) {
  const bool rises = f(low) < 0;
  for (int i = 0; i < 130; ++i) {
    const Quad middle = (low + high) / 2;
    ((f(middle) < 0) == rises ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// Turning points included where they touch, real roots of p in [low, high] by bisection.
Roots real_roots(const Roots& p, Quad low, Quad high) {
  if (p.size() == 2) return {p[1] == 0 ? low : -p[0] / p[1]};
  Roots slope;
  for (size_t i = 1; i < p.size(); ++i) slope.push_back(p[i] * Quad(i));
  Roots ends{low}, roots;
  for (const Quad x : real_roots(slope, low, high))
    if (x > ends.back() && x < high) ends.push_back(x);
  ends.push_back(high);
  for (size_t i = 1; i < ends.size(); ++i)
    if ((value(p, ends[i - 1]) < 0) != (value(p, ends[i]) < 0))
      roots.push_back(bisect(ends[i - 1], ends[i], [&](Quad x) { return value(p, x); }));
  return roots;
}

Quad distance(Quad major, Quad minor, const QuadVec& p) {
  const Quad ring = sqrtq(p.x * p.x + p.z * p.z) - major;
  return sqrtq(ring * ring + p.y * p.y) - minor;
}

/// Parameters of all crossings of the line.
Roots oracle(Quad major, Quad minor, const Ray& ray) {
  const QuadVec o(ray.origin), d(ray.direction);
  const Quad dd = dot(d, d), shift = -dot(o, d) / dd;
  const QuadVec p = o + d * shift;
  const Quad reach2 = (major + minor) * (major + minor) - dot(p, p);
  if (reach2 <= 0) return {};
  const Quad reach = 2 * sqrtq(reach2 / dd) + minor / sqrtq(dd);
  // (|p + x d|^2 + R^2 - r^2)^2 - 4 R^2 (distance from the axis)^2
  const Quad k = dot(p, p) + major * major - minor * minor, r2 = 4 * major * major;
  const Quad a = d.x * d.x + d.z * d.z, b = d.x * p.x + d.z * p.z, c = p.x * p.x + p.z * p.z;
  const Roots quartic{k * k - r2 * c, -2 * r2 * b, 2 * k * dd - r2 * a, 0, dd * dd};
  Roots slope, roots, ends{-reach};
  for (size_t i = 1; i < 5; ++i) slope.push_back(quartic[i] * Quad(i));
  for (const Quad x : real_roots(slope, -reach, reach)) ends.push_back(x);
  ends.push_back(reach);
  const auto at = [&](Quad x) { return distance(major, minor, p + d * x); };
  for (size_t i = 1; i < ends.size(); ++i)
    if ((at(ends[i - 1]) < 0) != (at(ends[i]) < 0))
      roots.push_back(shift + bisect(ends[i - 1], ends[i], at));
  return roots;
}

struct First {
  Quad t = kQuadInfinity;
  size_t number = 0;  ///< among all crossings, and their count
  size_t count = 0;
};

First first_ahead(const Roots& roots) {
  for (size_t i = 0; i < roots.size(); ++i)
    if (roots[i] > 0) return {roots[i], i, roots.size()};
  return {kQuadInfinity, roots.size(), roots.size()};
}

struct Tally {
  int64_t hits = 0, misses = 0, in_band = 0;
  double worst = 0;  ///< |dt| / D of the hits
};

void check(double minor, const Ray& ray, Tally& tally) {
  const Torus torus(1, minor);
  Hit hit;
  TraversalCounters counters;
  const bool found = torus.closest_hit(ray, hit, counters);
  ASSERT_EQ(found, torus.any_hit(ray, counters));
  const double speed = length(ray.direction);
  const double far = size_of(ray.origin);
  const Quad band = 16 * kUnitRoundoff * (far + 1 + minor);
  const First inner = first_ahead(oracle(1, minor - band, ray));
  const First outer = first_ahead(oracle(1, minor + band, ray));
  if (inner.number != outer.number || inner.count != outer.count) {
    ++tally.in_band;
    return;
  }
  const bool expected = inner.t < kQuadInfinity;
  ASSERT_EQ(found, expected);
  (expected ? tally.hits : tally.misses)++;
  if (!found) return;
  const Quad exact = first_ahead(oracle(1, minor, ray)).t;
  const double slack = 2 * kUnitRoundoff * hit.t;
  ASSERT_TRUE(hit.t >= std::min(inner.t, outer.t) - slack &&
              hit.t <= std::max(inner.t, outer.t) + slack);
  const double error = static_cast<double>(fabsq(hit.t - exact)) * speed;
  tally.worst = std::max(tally.worst, error / (far + 1 + minor));
  // The hit is on the surface; surface() moves it there to a few roundings of the torus's size.
  const QuadVec at = QuadVec(ray.origin) + QuadVec(ray.direction) * hit.t;
  ASSERT_LE(fabsq(distance(1, minor, at)), 32 * kUnitRoundoff * (far + 1));
  const LocalSurface s = torus.surface(ray, hit);
  ASSERT_LE(fabsq(distance(1, minor, QuadVec(s.point))),
            dot(abs(static_cast<Vec3>(s.geometric_normal)), s.point_error));
  const Bounds3 box = torus.bounds();
  ASSERT_TRUE(box.contains(s.point));
}

TEST_P(N07, ToriAreHitWhereQuadPrecisionSaysSo) {
  const double minors[] = {1e-4, 1e-3, 0.01, 0.1, 0.25, 0.5, 0.9, 0.99, 1, 1.5};
  Tally aimed, grazing, others;
  Random random(7, seed());
  for (int64_t i = 0; i < ray_count(60000); ++i) {
    const double minor = minors[random.below(10)];
    const double far =
        random.next() & 1 ? random.uniform(1.5, 10) : std::pow(10, random.uniform(0.2, 6));
    const double turn = random.uniform(0, 6.3), tube = random.uniform(0, 6.3);
    const Vec3 out{std::cos(turn), 0, std::sin(turn)};
    const Vec3 n{out.x * std::cos(tube), std::sin(tube), out.z * std::cos(tube)};
    const Point3 on = Point3{} + out + n * minor;
    const double speed = std::abs(random.power(-1, 1));
    Tally* tally = &others;
    Ray ray;
    switch (random.below(6)) {
      case 0:
        ray = {Point3{} + random.direction() * far, {}};
        ray.direction = (on - ray.origin) * (speed / far);
        tally = &aimed;
        break;
      case 1: {  // tangent but for a sliver of the tube
        const Vec3 d = across(n, random);
        const double off = minor * random.power(-8, -2);
        ray = {on + n * off - d * far, d * speed};
        tally = &grazing;
        break;
      }
      case 2:  // along the axis, or nearly so
        ray = {{random.power(-16, -1), -far, random.power(-16, -1)},
               {random.power(-16, -3), 1, random.power(-16, -3)}};
        break;
      case 3: {  // in the plane of the circle, or nearly so
        const double y = random.next() & 1 ? 0 : random.power(-16, -1) * minor;
        const Vec3 d = normalize(Vec3{random.uniform(-1, 1), 0, random.uniform(-1, 1)});
        ray = {Point3{d.z * random.uniform(-2, 2), y, -d.x * random.uniform(-2, 2)} - d * far, d};
        break;
      }
      case 4:  // through the hole
        ray = {Point3{out.x * 0.5, random.uniform(-1, 1), out.z * 0.5}, random.direction()};
        break;
      default:  // from near the surface, either side
        ray = {on + n * (minor * random.power(-10, -1)), random.direction()};
    }
    check(minor, ray, *tally);
    if (testing::Test::HasFatalFailure()) {
      FAIL() << "seed " << seed() << " at " << i << " minor " << minor << " far " << far;
    }
  }
  EXPECT_GT(aimed.hits, 40);
  EXPECT_GT(grazing.hits, 20);
  EXPECT_GT(grazing.misses, 10);
  EXPECT_GT(others.hits, 40);
  EXPECT_LE(aimed.worst, 1e-9);
  EXPECT_LT(grazing.in_band, (grazing.hits + grazing.misses) / 2);
}

/// Rays that almost follow the tube of a torus, `off` above or below its surface.
Ray following_ray(double minor, double off, Random& random) {
  const double turn = random.uniform(0, 6.3), tube = random.uniform(-1.5, 1.5);
  const Vec3 out{std::cos(turn), 0, std::sin(turn)};
  const Vec3 n{out.x * std::cos(tube), std::sin(tube), out.z * std::cos(tube)};
  const Vec3 along{-out.z, 0, out.x};
  const Vec3 d = along + cross(n, along) * (std::sqrt(minor) * random.power(-9, 0));
  return {Point3{} + out + n * (minor + off) - d * random.uniform(1.5, 3), d};
}

TEST_P(N07, RaysThatAlmostFollowTheTube) {
  Tally tally;
  Random random(107, seed());
  for (int64_t i = 0; i < ray_count(20000); ++i) {
    const double minor = std::pow(10, random.uniform(-8, -1));
    check(minor, following_ray(minor, 16 * kUnitRoundoff * random.power(0.5, 4), random), tally);
    if (testing::Test::HasFatalFailure()) {
      FAIL() << "seed " << seed() << " at " << i << " minor " << minor;
    }
  }
  EXPECT_GT(tally.hits, 40);
  EXPECT_GT(tally.misses, 40);
}

/// Of the thinnest tori the quartic hardly knows where it turns; the distance does ten times
/// better.
TEST(N07, TurningPointsOfThinToriAreSharpened) {
  Random random(207);
  int wrong = 0;
  for (int i = 0; i < 20000; ++i) {
    const double minor = random.uniform(2e-10, 4e-10);
    const Ray ray = following_ray(minor, random.power(-13, -12.3), random);
    TraversalCounters counters;
    wrong += Torus(1, minor).any_hit(ray, counters) == oracle(1, minor, ray).empty();
  }
  EXPECT_LE(wrong, 40);  // by the quartic alone some 120
}

TEST(N07, TurningPointsAreNotMistakenForOneAnother) {
  // From inside a horn torus beside its cusp: out, in and out again.
  Tally tally;
  check(1,
        {{0.0097359847286907254, 0.1947519696879326, 0.016494096145744451},
         {-0.17893890233359538, -0.92997714963096878, -0.3211282771664728}},
        tally);
  EXPECT_EQ(tally.hits, 1);
}

}  // namespace
}  // namespace tessera::numerics
