#include "renderer/shapes/surface_sampler.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "renderer/math/frame.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/disc.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/torus.h"
#include "renderer/shapes/triangle_sampler.h"

namespace tessera {
namespace {

constexpr double kPi = std::numbers::pi;
const Vec3 kNormal{0, 0, 1};  // of what is lit: none of these asks for it

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
          {"box", std::make_shared<Box>(Bounds3{{-0.3, -0.4, -0.5}, {0.3, 0.2, 0.6}})},
          {"cylinder", std::make_shared<Cylinder>(0.4, 0.9)},
          {"cone", std::make_shared<Cone>(0.5, 0.8)},
          {"cone upside down", std::make_shared<Cone>(1e-3, 0.8, 0.5)},
          {"frustum", std::make_shared<Cone>(0.5, 0.4, 0.2)}};
}

/// The solid angle of the front, by tracing rays to all sides where it may be.
double solid_angle(const Shape& shape, const Transform& world_from_object, const Point3& from) {
  constexpr int kSide = 400;
  const Bounds3 box = world_from_object.bounds(shape.bounds());
  const Vec3 way = box.center() - from;
  const double sine = length(box.diagonal()) / 2 / length(way);
  const double least = sine < 1 ? std::sqrt(1 - sine * sine) : -1;
  const Frame frame(normalize(way));
  TraversalCounters counters;
  int hits = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double z = 1 - (1 - least) * (i / kSide + 0.5) / kSide;
    const double r = std::sqrt(1 - z * z), phi = 2 * kPi * (i % kSide + 0.5) / kSide;
    Ray ray;
    ray.origin = world_from_object.inverse_point(from);
    ray.direction = world_from_object.inverse_vector(
        frame.from_local({r * std::cos(phi), r * std::sin(phi), z}));
    Hit hit;
    if (shape.closest_hit(ray, hit, counters)) ++hits;
  }
  return hits * 2 * kPi * (1 - least) / (kSide * kSide);
}

TEST(SurfaceSampler, PointsLieOnTheSurfaceAndTheirDensitiesAddUp) {
  const Affine turned = translation({3, 1, -2}) * rotation({1, 2, 3}, 0.7);
  for (const Affine& to_world :
       {Affine{}, turned, turned * scaling({2, 2, 2}), turned * scaling({-1.5, 1, 0.5})}) {
    const Transform transform(to_world);
    for (const Case& c : cases()) {
      const auto sampler = c.shape->make_sampler(transform, false);
      const bool is_ellipsoid = c.name == "sphere" && to_world.determinant() < 0;
      // Of what is chosen evenly, the half that faces away is none that is seen.
      const auto* const solid = dynamic_cast<const Solid*>(c.shape.get());
      const bool is_by_area = solid && (c.name != "sphere" || is_ellipsoid);
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
          const double density = sampler->sample({from, kNormal}, u, sample);
          ASSERT_GT(density, 0);
          ASSERT_NEAR(length(sample.normal), 1, 1e-9);
          EXPECT_NEAR(sampler->density({from, kNormal}, sample.point, sample.normal, 0), density,
                      1e-6 * density);
          // A ray that comes down on the point meets the shape there.
          Ray ray;
          ray.origin = transform.inverse_point(sample.point + sample.normal * 1e-4);
          ray.direction = transform.inverse_vector(-sample.normal);
          Hit hit;
          const bool met = c.shape->closest_hit(ray, hit, counters);
          if (!met || std::abs(hit.t - 1e-4) > 1e-6) ++outside;
          // The mean of 1 / density over what is seen is the solid angle.
          if (!is_by_area || dot(sample.normal, from - sample.point) > 0) sum += 1 / density;
        }
        EXPECT_LE(outside, 2 * kSide);  // next to edges
        const double angle = solid_angle(*c.shape, transform, from);
        EXPECT_NEAR(sum / (kSide * kSide), angle, 0.01 * angle);
      }
    }
  }
}

TEST(SurfaceSampler, FrontsAreThoseOfTheShape) {
  const Rectangle rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  SurfaceSample sample;
  const Point3 from{9, 9, 9};
  const auto normal = [&](const Affine& to_world, bool flip) {
    rectangle.make_sampler(Transform(to_world), flip)->sample({from, kNormal}, {0.5, 0.5}, sample);
    return sample.normal;
  };
  EXPECT_NEAR(normal({}, false).z, 1, 1e-12);
  EXPECT_NEAR(normal({}, true).z, -1, 1e-12);
  EXPECT_NEAR(normal(scaling({-1, 1, 1}), false).z, 1, 1e-12);  // the front stays the front
  const ConvexPolygon polygon({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
  polygon.make_sampler(Transform(scaling({-1, 1, 1})), false)
      ->sample({from, kNormal}, {0.5, 0.5}, sample);
  EXPECT_NEAR(sample.normal.z, 1, 1e-12);
  EXPECT_EQ(Torus(0.2, 1).make_sampler({}, false), nullptr);  // some of it lies inside
}

/// What of the light of all of a surface, (s, t) in [0, 1)^2, would come to `from` if nothing were
/// in the way, by the rule of mid-points.
template <typename At>
double light_of(const At& at, const Affine& to_world, const Point3& from) {
  constexpr int kSide = 400;
  constexpr double kStep = 1e-5;
  double sum = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double s = (i / kSide + 0.5) / kSide, t = (i % kSide + 0.5) / kSide;
    const Vec3 by_s = (to_world(at(s + kStep, t)) - to_world(at(s - kStep, t))) / (2 * kStep);
    const Vec3 by_t = (to_world(at(s, t + kStep)) - to_world(at(s, t - kStep))) / (2 * kStep);
    const Vec3 way = to_world(at(s, t)) - from;
    sum += std::abs(dot(cross(by_s, by_t), way)) / std::pow(length(way), 3);
  }
  return sum / (kSide * kSide);
}
double sampled_light_of(const Shape& shape, const Affine& to_world, const Point3& from) {
  const auto sampler = shape.make_sampler(Transform(to_world), false);
  constexpr int kCount = 100'000;
  double sum = 0;
  for (int i = 0; i < kCount; ++i) {
    const Vec2 u{std::fmod(i * 0.7548776662466927, 1), std::fmod(i * 0.5698402909980532, 1)};
    SurfaceSample sample;
    const double density = sampler->sample({from, kNormal}, u, sample);
    EXPECT_NEAR(sampler->density({from, kNormal}, sample.point, sample.normal, 0), density,
                1e-6 * density);
    if (density > 0) sum += 1 / density;
  }
  return sum / kCount;
}

TEST(SurfaceSampler, GoesAllRoundTubesAndOpenOnes) {
  const auto ring = [](double s, double t) {
    const double out = 1 + 0.4 * std::cos(2 * kPi * t);
    return Point3{out * std::cos(2 * kPi * s), 0.4 * std::sin(2 * kPi * t),
                  out * std::sin(2 * kPi * s)};
  };
  const auto tube = [](double s, double t) {
    const double r = 0.5 - 0.2 * t;
    return Point3{r * std::cos(2 * kPi * s), 1.4 * t - 0.7, r * std::sin(2 * kPi * s)};
  };
  for (const Affine& to_world :
       {Affine{}, translation({3, 1, -2}) * rotation({1, 2, 3}, 0.7) * scaling({-1.5, 1, 0.5})}) {
    for (const Point3& local : {Point3{1.5, 2, 3}, Point3{0.1, 0.2, 0.1}, Point3{12, -30, 25}}) {
      const Point3 from = to_world(local);
      const double of_ring = light_of(ring, to_world, from);
      EXPECT_NEAR(sampled_light_of(Torus(1, 0.4), to_world, from), of_ring, 0.003 * of_ring);
      const double of_tube = light_of(tube, to_world, from);
      const OpenParts open{.side = false, .top = true, .bottom = true};
      EXPECT_NEAR(sampled_light_of(Cone(0.5, 1.4, 0.3, open), to_world, from), of_tube,
                  0.003 * of_tube);
    }
  }
}

TEST(SurfaceSampler, ChoosesThePartsThatAreThere) {
  const auto parts = [](const OpenParts& open) {
    const auto sampler = Cylinder(1, 2, open).make_sampler({}, false);
    std::array<int, 3> found{};
    const Point3 from{4, 5, 6};
    for (int i = 0; i < 1000; ++i) {
      const Vec2 u{std::fmod(i * 0.7548776662466927, 1), std::fmod(i * 0.5698402909980532, 1)};
      SurfaceSample sample;
      EXPECT_GT(sampler->sample({from, kNormal}, u, sample), 0);
      ++found[sample.normal.y > 0.5 ? 1 : sample.normal.y < -0.5 ? 2 : 0];
    }
    return found;
  };
  const auto whole = parts({});
  EXPECT_NEAR(whole[0], 667, 5);  // 4 pi of 6 pi
  EXPECT_NEAR(whole[1], 167, 5);
  EXPECT_EQ((parts({.side = true, .top = true})), (std::array{0, 0, 1000}));
  EXPECT_EQ((parts({.top = true, .bottom = true})), (std::array{1000, 0, 0}));
  EXPECT_EQ(Cylinder(1, 2, {true, true, true}).make_sampler({}, false), nullptr);
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
