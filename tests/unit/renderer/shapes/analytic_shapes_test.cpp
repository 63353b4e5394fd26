#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <typeinfo>
#include <vector>

#include "base/error.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/disc.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/half_plane.h"
#include "renderer/shapes/torus.h"

namespace tessera {
namespace {

Hit closest(const Shape& shape, const Ray& ray) {
  Hit hit;
  TraversalCounters counters;
  const bool found = shape.closest_hit(ray, hit, counters);
  EXPECT_EQ(found, shape.any_hit(ray, counters));
  EXPECT_EQ(found, hit.t < Bounds3::kInfinity);
  return hit;
}

bool hits(const Shape& shape, const Ray& ray) { return closest(shape, ray).t < Bounds3::kInfinity; }

LocalSurface seen(const Shape& shape, const Ray& ray) {
  const Hit hit = closest(shape, ray);
  EXPECT_TRUE(std::isfinite(hit.t));
  return shape.surface(ray, hit);
}

void expect_near(const Vec3& a, const Vec3& b, double within) {
  EXPECT_NEAR(a.x, b.x, within);
  EXPECT_NEAR(a.y, b.y, within);
  EXPECT_NEAR(a.z, b.z, within);
}

void expect_uv(const Shape& shape, const Ray& ray, double u, double v) {
  const LocalSurface s = seen(shape, ray);
  EXPECT_NEAR(s.uv.x, u, 1e-12);
  EXPECT_NEAR(s.uv.y, v, 1e-12);
}

std::vector<std::shared_ptr<const Shape>> all_shapes() {
  return {std::make_shared<Disc>(Point3{0.1, 0.2, 0.3}, Vec3{1, 2, 3}, 1.5, 0.4),
          std::make_shared<HalfPlane>(Point3{0.1, 0.2, 0.3}, Vec3{1, -2, 3}, Vec3{1, 0.2, 0}),
          std::make_shared<Rectangle>(Point3{-1, -0.5, 0}, Vec3{2, 0.3, 0.1}, Vec3{0.2, 1, 1}),
          std::make_shared<ConvexPolygon>(
              std::vector<Point3>{{-1, -1, 0}, {1, -1, 0}, {1.5, 0.5, 0}, {0, 1.5, 0}}),
          std::make_shared<Cylinder>(0.8, 1.5),
          std::make_shared<Cone>(1, 1.5),
          std::make_shared<Cone>(1, 1.5, 0.4),
          std::make_shared<Torus>(1, 0.3),
          std::make_shared<Torus>(0.5, 0.8)};
}

/// Rays from all sides through a box about the shape.
std::vector<Ray> rays_about(const Shape& shape) {
  Bounds3 box = shape.bounds();
  if (!std::isfinite(box.min.x)) box = {{-1, -1, -1}, {1, 1, 1}};
  std::vector<Ray> rays;
  for (int i = 0; i < 500; ++i) {
    const double a = 0.61803398875 * i, b = 0.7548776662 * i, c = 0.5698402910 * i;
    const Vec3 f{a - std::floor(a), b - std::floor(b), c - std::floor(c)};
    const Vec3 size = box.diagonal();
    const Point3 to = box.min + Vec3{f.x * size.x, f.y * size.y, f.z * size.z};
    const Vec3 d = normalize(Vec3{std::sin(1.0 * i), std::cos(2.3 * i), std::sin(0.7 * i + 1)});
    rays.push_back({to - d * 4, d});
  }
  return rays;
}

TEST(AnalyticShapes, DerivativesAreThoseOfThePointByUv) {
  for (const auto& shape : all_shapes()) {
    int compared = 0;
    for (const Ray& ray : rays_about(*shape)) {
      const Hit hit = closest(*shape, ray);
      if (!std::isfinite(hit.t)) continue;
      const LocalSurface s = shape->surface(ray, hit);
      EXPECT_NEAR(dot(s.geometric_normal, s.dpdu), 0, 1e-9);
      EXPECT_NEAR(dot(s.geometric_normal, s.dpdv), 0, 1e-9);
      // A step in the tangent plane, looked at again from above the surface.
      constexpr double kStep = 1e-5;
      for (const Vec3& along : {normalize(s.dpdu), normalize(s.dpdv)}) {
        const Vec3 n = static_cast<Vec3>(s.geometric_normal);
        const Ray near{s.point + along * kStep + n * 1e-3, -n};
        const Hit near_hit = closest(*shape, near);
        if (!std::isfinite(near_hit.t) || near_hit.primitive != hit.primitive) continue;
        const LocalSurface q = shape->surface(near, near_hit);
        const double du = q.uv.x - s.uv.x, dv = q.uv.y - s.uv.y;
        if (std::abs(du) > 0.5 || std::abs(dv) > 0.5) continue;  // over a seam
        const Vec3 moved = s.dpdu * du + s.dpdv * dv;
        EXPECT_LT(length(moved - (q.point - s.point)), 2e-3 * kStep + 1e-9);
        ++compared;
      }
    }
    EXPECT_GT(compared, 50);
  }
}

TEST(AnalyticShapes, BoundsHoldEveryHitAndNoRayHitsOutsideOfThem) {
  for (const auto& shape : all_shapes()) {
    const Bounds3 box = shape->bounds();
    for (const Ray& ray : rays_about(*shape)) {
      const Hit hit = closest(*shape, ray);
      if (!std::isfinite(hit.t)) continue;
      const LocalSurface s = shape->surface(ray, hit);
      EXPECT_TRUE(box.contains(s.point));
      EXPECT_LT(length(s.point - ray.at(hit.t)), 1e-12);
      EXPECT_NEAR(length(static_cast<Vec3>(s.geometric_normal)), 1, 1e-15);
    }
  }
}

TEST(AnalyticShapes, CullingHidesTheSideNamed) {
  for (const auto& shape : all_shapes()) {
    int both = 0;
    for (Ray ray : rays_about(*shape)) {
      ray.cull = Cull::none;
      const Hit any = closest(*shape, ray);
      ray.cull = Cull::back;
      const Hit front = closest(*shape, ray);
      ray.cull = Cull::front;
      const Hit back = closest(*shape, ray);
      EXPECT_EQ(any.t, std::min(front.t, back.t));
      if (std::isfinite(front.t)) {
        EXPECT_LT(dot(shape->surface(ray, front).geometric_normal, ray.direction), 0);
      }
      if (std::isfinite(back.t)) {
        EXPECT_GT(dot(shape->surface(ray, back).geometric_normal, ray.direction), 0);
      }
      both += std::isfinite(any.t);
    }
    EXPECT_GT(both, 30);
  }
}

TEST(AnalyticShapes, TheStretchOfTheRayAndTheHitAtHandCount) {
  for (const auto& shape : all_shapes()) {
    for (Ray ray : rays_about(*shape)) {
      const Hit first = closest(*shape, ray);
      if (!std::isfinite(first.t)) continue;
      ray.t_max = first.t;
      EXPECT_FALSE(hits(*shape, ray));
      ray.t_max = Bounds3::kInfinity;
      ray.t_min = first.t;
      EXPECT_GT(closest(*shape, ray).t, first.t);
      ray.t_min = 0;
      TraversalCounters counters;
      Hit same = first;
      EXPECT_FALSE(shape->closest_hit(ray, same, counters));
      same.primitive = first.primitive + 1;
      same.instance = 9;
      EXPECT_TRUE(shape->closest_hit(ray, same, counters));
      EXPECT_EQ(same.primitive, first.primitive);
      EXPECT_EQ(same.instance, 9u);
    }
  }
}

TEST(AnalyticShapes, NothingThatIsNotFiniteIsHit) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& shape : all_shapes()) {
    const Shape& shown = *shape;
    for (const double bad : {kNan, Bounds3::kInfinity, -Bounds3::kInfinity}) {
      for (int axis = 0; axis < 3; ++axis) {
        Ray ray{{0.3, 0.4, 5}, {0.01, 0.02, -1}};
        ray.origin[axis] = bad;
        EXPECT_FALSE(hits(*shape, ray)) << typeid(shown).name() << " " << bad << " " << axis;
        ray = {{0.3, 0.4, 5}, {0.01, 0.02, -1}};
        ray.direction[axis] = bad;
        EXPECT_FALSE(hits(*shape, ray)) << typeid(shown).name() << " " << bad << " " << axis;
      }
    }
    EXPECT_FALSE(hits(*shape, {{0.3, 0.4, 5}, {0, 0, 0}}));
  }
}

TEST(Cylinder, TexturesAsX3dMapsThem) {
  const Cylinder c(2, 4);
  expect_uv(c, {{0, 0, 9}, {0, 0, -1}}, 0.5, 0.5);    // front
  expect_uv(c, {{9, 1, 0}, {-1, 0, 0}}, 0.75, 0.75);  // right, a quarter up
  expect_uv(c, {{-9, -2 + 1e-13, 0}, {1, 0, 0}}, 0.25, 0);
  expect_uv(c, {{1, 9, 0}, {0, -1, 0}}, 0.75, 0.5);  // top: up is -z
  expect_uv(c, {{0, 9, -1}, {0, -1, 0}}, 0.5, 0.75);
  expect_uv(c, {{0, -9, 1}, {0, 1, 0}}, 0.5, 0.75);  // bottom: up is +z
  EXPECT_EQ(closest(c, {{0, 0, 9}, {0, 0, -1}}).primitive, 0u);
  EXPECT_EQ(closest(c, {{0, 9, 0}, {0, -1, 0}}).primitive, 1u);
  EXPECT_EQ(closest(c, {{0, -9, 0}, {0, 1, 0}}).primitive, 2u);
}

TEST(Cylinder, PartsLeftOutShowTheInside) {
  const Cylinder open_top(1, 2, {.top = true});
  const Ray down{{0.5, 5, 0}, {0, -1, 0}};
  EXPECT_EQ(closest(open_top, down).primitive, 2u);
  EXPECT_DOUBLE_EQ(closest(open_top, down).t, 6);
  expect_near(static_cast<Vec3>(seen(open_top, down).geometric_normal), {0, -1, 0}, 0);
  EXPECT_FALSE(hits(open_top, {down.origin, down.direction, 0, 100, Cull::back}));
  const Cylinder tube(1, 2, {.top = true, .bottom = true});
  EXPECT_FALSE(hits(tube, down));
  const Cylinder caps(1, 2, {.side = true});
  EXPECT_FALSE(hits(caps, {{5, 0, 0}, {-1, 0, 0}}));
  EXPECT_TRUE(hits(caps, down));
  EXPECT_FALSE(tube.closed());
  EXPECT_TRUE(Cylinder(1, 2).closed());
}

TEST(Cone, ApexIsUpAndBaseDown) {
  const Cone cone(1, 2);
  const Ray at_half{{0, 0, 9}, {0, 0, -1}};
  EXPECT_DOUBLE_EQ(closest(cone, at_half).t, 8.5);
  const LocalSurface s = seen(cone, at_half);
  expect_near(static_cast<Vec3>(s.geometric_normal), normalize(Vec3{0, 0.5, 1}), 1e-15);
  EXPECT_NEAR(s.uv.y, 0.5, 1e-15);
  EXPECT_EQ(closest(cone, {{0.5, 9, 0}, {0, -1, 0}}).primitive, 0u);
  EXPECT_DOUBLE_EQ(closest(cone, {{0.5, 9, 0}, {0, -1, 0}}).t, 9);
  EXPECT_EQ(closest(cone, {{0.5, -9, 0}, {0, 1, 0}}).primitive, 2u);
  EXPECT_DOUBLE_EQ(closest(cone, {{0, 9, 0}, {0, -1, 0}}).t, 8);
  EXPECT_FALSE(hits(cone, {{0, 1.001, 9}, {0, 0, -1}}));  // not the other nappe
  EXPECT_FALSE(hits(cone, {{5, 3, 0}, {-1, 0, 0}}));
  const Cone frustum(1, 2, 0.5);
  EXPECT_EQ(closest(frustum, {{0.4, 9, 0}, {0, -1, 0}}).primitive, 1u);
  EXPECT_EQ(closest(frustum, {{0.6, 9, 0}, {0, -1, 0}}).primitive, 0u);
  // Along a generator, through the base to nowhere else.
  EXPECT_DOUBLE_EQ(closest(cone, {{0.25, -2, 0}, {-0.5, 1, 0}}).t, 1);
}

TEST(Torus, RingHornAndSpindle) {
  const Torus ring(1, 0.25);
  EXPECT_DOUBLE_EQ(closest(ring, {{5, 0, 0}, {-1, 0, 0}}).t, 3.75);
  EXPECT_DOUBLE_EQ(closest(ring, {{0, 0, 0}, {0, 0, 1}}).t, 0.75);
  EXPECT_FALSE(hits(ring, {{0, 5, 0}, {0, -1, 0}}));
  EXPECT_DOUBLE_EQ(closest(ring, {{1, 5, 0}, {0, -1, 0}}).t, 4.75);
  const Torus spindle(0.6, 1);
  // Down the axis: the dimple is sqrt(1 - 0.36) above the centre; no inner sheet.
  Ray axis{{0, 5, 0}, {0, -1, 0}};
  EXPECT_NEAR(closest(spindle, axis).t, 4.2, 1e-15);
  axis.t_min = 4.3;
  EXPECT_NEAR(closest(spindle, axis).t, 5.8, 1e-15);
  const LocalSurface s = seen(ring, {{5, 0, 0}, {-1, 0, 0}});
  expect_near(static_cast<Vec3>(s.geometric_normal), {1, 0, 0}, 1e-15);
  EXPECT_NEAR(s.uv.x, 0.75, 1e-15);
  EXPECT_NEAR(s.uv.y, 0.5, 1e-15);
}

TEST(Disc, HoleRimAndTexture) {
  const Disc disc({0, 0, 1}, {0, 0, 2}, 2, 1);
  EXPECT_TRUE(hits(disc, {{1.5, 0, 5}, {0, 0, -1}}));
  EXPECT_FALSE(hits(disc, {{0.5, 0, 5}, {0, 0, -1}}));
  EXPECT_FALSE(hits(disc, {{2.001, 0, 5}, {0, 0, -1}}));
  EXPECT_TRUE(hits(disc, {{2, 0, 5}, {0, 0, -1}}));
  expect_uv(disc, {{2, 0, 5}, {0, 0, -1}}, 1, 0.5);
  expect_uv(disc, {{0, 1, 5}, {0, 0, -1}}, 0.5, 0.75);
}

TEST(FlatShapes, EdgesBelongToThemAndNeighboursLeaveNoCrack) {
  const Rectangle left({-1, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const Rectangle right({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const ConvexPolygon above_left({{-1, 1, 0}, {0, 1, 0}, {0, 2, 0}, {-0.5, 2, 0}});
  const ConvexPolygon above_right({{0, 1, 0}, {1, 1, 0}, {0, 2, 0}});
  for (int i = 0; i < 2000; ++i) {
    const double x = std::sin(1.7 * i) * 3, y = std::cos(0.9 * i) * 3, z = 1 + std::sin(i) * 0.9;
    const Point3 on{i % 2 ? 0 : std::sin(2.1 * i), i % 2 ? 0.5 + 0.4 * std::sin(3.0 * i) : 1, 0};
    const Ray ray{{x, y, z}, on - Point3{x, y, z}};
    EXPECT_TRUE(hits(left, ray) || hits(right, ray) || hits(above_left, ray) ||
                hits(above_right, ray))
        << i;
  }
  expect_uv(left, {{-0.25, 0.75, 3}, {0, 0, -1}}, 0.75, 0.75);
}

TEST(HalfPlane, EndsAtItsEdge) {
  const HalfPlane floor({0, 1, 0}, {0, 3, 0}, {2, 1, 0});
  EXPECT_TRUE(hits(floor, {{0.001, 5, 7}, {0, -1, 0}}));
  EXPECT_TRUE(hits(floor, {{1e9, 5, 7}, {0, -1, 0}}));
  EXPECT_FALSE(hits(floor, {{-0.001, 5, 7}, {0, -1, 0}}));
  EXPECT_TRUE(hits(floor, {{0.001, -5, 7}, {0, 1, 0}}));
  EXPECT_FALSE(hits(floor, {{-0.001, -5, 7}, {0, 1, 0}}));
}

TEST(AnalyticShapes, WrongSizesAreErrors) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Disc({}, {0, 0, 0}, 1), Error);
  EXPECT_THROW(Disc({}, {0, 0, 1}, 0), Error);
  EXPECT_THROW(Disc({}, {0, 0, 1}, 1, 1), Error);
  EXPECT_THROW(Disc({}, {0, kNan, 1}, 1), Error);
  EXPECT_THROW(HalfPlane({}, {0, 1, 0}, {0, 2, 0}), Error);
  EXPECT_THROW(Rectangle({}, {1, 0, 0}, {2, 0, 0}), Error);
  EXPECT_THROW(Cylinder(0, 1), Error);
  EXPECT_THROW(Cylinder(1, kNan), Error);
  EXPECT_THROW(Cone(1, -1), Error);
  EXPECT_THROW(Torus(1, 0), Error);
  EXPECT_THROW(Torus(kNan, 1), Error);
  EXPECT_THROW(ConvexPolygon({{0, 0, 0}, {1, 0, 0}}), Error);
  EXPECT_THROW(ConvexPolygon({{0, 0, 0}, {2, 0, 0}, {1, 0.5, 0}, {1, 2, 0}}), Error);
  EXPECT_THROW(ConvexPolygon({{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5}, {0, 1, 0}}), Error);
  // A pentagram winds twice.
  std::vector<Point3> star;
  for (int i = 0; i < 5; ++i) star.push_back({std::cos(2.513274 * i), std::sin(2.513274 * i), 0});
  EXPECT_EQ(ConvexPolygon::fault_of(star), "a polygon that is not convex");
  const std::vector<Point3> bent{{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5}, {0, 1, 0}};
  EXPECT_EQ(ConvexPolygon::fault_of(bent), "a point of a polygon that is 0.236 m off its plane");
}

}  // namespace
}  // namespace tessera
