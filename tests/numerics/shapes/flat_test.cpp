// N05 for flat shapes and boxes: rays that graze them and their edges, against quad precision.
#include <gtest/gtest.h>

#include <functional>

#include "renderer/math/rounding.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/disc.h"
#include "renderer/shapes/half_plane.h"
#include "renderer/shapes/plane.h"
#include "tests/numerics/support.h"

namespace tessera::numerics {
namespace {

struct Flat {
  std::unique_ptr<Shape> shape;
  QuadVec anchor, normal;  ///< normal of any length
  double size = 0;
  /// How far inside the boundary an in-plane point is, relative to nothing: metres.
  std::function<Quad(const QuadVec&)> inside;
};

Quad inside_polygon(const std::vector<Point3>& points, const QuadVec& n, const QuadVec& p) {
  Quad nearest = 1e300;
  for (size_t i = 0; i < points.size(); ++i) {
    const QuadVec a(points[i]), edge = QuadVec(points[(i + 1) % points.size()]) - a;
    nearest = std::min(nearest, dot(cross(n, edge), p - a) / (length(n) * length(edge)));
  }
  return nearest;
}

Flat make_flat(int kind, Random& random) {
  Flat flat;
  const double size = std::abs(random.power(-4, 4));
  const Point3 c = Point3{} + random.direction() * (size * std::abs(random.power(-2, 3)));
  const Vec3 normal = random.direction() * std::abs(random.power(-3, 3));
  flat.size = size;
  flat.anchor = c;
  flat.normal = normal;
  if (kind == 0) {
    const double inner = random.next() & 1 ? 0 : size * random.uniform(0, 0.9);
    flat.shape = std::make_unique<Disc>(c, normal, size, inner);
    flat.inside = [=](const QuadVec& p) {
      const Quad r = length(p - QuadVec(c));
      return std::min<Quad>(size - r, inner > 0 ? r - inner : Quad(1e300));
    };
  } else if (kind == 1) {
    const Vec3 edge = random.direction();
    const QuadVec n(normal), e(edge);
    const QuadVec in_plane = e - n * (dot(n, e) / dot(n, n));
    flat.shape = std::make_unique<HalfPlane>(c, normal, edge);
    flat.inside = [=](const QuadVec& p) {
      return dot(p - QuadVec(c), in_plane) / length(in_plane);
    };
  } else if (kind == 4) {
    const Vec3 unit = normalize(normal);
    const double offset = dot(unit, c - Point3{});
    flat.shape = std::make_unique<Plane>(unit, offset);
    flat.normal = unit;
    flat.anchor = QuadVec(unit) * (offset / dot(QuadVec(unit), QuadVec(unit)));
    flat.inside = [](const QuadVec&) { return Quad(1e300); };
  } else {
    const Vec3 u = across(normal, random), v = normalize(cross(normal, u));
    std::vector<Point3> points;
    if (kind == 2) {
      const Vec3 eu = u * size, ev = v * (size * random.uniform(0.01, 1)) + u * (size * 0.3);
      points = {c, c + eu, c + eu + ev, c + ev};
      flat.shape = std::make_unique<Rectangle>(c, eu, ev);
      flat.normal = cross(QuadVec(eu), QuadVec(ev));
    } else {
      const int n = 3 + random.below(9);
      for (int i = 0; i < n; ++i) {
        const double turn = 2 * portable::kPi * i / n;
        points.push_back(c + u * (size * std::cos(turn)) + v * (size * std::sin(turn)));
      }
      flat.shape = std::make_unique<ConvexPolygon>(points);
      flat.anchor = points[0];
      flat.normal = QuadVec();
      for (int i = 2; i < n; ++i)
        flat.normal = flat.normal + cross(QuadVec(points[i - 1]) - QuadVec(points[0]),
                                          QuadVec(points[i]) - QuadVec(points[0]));
    }
    const QuadVec n = flat.normal;
    flat.inside = [=](const QuadVec& p) { return inside_polygon(points, n, p); };
  }
  return flat;
}

TEST(N05, FlatShapesAreHitWhereQuadPrecisionSaysSo) {
  int64_t hits = 0, misses = 0, in_band = 0;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(5, seed);
    for (int64_t i = 0; i < ray_count(500000); ++i) {
      const Flat flat = make_flat(static_cast<int>(i % 5), random);
      const Vec3 n =
          normalize(Vec3{static_cast<double>(flat.normal.x), static_cast<double>(flat.normal.y),
                         static_cast<double>(flat.normal.z)});
      const Point3 anchor{static_cast<double>(flat.anchor.x), static_cast<double>(flat.anchor.y),
                          static_cast<double>(flat.anchor.z)};
      // Aim at or very near to a place in the plane, at a grazing angle.
      const Vec3 u = across(n, random);
      const Point3 target = anchor + u * (flat.size * random.uniform(0, 2));
      const double angle = std::abs(random.power(-12, -0.1)) * (random.next() & 1 ? 1 : -1);
      const Vec3 d = normalize(across(n, random) + n * angle) * std::abs(random.power(-2, 2));
      const double far = flat.size * std::abs(random.power(-1, 4));
      const Ray ray{target - d * (far / length(d)), d};
      Hit hit;
      TraversalCounters counters;
      const bool found = flat.shape->closest_hit(ray, hit, counters);
      EXPECT_EQ(found, flat.shape->any_hit(ray, counters));
      const QuadVec o(ray.origin), qd(d);
      const Quad approach = dot(flat.normal, qd) / length(flat.normal);
      const Quad height = dot(flat.normal, o - flat.anchor) / length(flat.normal);
      const double scale = far + size_of(anchor) + 2 * flat.size;
      const Quad band = 16 * kUnitRoundoff * scale;
      if (fabsq(height) <= band || approach == 0) {
        ++in_band;
        continue;
      }
      const Quad t = -height / approach;
      const Quad cosine = fabsq(approach) / length(qd);
      const Quad inside = flat.inside(o + qd * t);
      // The line's own distance from the edge is the in-plane one seen under the grazing angle.
      if (fabsq(inside) * cosine <= band) {
        ++in_band;
        continue;
      }
      const bool expected = t > 0 && inside > 0;
      ASSERT_EQ(found, expected) << "seed " << seed << " at " << i << " kind " << i % 5;
      (expected ? hits : misses)++;
      if (!found) continue;
      ASSERT_LE(fabsq(hit.t - t) * length(qd) * cosine, band) << "seed " << seed << " at " << i;
      const LocalSurface s = flat.shape->surface(ray, hit);
      const QuadVec p(s.point);
      Quad allowed = 0;
      const Vec3 size = abs(n);
      allowed = dot(size, s.point_error);
      EXPECT_LE(fabsq(dot(flat.normal, p - flat.anchor) / length(flat.normal)), allowed);
      const Bounds3 box = flat.shape->bounds();
      for (int a = 0; a < 3; ++a)
        EXPECT_TRUE(s.point[a] >= box.min[a] - s.point_error[a] - 4e-16 * scale &&
                    s.point[a] <= box.max[a] + s.point_error[a] + 4e-16 * scale);
    }
  }
  EXPECT_GT(hits, 2000);
  EXPECT_GT(misses, 2000);
  RecordProperty("in_band", static_cast<int>(in_band));
}

/// Where the line enters and leaves the box grown by `grow`; enters after it leaves for a miss.
std::pair<Quad, Quad> box_stretch(const Bounds3& box, Quad grow, const Ray& ray) {
  Quad enter = -kQuadInfinity, leave = kQuadInfinity;
  for (int a = 0; a < 3; ++a) {
    const Quad o = ray.origin[a], d = ray.direction[a];
    const Quad low = Quad(box.min[a]) - grow, high = Quad(box.max[a]) + grow;
    if (d == 0) {
      if (o < low || o > high) return {1, 0};
      continue;
    }
    const Quad t0 = (low - o) / d, t1 = (high - o) / d;
    enter = std::max(enter, std::min(t0, t1)), leave = std::min(leave, std::max(t0, t1));
  }
  return {enter, leave};
}

TEST(N05, BoxesAreHitWhereQuadPrecisionSaysSo) {
  int64_t hits = 0, misses = 0;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(105, seed);
    for (int64_t i = 0; i < ray_count(500000); ++i) {
      const double size = std::abs(random.power(-4, 4));
      Bounds3 extent;
      for (int a = 0; a < 3; ++a) {
        extent.min[a] = size * random.uniform(-1, 1);
        extent.max[a] = extent.min[a] + size * std::abs(random.power(-6, 0));
      }
      // Along a face or an edge, but for an angle, at a place that is on it but for a little.
      Point3 target;
      for (int a = 0; a < 3; ++a) {
        const double share =
            random.below(2) ? random.below(2) + random.power(-16, -1) : random.uniform(-0.2, 1.2);
        target[a] = extent.min[a] + (extent.max[a] - extent.min[a]) * share;
      }
      Vec3 d{random.power(-12, 0), random.power(-12, 0), random.power(-12, 0)};
      if (random.below(8) == 0) d[random.below(3)] = 0;
      if (d == Vec3{}) continue;
      d = normalize(d);
      const Ray ray{target - d * (size * std::abs(random.power(-1, 6))), d};
      Hit hit;
      TraversalCounters counters;
      const Box box(extent);
      const bool found = box.closest_hit(ray, hit, counters);
      ASSERT_EQ(found, box.any_hit(ray, counters));
      const Quad band = 16 * kUnitRoundoff * (size_of(ray.origin) + 4 * size);
      const auto inner = box_stretch(extent, -band, ray), outer = box_stretch(extent, band, ray);
      const bool surely = inner.first < inner.second && inner.second > 0;
      const bool never = outer.first > outer.second || outer.second <= 0;
      if (surely) {
        ASSERT_TRUE(found) << "seed " << seed << " at " << i;
        ++hits;
      }
      if (never) {
        ASSERT_FALSE(found) << "seed " << seed << " at " << i;
        ++misses;
      }
      // The same side of the origin, or this is not the same crossing.
      if (!surely || (inner.first > 0) != (outer.first > 0)) continue;
      const bool enters = inner.first > 0;
      const Quad a = enters ? outer.first : inner.second, b = enters ? inner.first : outer.second;
      ASSERT_TRUE(hit.t >= a && hit.t <= b) << "seed " << seed << " at " << i;
    }
  }
  EXPECT_GT(hits, 2000);
  EXPECT_GT(misses, 2000);
}

}  // namespace
}  // namespace tessera::numerics
