// N05, N06 for cylinders, cones and frusta: far, tiny, huge, grazing, against quad precision.
#include <gtest/gtest.h>

#include "renderer/math/rounding.h"
#include "renderer/shapes/frustum.h"
#include "tests/numerics/support.h"

namespace tessera::numerics {
namespace {

struct Stretch {
  bool found = false;
  Quad enter = 0, leave = 0;
};

/// Where the line is inside the frustum grown by `grow` on every side.
Stretch oracle(Quad bottom, Quad top, Quad height, Quad grow, const Ray& ray) {
  const QuadVec o(ray.origin), d(ray.direction);
  Stretch s;
  Quad enter = -kQuadInfinity, leave = kQuadInfinity;
  const Quad slope = (top - bottom) / height;
  const Quad mean = (top + bottom) / 2 + grow * sqrtq(1 + slope * slope);
  // Up to the apex of the grown cone, lest its other nappe comes in.
  Quad low = -height / 2 - grow, high = height / 2 + grow;
  if (slope < 0) high = std::min(high, -mean / slope);
  if (slope > 0) low = std::max(low, -mean / slope);
  if (d.y == 0) {
    if (o.y < low || o.y > high) return s;
  } else {
    const Quad t0 = (low - o.y) / d.y, t1 = (high - o.y) / d.y;
    enter = std::min(t0, t1), leave = std::max(t0, t1);
  }
  const Quad r = mean + slope * o.y, dr = slope * d.y;
  const Quad a = d.x * d.x + d.z * d.z - dr * dr, b = o.x * d.x + o.z * d.z - r * dr;
  const Quad c = o.x * o.x + o.z * o.z - r * r;
  const Quad disc = b * b - a * c;
  Quad in = -kQuadInfinity, out = kQuadInfinity;
  if (a == 0) {
    if (b == 0) {
      if (c > 0) return s;
    } else {
      const Quad t = -c / (2 * b);
      (dr > 0 ? in : out) = t;
    }
  } else {
    if (disc < 0) return s;
    const Quad q = -(b < 0 ? b - sqrtq(disc) : b + sqrtq(disc));
    Quad t0 = q == 0 ? 0 : q / a, t1 = q == 0 ? 0 : c / q;
    if (t0 > t1) std::swap(t0, t1);
    if (a > 0)
      in = t0, out = t1;
    else if (dr > 0)
      in = t1;
    else
      out = t0;
  }
  s.enter = std::max(enter, in), s.leave = std::min(leave, out);
  s.found = s.enter <= s.leave;
  return s;
}

Quad first_ahead(const Stretch& s) {
  return !s.found || s.leave <= 0 ? kQuadInfinity : s.enter > 0 ? s.enter : s.leave;
}

std::string describe(double r, double h, double top, const Ray& ray) {
  char text[300];
  std::snprintf(text, sizeof text, " r %.17g h %.17g top %.17g o {%a, %a, %a} d {%a, %a, %a} ", r,
                h, top, ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y,
                ray.direction.z);
  return text;
}

TEST(N06, FrustaAreHitWhereQuadPrecisionSaysSo) {
  int64_t hits = 0, misses = 0, in_band = 0;
  double worst[3] = {};
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(6, seed);
    for (int64_t i = 0; i < ray_count(1000000); ++i) {
      const double r = std::abs(random.power(-6, 6));
      const double h = r * std::abs(random.power(-2, 2));
      const int kind = static_cast<int>(i % 3);
      const double top = kind == 0 ? r : kind == 1 ? 0 : r * random.uniform(0.1, 2);
      const std::unique_ptr<Frustum> shape = kind == 0
                                                 ? std::unique_ptr<Frustum>(new Cylinder(r, h))
                                                 : std::unique_ptr<Frustum>(new Cone(r, h, top));
      const double size = std::max(r, top) + 0.5 * h;
      const double far = size * std::pow(10.0, random.uniform(0.005, 8));
      // A point of the side, moved out a little, and a direction tangent there but for an angle.
      const double turn = random.uniform(0, 6.3), y = random.uniform(-0.5, 0.5) * h;
      const double here = 0.5 * (r + top) + (top - r) / h * y;
      const double share = random.next() & 1 ? 1 + random.power(-16, -1) : random.uniform(0, 1.2);
      const Vec3 out{std::cos(turn), 0, std::sin(turn)};
      const Point3 target{out.x * here * share, y, out.z * here * share};
      Vec3 d;
      switch (random.below(4)) {
        case 0:
          d = random.direction();
          break;
        case 1:
          d = normalize(Vec3{-out.z, random.uniform(-1, 1), out.x} + out * random.power(-12, -1));
          break;
        case 2:
          d = normalize(Vec3{out.x * (top - r) / h, 1, out.z * (top - r) / h} +
                        random.direction() * std::abs(random.power(-12, -1)));
          break;
        default:
          d = normalize(Vec3{random.power(-12, 0), random.power(-12, 0), random.power(-12, 0)});
      }
      const double where = random.below(4) == 0 ? random.uniform(-2, 2) * size : far;
      const Ray ray{target - d * where, d * std::abs(random.power(-2, 2))};
      const double distance = size_of(ray.origin) + size;
      const double speed = length(ray.direction);
      Hit hit;
      TraversalCounters counters;
      const bool found = shape->closest_hit(ray, hit, counters);
      ASSERT_EQ(found, shape->any_hit(ray, counters));
      // Roots come out to a rounding of t, so that the band grows slowly with the distance.
      const Quad band = kUnitRoundoff * (16 * size + 2 * distance);
      const Stretch inner = oracle(r, top, h, -band, ray), outer = oracle(r, top, h, band, ray);
      const bool surely =
          first_ahead(inner) < kQuadInfinity && (inner.enter > 0) == (outer.enter > 0);
      const bool never = first_ahead(outer) == kQuadInfinity;
      if (surely) {
        ASSERT_TRUE(found) << "seed " << seed << " at " << i << " kind " << kind
                           << describe(r, h, top, ray) << (double)inner.enter << " "
                           << (double)inner.leave << " " << (double)outer.enter << " "
                           << (double)outer.leave;
        ++hits;
      }
      if (never) {
        ASSERT_FALSE(found) << "seed " << seed << " at " << i << " kind " << kind;
        ++misses;
      }
      if (!surely && !never) ++in_band;
      if (!surely) continue;
      // |dt| <= 4 u D / cos is the move of the surface by 4 u D.
      const Quad move = 4 * kUnitRoundoff * distance;
      const Stretch early = oracle(r, top, h, move, ray), late = oracle(r, top, h, -move, ray);
      if (!late.found || (early.enter > 0) != (late.enter > 0)) continue;
      const Quad low = std::min(first_ahead(early), first_ahead(late));
      const Quad high = std::max(first_ahead(early), first_ahead(late));
      const Quad slack = 2 * kUnitRoundoff * fabsq(hit.t);
      ASSERT_TRUE(hit.t >= low - slack && hit.t <= high + slack)
          << "seed " << seed << " at " << i << " kind " << kind << " t " << hit.t << " in ["
          << describe(r, h, top, ray) << static_cast<double>(low) << ", "
          << static_cast<double>(high) << "]";
      const Quad exact = first_ahead(oracle(r, top, h, 0, ray));
      worst[kind] =
          std::max(worst[kind], static_cast<double>(fabsq(hit.t - exact) * speed / distance));
    }
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(misses, 1000);
  for (const double w : worst) EXPECT_LT(w, 4 * std::sqrt(kUnitRoundoff));
  RecordProperty("in_band", static_cast<int>(in_band));
}

TEST(N22, FrustaScaleByPowersOfTwoToTheBit) {
  Random random(22);
  for (int64_t i = 0; i < ray_count(1000000); ++i) {
    const double r = random.uniform(0.1, 2), h = random.uniform(0.1, 2), top = random.uniform(0, 2);
    const double k = std::ldexp(1, random.below(81) - 40);
    const Point3 o = Point3{} + random.direction() * random.uniform(0, 10);
    const Vec3 d = random.direction();
    Hit a, b;
    TraversalCounters counters;
    const bool found = Cone(r, h, top).closest_hit({o, d}, a, counters);
    const Point3 scaled{o.x * k, o.y * k, o.z * k};
    ASSERT_EQ(found, Cone(r * k, h * k, top * k).closest_hit({scaled, d}, b, counters));
    if (found) {
      ASSERT_EQ(a.t * k, b.t);
    }
    // Mirrored in y, and turned by a right angle.
    Hit c;
    ASSERT_EQ(found,
              Cone(top, h, r).closest_hit({{o.z, -o.y, -o.x}, {d.z, -d.y, -d.x}}, c, counters));
    if (found) {
      ASSERT_NEAR(a.t, c.t, 4e-15 * (1 + a.t));
    }
  }
}

}  // namespace
}  // namespace tessera::numerics
