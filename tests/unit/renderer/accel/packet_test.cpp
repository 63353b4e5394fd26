// Packets give the bits of single rays, on every instruction set.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <memory>
#include <random>

#include "bench/generated_meshes.h"
#include "renderer/accel/bvh.h"
#include "renderer/accel/linear_scan.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"

namespace tessera {
namespace {

TriangleMesh sphere_and_soup() {
  TriangleMesh mesh = icosphere(4);
  const TriangleMesh soup = triangle_soup(3000, 7);
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (const Float3& p : soup.positions)
    mesh.positions.push_back({3 * p.x - 1.5f, 3 * p.y - 1.5f, 3 * p.z - 1.5f});
  for (const TriangleIndices& t : soup.triangles)
    mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  return mesh;
}

/// Rays from about one place to about one place, `spread` apart; now and then an odd one.
std::vector<Ray> bundle(std::mt19937_64& random, size_t count, double spread) {
  std::normal_distribution<> normal;
  const auto vec = [&] { return Vec3{normal(random), normal(random), normal(random)}; };
  const Point3 from = Point3{} + vec() * 2, to = Point3{} + vec() * 0.5;
  std::vector<Ray> rays;
  for (size_t i = 0; i < count; ++i) {
    Ray ray{from, to - from + vec() * spread};
    if (random() % 4 == 0) ray.origin = ray.origin + vec() * spread;
    if (random() % 16 == 0) ray.t_max = std::abs(normal(random));
    if (random() % 16 == 0) ray.t_min = std::abs(normal(random));
    if (random() % 32 == 0) ray.cull = random() % 2 ? Cull::back : Cull::front;
    if (random() % 500 == 0) ray.direction.y = 0;
    if (random() % 800 == 0) ray.direction.x = std::nan("");
    if (random() % 800 == 0) ray.origin.z = 1e18;
    rays.push_back(ray);
  }
  return rays;
}

TEST(Packets, GiveTheBitsOfSingleRays) {
  const TriangleMesh mesh = sphere_and_soup();
  const MeshBvh reference(mesh, 1);
  std::vector<std::unique_ptr<MeshBvh>> contestants;
  for (const BvhKernels& code : all_kernels())
    contestants.push_back(std::make_unique<MeshBvh>(mesh, 1, code));
  std::mt19937_64 random(5);
  size_t found = 0;
  for (int round = 0; round < 400; ++round) {
    const double spread = std::pow(10.0, -static_cast<double>(round % 5));
    const std::vector<Ray> rays = bundle(random, 1 + random() % 70, spread);
    std::vector<Hit> expected(rays.size());
    TraversalCounters counters;
    for (size_t i = 0; i < rays.size(); ++i) {
      if (i % 7 == 3) expected[i].t = 2;  // as after a hit elsewhere
      const Hit before = expected[i];
      if (reference.closest_hit(rays[i], expected[i], counters))
        ++found;
      else
        EXPECT_EQ(expected[i], before);
    }
    for (size_t c = 0; c < contestants.size(); ++c) {
      std::vector<Hit> hits(rays.size());
      for (size_t i = 3; i < rays.size(); i += 7) hits[i].t = 2;
      contestants[c]->closest_hits(rays, hits, counters);
      for (size_t i = 0; i < rays.size(); ++i)
        EXPECT_EQ(hits[i], expected[i])
            << all_kernels()[c].name << " round " << round << " ray " << i;
    }
  }
  EXPECT_GT(found, 5000u);
}

TEST(Packets, AreStoppedByWhatStopsSingleRays) {
  const TriangleMesh mesh = sphere_and_soup();
  const MeshBvh reference(mesh, 1);
  std::vector<std::unique_ptr<MeshBvh>> contestants;
  for (const BvhKernels& code : all_kernels())
    contestants.push_back(std::make_unique<MeshBvh>(mesh, 1, code));
  std::mt19937_64 random(8);
  size_t stopped = 0, passed = 0;
  for (int round = 0; round < 300; ++round) {
    const double spread = std::pow(10.0, -static_cast<double>(round % 5));
    const std::vector<Ray> rays = bundle(random, 1 + random() % 64, spread);
    uint64_t expected = 0;
    TraversalCounters counters;
    for (size_t i = 0; i < rays.size(); ++i) {
      const bool hit = reference.any_hit(rays[i], counters);
      expected |= uint64_t{hit} << i;
      stopped += hit, passed += !hit;
    }
    for (size_t c = 0; c < contestants.size(); ++c) {
      EXPECT_EQ(contestants[c]->any_hits(rays, counters), expected)
          << all_kernels()[c].name << " round " << round;
    }
  }
  EXPECT_GT(stopped, 2000u);
  EXPECT_GT(passed, 500u);
}

/// Spheres, planes and meshes, moved, mirrored, culled, and some that cast no shadows.
std::vector<Instance> many_instances(std::mt19937_64& random, size_t count) {
  std::normal_distribution<> normal;
  const auto ball = std::make_shared<const TriangleMesh>(icosphere(2));
  const auto mesh = make_mesh_shape(ball, AcceleratorKind::bvh, 1);
  const auto sphere = std::make_shared<const Sphere>(Point3{}, 1);
  const auto plane = std::make_shared<const Plane>(Vec3{0, 1, 0}, -3);
  std::vector<Instance> instances;
  for (size_t i = 0; i < count; ++i) {
    Instance instance;
    instance.shape = mesh;
    if (random() % 4 == 0) instance.shape = sphere;
    const Vec3 place{normal(random), normal(random), normal(random)};
    const double size = .1 + .2 * std::abs(normal(random));
    if (random() % 8 != 0)
      instance.world_from_object =
          Transform(translation(place) * scaling({size, random() % 4 == 0 ? -size : size, size}));
    instance.casts_shadow = random() % 4 != 0;
    if (random() % 8 == 0) instance.cull = random() % 2 == 0 ? Cull::back : Cull::front;
    instance.flip_normals = random() % 8 == 0;
    instances.push_back(instance);
  }
  if (count % 2 == 0) instances.push_back({.shape = plane});
  // The same twice: of equal hits the first counts.
  instances.push_back(instances[count / 2]);
  return instances;
}

TEST(Packets, MeetInstancesAsSingleRaysDo) {
  std::mt19937_64 random(9);
  std::normal_distribution<> normal;
  const auto vec = [&] { return Vec3{normal(random), normal(random), normal(random)}; };
  size_t hits = 0, stopped = 0, of_many = 0;
  for (int round = 0; round < 300; ++round) {
    const std::vector<Instance> instances = many_instances(random, 1 + random() % 40);
    const InstanceLinearScan reference(instances);
    const double spread = std::pow(10.0, -1.0 - round % 4);
    RayBatch batch;
    batch.begin(round % 3 == 0 ? .5 : 0, round % 5 == 0 ? 4 : Bounds3::kInfinity);
    const Vec3 from = vec() * 3, to = vec() * .5;
    const size_t count = 1 + random() % RayBatch::kMost;
    for (; batch.count < count; ++batch.count) {
      const Vec3 origin = from + vec() * (spread * .1), way = to - from + vec() * spread;
      for (int axis = 0; axis < 3; ++axis) {
        batch.origin[axis][batch.count] = origin[axis];
        batch.direction[axis][batch.count] = way[axis];
      }
    }
    std::vector<Hit> expected(count);
    uint64_t expected_stopped = 0;
    TraversalCounters counters;
    for (size_t i = 0; i < count; ++i) {
      reference.closest_hit(batch.ray(i), expected[i], counters);
      hits += expected[i].t < Bounds3::kInfinity;
      expected_stopped |= uint64_t{reference.any_hit(batch.ray(i), counters)} << i;
    }
    stopped += static_cast<size_t>(std::popcount(expected_stopped));
    for (const BvhKernels& code : all_kernels()) {
      SCOPED_TRACE(fmt::format("round {}, {}", round, code.name));
      const auto accelerator = make_instance_accelerator(instances, AcceleratorKind::bvh, 1, code);
      std::vector<Hit> found(count);
      accelerator->closest_hits(batch, found, counters);
      EXPECT_EQ(found, expected);
      EXPECT_EQ(accelerator->any_hits(batch, counters), expected_stopped);
      of_many += dynamic_cast<const InstanceBvh*>(accelerator.get()) != nullptr;
    }
    std::vector<Hit> found(count);
    reference.closest_hits(batch, found, counters);
    EXPECT_EQ(found, expected);
    EXPECT_EQ(reference.any_hits(batch, counters), expected_stopped);
  }
  EXPECT_GT(hits, 2000u);
  EXPECT_GT(stopped, 1500u);
  EXPECT_GT(of_many, 100u);
}

TEST(Packets, VisitFewerNodesThanTheirRaysAlone) {
  const MeshBvh bvh(sphere_and_soup(), 1);
  std::mt19937_64 random(6);
  const std::vector<Ray> rays = bundle(random, kPacketSize, 1e-3);
  std::vector<Hit> hits(rays.size());
  TraversalCounters together, alone;
  bvh.closest_hits(rays, hits, together);
  for (const Ray& ray : rays) {
    Hit hit;
    bvh.closest_hit(ray, hit, alone);
  }
  EXPECT_LT(together.node_visits * 4, alone.node_visits);
}

}  // namespace
}  // namespace tessera
