// The normal of every shape against three of its points: where rays beside each other meet it.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "renderer/accel/linear_scan.h"
#include "renderer/accel/mesh_shape.h"
#include "renderer/math/frame.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/disc.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/half_plane.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/surface_interaction.h"
#include "renderer/shapes/torus.h"
#include "tests/uniform_numbers.h"

namespace tessera {
namespace {

struct Case {
  std::string name;
  std::shared_ptr<const Shape> shape;
  bool is_closed;
};

std::shared_ptr<const Shape> tetrahedron() {
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->positions = {{-1, -1, -0.6F}, {1, -1, -0.5F}, {0, 1.2F, -0.4F}, {0.1F, 0.2F, 1}};
  mesh->triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return std::make_shared<MeshShape>(mesh, std::make_unique<MeshLinearScan>(mesh));
}

std::vector<Case> cases() {
  return {
      {"sphere", std::make_shared<Sphere>(Point3{0.1, 0.2, 0}, 0.9), true},
      {"box", std::make_shared<Box>(Bounds3{{-0.9, -0.4, -0.5}, {0.3, 0.7, 0.6}}), true},
      {"cylinder", std::make_shared<Cylinder>(0.8, 1.5), true},
      {"cone", std::make_shared<Cone>(1, 1.5), true},
      {"stump", std::make_shared<Cone>(1, 1.5, 0.4), true},
      {"torus", std::make_shared<Torus>(0.8, 0.3), true},
      {"tetrahedron", tetrahedron(), true},
      {"plane", std::make_shared<Plane>(Vec3{0.3, 1, -0.4}, 0.2), false},
      {"half-plane", std::make_shared<HalfPlane>(Point3{0, 0, 0}, Vec3{1, -2, 3}, Vec3{1, 0.2, 0}),
       false},
      {"disc", std::make_shared<Disc>(Point3{0, 0, 0}, Vec3{1, 2, 3}, 0.9, 0.2), false},
      {"rectangle",
       std::make_shared<Rectangle>(Point3{-1, -0.5, 0}, Vec3{2, 0.3, 0.1}, Vec3{0.2, 1, 1}), false},
      {"polygon",
       std::make_shared<ConvexPolygon>(
           std::vector<Point3>{{-1, -1, 0}, {1, -1, 0}, {1.5, 0.5, 0}, {0, 1.5, 0}}),
       false}};
}

/// Where the ray meets the shape, in the world.
bool meets(const Case& c, const Transform& place, const Ray& ray, Hit& hit, SurfaceInteraction& s) {
  TraversalCounters counters;
  hit = {};
  Ray local = ray;
  local.origin = place.inverse_point(ray.origin);
  local.direction = place.inverse_vector(ray.direction);
  if (!c.shape->closest_hit(local, hit, counters)) return false;
  s = to_world(c.shape->surface(local, hit), place, false, 0);
  return true;
}

TEST(Shapes, NormalsAreThoseOfThreeOfTheirPoints) {
  const Affine turned = translation({0.3, 0.1, -0.2}) * rotation({1, 2, 3}, 0.7);
  for (const Affine& to_world : {Affine{}, turned * scaling({-1.5, 1, 0.5})}) {
    const Transform place(to_world);
    for (const Case& c : cases()) {
      UniformNumbers random(5);
      int compared = 0;
      for (int i = 0; i < 400; ++i) {
        const auto number = [&] { return 2 * random() - 1; };
        const double x = number(), y = number(), z = number(), p = number(), q = number(),
                     r = number();
        const Vec3 d = normalize(Vec3{p, q, r});
        const Point3 from = place.point({x, y, z}) - d * 6;
        const Frame frame(d);
        constexpr double kStep = 1e-5;
        Hit hits[3];
        SurfaceInteraction s[3];
        const Ray rays[] = {{from, d}, {from + frame.x * kStep, d}, {from + frame.y * kStep, d}};
        bool all = true;
        for (int k = 0; k < 3; ++k) all = meets(c, place, rays[k], hits[k], s[k]) && all;
        if (!all || hits[0].primitive != hits[1].primitive ||
            hits[0].primitive != hits[2].primitive)
          continue;
        const Vec3 n = static_cast<Vec3>(s[0].geometric_normal);
        if (std::abs(dot(n, d)) < 0.1) continue;  // grazing: the three points are far apart
        const Vec3 truth = normalize(cross(s[1].point - s[0].point, s[2].point - s[0].point));
        EXPECT_LT(length(cross(truth, n)), 1e-3) << c.name << ", ray " << i;
        EXPECT_NEAR(length(n), 1, 1e-12) << c.name;
        // Out of a solid: a ray from outside comes against it.
        EXPECT_TRUE(!c.is_closed || dot(n, d) < 0) << c.name << ", ray " << i;
        ++compared;
      }
      EXPECT_GT(compared, 50) << c.name;
    }
  }
}

TEST(Shapes, FrontsAreWhereTheyAreSaidToBe) {
  const auto front = [](const Shape& shape, const Ray& ray) {
    TraversalCounters counters;
    Hit hit;
    EXPECT_TRUE(shape.closest_hit(ray, hit, counters));
    return static_cast<Vec3>(shape.surface(ray, hit).geometric_normal);
  };
  const Ray down{{0.1, 0.2, 5}, {0, 0, -1}};
  const Vec3 n = normalize(Vec3{0.2, -0.3, 1});
  EXPECT_LT(length(front(Plane(n, 0.2), down) - n), 1e-12);
  EXPECT_LT(length(front(Plane(-n, 0.2), down) + n), 1e-12);
  EXPECT_LT(length(front(HalfPlane({-9, 0, 0}, n, {1, 0, 0}), down) - n), 1e-12);
  EXPECT_LT(length(front(Disc({0, 0, 0}, -n, 3), down) + n), 1e-12);
  const Vec3 u{2, 0, 0}, v{0, 2, 0.5};
  EXPECT_LT(length(front(Rectangle({-1, -1, 0}, u, v), down) - normalize(cross(u, v))), 1e-12);
  EXPECT_GT(front(ConvexPolygon({{-1, -1, 0}, {1, -1, 0}, {0, 2, 0}}), down).z, 0);
  EXPECT_LT(front(ConvexPolygon({{0, 2, 0}, {1, -1, 0}, {-1, -1, 0}}), down).z, 0);
}

}  // namespace
}  // namespace tessera
