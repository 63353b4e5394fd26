// Packets give the bits of single rays, on every instruction set.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "bench/generated_meshes.h"
#include "renderer/accel/bvh.h"
#include "renderer/accel/make_accelerator.h"

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
