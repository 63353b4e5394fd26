#include "renderer/shapes/surface_sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "renderer/shapes/box.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/disc.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/torus.h"

namespace tessera {
namespace {

constexpr double kPi = std::numbers::pi;

struct Case {
  std::string name;
  std::shared_ptr<const Shape> shape;
};

std::vector<Case> cases() {
  return {{"sphere", std::make_shared<Sphere>(Point3{0.2, 0.1, 0}, 0.7)},
          {"disc", std::make_shared<Disc>(Point3{0, 0, 0}, Vec3{0.3, 1, 0.2}, 0.8)},
          {"ring", std::make_shared<Disc>(Point3{0, 0, 0}, Vec3{0, 0, 1}, 0.8, 0.5)},
          {"rectangle",
           std::make_shared<Rectangle>(Point3{-0.5, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1.2, 0.4})},
          {"parallelogram",
           std::make_shared<Rectangle>(Point3{-0.5, 0, 0}, Vec3{1, 0, 0}, Vec3{0.5, 1.2, 0})},
          {"polygon", std::make_shared<ConvexPolygon>(std::vector<Point3>{
                          {0, 0, 0}, {1, 0, 0}, {1.4, 0.7, 0}, {0.5, 1.2, 0}, {-0.2, 0.6, 0}})},
          {"box", std::make_shared<Box>(Bounds3{{-0.3, -0.4, -0.5}, {0.3, 0.2, 0.6}})}};
}

/// The solid angle of the front, by tracing rays to all sides.
double solid_angle(const Shape& shape, const Transform& world_from_object, const Point3& from) {
  constexpr int kSide = 900;
  TraversalCounters counters;
  int hits = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double z = 2 * (i / kSide + 0.5) / kSide - 1, phi = 2 * kPi * (i % kSide + 0.5) / kSide;
    const double r = std::sqrt(1 - z * z);
    Ray ray;
    ray.origin = world_from_object.inverse_point(from);
    ray.direction = world_from_object.inverse_vector({r * std::cos(phi), r * std::sin(phi), z});
    Hit hit;
    if (shape.closest_hit(ray, hit, counters)) ++hits;
  }
  return hits * 4 * kPi / (kSide * kSide);
}

TEST(SurfaceSampler, PointsLieOnTheSurfaceAndTheirDensitiesAddUp) {
  const Affine turned = translation({3, 1, -2}) * rotation({1, 2, 3}, 0.7);
  for (const Affine& to_world :
       {Affine{}, turned, turned * scaling({2, 2, 2}), turned * scaling({-1.5, 1, 0.5})}) {
    const Transform transform(to_world);
    for (const Case& c : cases()) {
      const auto sampler = make_surface_sampler(*c.shape, transform, false);
      const bool is_stretched = to_world.determinant() < 0;
      if (c.name == "sphere" && is_stretched) {
        EXPECT_EQ(sampler, nullptr) << "an ellipsoid is found by paths alone";
        continue;
      }
      ASSERT_NE(sampler, nullptr) << c.name;
      for (const Point3& local : {Point3{1.5, 2, 3}, Point3{-0.1, 0.3, 0.9}, Point3{12, -30, 25}}) {
        const Point3 from = to_world(local);
        SCOPED_TRACE(c.name);
        constexpr int kSide = 160;
        double sum = 0;
        int outside = 0;
        TraversalCounters counters;
        for (int i = 0; i < kSide * kSide; ++i) {
          // Roberts' R2 sequence: even in both, whatever u is cut into.
          const Vec2 u{std::fmod(i * 0.7548776662466927, 1), std::fmod(i * 0.5698402909980532, 1)};
          SurfaceSample sample;
          const double density = sampler->sample(from, u, sample);
          ASSERT_GT(density, 0);
          ASSERT_NEAR(length(sample.normal), 1, 1e-9);
          EXPECT_NEAR(sampler->density(from, sample.point, sample.normal), density, 1e-6 * density);
          // A ray that comes down on the point meets the shape there.
          Ray ray;
          ray.origin = transform.inverse_point(sample.point + sample.normal * 1e-4);
          ray.direction = transform.inverse_vector(-sample.normal);
          Hit hit;
          const bool met = c.shape->closest_hit(ray, hit, counters);
          if (!met || std::abs(hit.t - 1e-4) > 1e-6) ++outside;
          // The mean of 1 / density over what is seen is the solid angle.
          if (c.name != "box" || dot(sample.normal, from - sample.point) > 0) sum += 1 / density;
        }
        EXPECT_LE(outside, 2 * kSide);  // next to edges
        const double angle = solid_angle(*c.shape, transform, from);
        EXPECT_NEAR(sum / (kSide * kSide), angle, 0.02 * angle + 6e-5);
      }
    }
  }
}

TEST(SurfaceSampler, FrontsAreThoseOfTheShape) {
  const Rectangle rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  SurfaceSample sample;
  const auto normal = [&](const Affine& to_world, bool flip) {
    make_surface_sampler(rectangle, Transform(to_world), flip)
        ->sample({9, 9, 9}, {0.5, 0.5}, sample);
    return sample.normal;
  };
  EXPECT_NEAR(normal({}, false).z, 1, 1e-12);
  EXPECT_NEAR(normal({}, true).z, -1, 1e-12);
  EXPECT_NEAR(normal(scaling({-1, 1, 1}), false).z, 1, 1e-12);  // the front stays the front
  const ConvexPolygon polygon({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
  make_surface_sampler(polygon, Transform(scaling({-1, 1, 1})), false)
      ->sample({9, 9, 9}, {0.5, 0.5}, sample);
  EXPECT_NEAR(sample.normal.z, 1, 1e-12);
  EXPECT_EQ(make_surface_sampler(Torus(1, 0.2), {}, false), nullptr);
}

TEST(SurfaceSampler, LeavesOutWhatHasNoArea) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}};
  mesh.face_materials = {0, 1};
  const auto sampler_of = [&](uint32_t material) {
    return make_triangle_sampler(std::make_shared<TriangleSet>(TriangleSet::of(mesh, material)), {},
                                 false);
  };
  EXPECT_EQ(sampler_of(0), nullptr);
  ASSERT_NE(sampler_of(1), nullptr);
  EXPECT_DOUBLE_EQ(sampler_of(1)->area(), 0.5);
}

}  // namespace
}  // namespace tessera
