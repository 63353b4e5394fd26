#include "renderer/accel/instance.h"

#include <gtest/gtest.h>

#include <random>

#include "renderer/accel/make_accelerator.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"

namespace tessera {
namespace {

std::shared_ptr<const Shape> square() {
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  return make_mesh_shape(mesh, AcceleratorKind::linear, 1);
}

const AcceleratorKind kKinds[] = {AcceleratorKind::linear, AcceleratorKind::bvh};

TEST(Instances, OfEqualHitsTheSmallestInstanceAndPrimitiveCounts) {
  // All on the shared diagonal of the square, where both triangles are hit at the same t.
  for (const AcceleratorKind kind : kKinds) {
    std::vector<Instance> scene(6, Instance{square()});
    const auto all = make_instance_accelerator(scene, kind, 1);
    const Ray ray{{0.25, 0.25, 3}, {0, 0, -1}};
    TraversalCounters counters;
    Hit hit;
    ASSERT_TRUE(all->closest_hit(ray, hit, counters));
    EXPECT_EQ(hit.t, 3);
    EXPECT_EQ(hit.instance, 0u);
    EXPECT_EQ(hit.primitive, 0u);
    // A hit already known keeps its place against larger numbers, and yields to smaller ones.
    Hit known{3, 0.5, 0.5, 0, 0};
    EXPECT_FALSE(all->closest_hit(ray, known, counters));
    Hit later{3, 0.5, 0.5, 9, 0};
    EXPECT_TRUE(all->closest_hit(ray, later, counters));
    EXPECT_EQ(later.instance, 0u);
  }
}

TEST(Instances, ShadowlessOnesDoNotOcclude) {
  for (const AcceleratorKind kind : kKinds) {
    std::vector<Instance> scene(4, Instance{square()});
    for (Instance& instance : scene) instance.casts_shadow = false;
    const Ray ray{{0.2, 0.1, 3}, {0, 0, -1}};
    TraversalCounters counters;
    Hit hit;
    EXPECT_FALSE(make_instance_accelerator(scene, kind, 1)->any_hit(ray, counters));
    EXPECT_TRUE(make_instance_accelerator(scene, kind, 1)->closest_hit(ray, hit, counters));
    scene[2].casts_shadow = true;
    EXPECT_TRUE(make_instance_accelerator(scene, kind, 1)->any_hit(ray, counters));
  }
}

// A guess, right or wrong, spares a search or costs a test, and changes no answer.
TEST(Instances, WhatIsAskedFirstChangesNoAnswer) {
  std::vector<Instance> scene;
  for (int i = 0; i < 40; ++i)
    scene.push_back({square(), Transform(translation({3.0 * i, 0, 0.5 * (i % 3)}))});
  for (const AcceleratorKind kind : {AcceleratorKind::bvh, AcceleratorKind::octree}) {
    const auto all = make_instance_accelerator(scene, kind, 1);
    ASSERT_TRUE(all->takes_guesses());
    for (int i = 0; i < 40; ++i) {
      for (const double x : {3.0 * i + .2, 3.0 * i + 1.5}) {  // of which the second passes between
        const Ray ray{{x, 0.1, 9}, {0, 0, -1}};
        TraversalCounters counters;
        const bool is_hit = all->any_hit(ray, counters);
        EXPECT_EQ(is_hit, x < 3.0 * i + 1);
        for (const uint32_t guess : {kNoInstance, 0u, static_cast<uint32_t>(i), 39u}) {
          uint32_t instance = guess;
          EXPECT_EQ(all->any_hit_by(ray, instance, counters), is_hit);
          EXPECT_EQ(instance, is_hit ? static_cast<uint32_t>(i) : kNoInstance);
        }
        uint32_t instance = static_cast<uint32_t>(i);
        TraversalCounters spared;
        all->any_hit_by(ray, instance, spared);
        EXPECT_EQ(spared.node_visits == 0, is_hit);
      }
    }
  }
}

TEST(Instances, TheFrontStaysTheFrontUnderMirroring) {
  for (const Vec3& scale : {Vec3{1, 1, 1}, Vec3{-1, 1, 1}, Vec3{2, -3, 1}}) {
    for (const bool flip : {false, true}) {
      std::vector<Instance> scene{{square(), Transform(scaling(scale))}};
      scene[0].flip_normals = flip;
      Ray ray{{0.2, 0.1, 3}, {0, 0, -1}};
      TraversalCounters counters;
      Hit hit;
      ASSERT_TRUE(closest_hit_of(scene[0], 0, ray, hit, counters));
      EXPECT_EQ(surface_at(scene, ray, hit).geometric_normal, (Normal3{0, 0, flip ? -1.0 : 1.0}));
      ray.cull = Cull::back;
      hit = {};
      EXPECT_EQ(closest_hit_of(scene[0], 0, ray, hit, counters), !flip);
      ray.cull = Cull::none;
      scene[0].cull = Cull::front;
      hit = {};
      EXPECT_EQ(closest_hit_of(scene[0], 0, ray, hit, counters), flip);
      ray.cull = Cull::back;  // both sides culled
      EXPECT_FALSE(any_hit_of(scene[0], ray, counters));
    }
  }
}

TEST(Instances, SurfaceIsInWorldSpace) {
  const Transform placed(translation({10, 0, 0}) * scaling({2, 1, 1}));
  const std::vector<Instance> scene{{std::make_shared<Sphere>(Point3{}, 1)},
                                    {std::make_shared<Sphere>(Point3{}, 1), placed}};
  const Ray ray{{20, 0, 0}, {-1, 0, 0}};
  Hit hit;
  TraversalCounters counters;
  ASSERT_TRUE(make_instance_accelerator(scene, AcceleratorKind::linear, 1)
                  ->closest_hit(ray, hit, counters));
  EXPECT_EQ(hit.instance, 1u);
  EXPECT_EQ(hit.t, 8);
  const SurfaceInteraction s = surface_at(scene, ray, hit);
  EXPECT_EQ(s.point, (Point3{12, 0, 0}));
  EXPECT_EQ(s.geometric_normal, (Normal3{1, 0, 0}));
  EXPECT_EQ(s.instance, 1u);
  EXPECT_GT(s.point_error.x, 0);
  EXPECT_LT(s.point_error.x, 1e-13);
}

TEST(MakeAccelerator, BuildsNoTreeForAFewAndKeepsPlanesOutside) {
  std::vector<Instance> few{{std::make_shared<Plane>(Vec3{0, 1, 0}, 0)},
                            {std::make_shared<Sphere>(Point3{}, 1)}};
  EXPECT_EQ(make_instance_accelerator(few, AcceleratorKind::bvh, 1)->statistics().nodes, 0u);
  std::vector<Instance> many(40, Instance{std::make_shared<Sphere>(Point3{0, 3, 0}, 1)});
  for (size_t i = 0; i < many.size(); ++i)
    many[i].world_from_object = Transform(translation({3.0 * static_cast<double>(i), 0, 0}));
  many.insert(many.begin(), few[0]);
  const auto all = make_instance_accelerator(many, AcceleratorKind::bvh, 1);
  EXPECT_GT(all->statistics().nodes, 0u);
  Hit hit;
  TraversalCounters counters;
  ASSERT_TRUE(all->closest_hit({{-50, 5, 0}, {0, -1, 0}}, hit, counters));
  EXPECT_EQ(hit.instance, 0u);
  counters = {};
  ASSERT_TRUE(all->closest_hit({{30, 9, 0}, {0, -1, 0}}, hit = {}, counters));
  EXPECT_EQ(hit.instance, 11u);
  EXPECT_LT(counters.primitive_tests, 6u);  // the tree left the others out
}

TEST(MakeAccelerator, NamesGoBothWays) {
  for (const auto kind : {AcceleratorKind::bvh, AcceleratorKind::octree, AcceleratorKind::embree,
                          AcceleratorKind::nonuniform_octree, AcceleratorKind::linear})
    EXPECT_EQ(parse_accelerator(accelerator_name(kind)), kind);
  EXPECT_EQ(parse_accelerator("kd-tree"), std::nullopt);
}

TEST(Instances, ThinSolidsAreHitByAllKindsAlike) {
  // A frustum and a squashed ball, as thin as rounding (found by an attack).
  const auto cone = std::make_shared<Cone>(1.1, 1e-30, 1.8);
  const auto ball = std::make_shared<Sphere>(Point3{}, 1);
  const auto other = std::make_shared<Sphere>(Point3{0.2, 0.3, -0.1}, 0.4);
  const std::vector<Instance> instances{
      {.shape = cone},
      {.shape = ball, .world_from_object = Transform(scaling({1, 1, 1e-150}))},
      {.shape = other}};
  const auto truth = make_instance_accelerator(instances, AcceleratorKind::linear, 1);
  std::mt19937_64 engine(31);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
  };
  for (const AcceleratorKind kind : {AcceleratorKind::bvh, AcceleratorKind::octree}) {
    const auto tree = make_instance_accelerator(instances, kind, 1);
    TraversalCounters counters;
    for (int i = 0; i < 20000; ++i) {
      Ray ray;
      ray.origin = {between(-3, 3), between(-3, 3), between(-3, 3)};
      if (i % 3 == 0) ray.origin.y = 0;
      if (i % 3 == 1) ray.origin.z = 0;
      ray.direction = Point3{between(-1, 1), between(-1, 1), between(-1, 1)} - ray.origin;
      Hit expected, found;
      ASSERT_EQ(truth->closest_hit(ray, expected, counters),
                tree->closest_hit(ray, found, counters));
      ASSERT_EQ(expected, found);
      ASSERT_EQ(truth->any_hit(ray, counters), tree->any_hit(ray, counters));
    }
  }
}

}  // namespace
}  // namespace tessera
