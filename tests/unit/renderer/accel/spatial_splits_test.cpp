// Trees over cut triangles give the bits of a linear scan, most of all where these are grazed.
#include "renderer/accel/spatial_splits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "bench/generated_meshes.h"
#include "renderer/accel/bvh.h"
#include "renderer/accel/linear_scan.h"
#include "renderer/accel/tree_boxes.h"
#include "renderer/math/rounding.h"

namespace tessera {
namespace {

constexpr size_t kPanes = 8;

/// Large panes askew, the first triangles, across a soup.
std::shared_ptr<const TriangleMesh> panes_in_soup() {
  auto mesh = std::make_shared<TriangleMesh>();
  const TriangleMesh soup = triangle_soup(1500, 3);
  for (uint32_t i = 0; i < kPanes; ++i) {
    const float s = 0.05f * static_cast<float>(i);
    mesh->positions.insert(mesh->positions.end(),
                           {{0, s, 0.1f}, {1, s + 0.6f, 0.3f}, {0.1f, s + 0.5f, 0.9f}});
    mesh->triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const auto first = static_cast<uint32_t>(mesh->positions.size());
  for (size_t i = 0; i < soup.positions.size(); ++i) {  // small, to hide little of the panes
    const Float3 &c = soup.positions[i - i % 3], &p = soup.positions[i];
    mesh->positions.push_back(
        {0.8f * c.x + 0.2f * p.x, 0.8f * c.y + 0.2f * p.y, 0.8f * c.z + 0.2f * p.z});
  }
  for (const TriangleIndices& t : soup.triangles)
    mesh->triangles.push_back({first + t[0], first + t[1], first + t[2]});
  return mesh;
}

TEST(SpatialSplits, CutLargeTrianglesWithinBounds) {
  const auto mesh = panes_in_soup();
  const SpatialSplits splits = split_spatially(*mesh, triangle_boxes(*mesh));
  EXPECT_GT(splits.boxes.size(), mesh->triangles.size() + kPanes);
  EXPECT_LE(static_cast<double>(splits.boxes.size()),
            kMaxGrowth * static_cast<double>(mesh->triangles.size()));
  EXPECT_EQ(splits.planes.count, 1);
  const std::vector<BuildBox> whole = triangle_boxes(*mesh);
  std::vector<size_t> pieces(whole.size());
  for (const BuildBox& b : splits.boxes) {
    ++pieces[b.index()];
    for (int a = 0; a < 3; ++a) {
      EXPECT_LE(b.low[a], b.high[a]);
      EXPECT_GE(b.low[a], whole[b.index()].low[a]);
      EXPECT_LE(b.high[a], whole[b.index()].high[a]);
    }
  }
  for (size_t i = 0; i < pieces.size(); ++i) {
    EXPECT_GE(pieces[i], 1u);
    if (i >= kPanes) {
      EXPECT_EQ(pieces[i], 1u);
    }
  }
  const TriangleMesh sphere = icosphere(3);
  EXPECT_EQ(split_spatially(sphere, triangle_boxes(sphere)).boxes.size(), sphere.triangles.size());
}

/// Through two points of a pane, often close to a corner, tilted by anything from nothing to a lot.
Ray grazing_ray(const TriangleMesh& mesh, std::mt19937_64& random) {
  std::uniform_real_distribution<> unit;
  const auto corners = mesh.corners(random() % kPanes);
  const size_t first = random() % 3;
  const Point3 a = corners[first], b = corners[(first + 1) % 3], c = corners[(first + 2) % 3];
  const double near = random() % 2 ? 1 : std::pow(10, -4 * unit(random));
  const Point3 p = a + (b - a) * (near * unit(random)), q = a + (c - a) * (near * unit(random));
  const Vec3 normal = normalize(cross(b - a, c - a));
  const double tilt = random() % 4 == 0 ? 0 : std::pow(10, -17 * unit(random));
  const double scale = std::pow(10, 6 * unit(random) - 3);
  Ray ray{p + (p - q) * (3 * unit(random) / near) + normal * (tilt * unit(random)),
          (q - p + normal * (tilt * near * (unit(random) - 0.5))) * scale};
  if (random() % 16 == 0) ray.origin = ray.origin + (p - q) * (1e3 / near);
  if (random() % 16 == 0) ray.t_min = -1;
  return ray;
}

TEST(SpatialSplits, RaysThatGrazeACutPlaneAreKnown) {
  const auto mesh = panes_in_soup();
  const CutPlanes planes = split_spatially(*mesh, triangle_boxes(*mesh)).planes;
  const auto [a, b, c] = mesh->corners(0);
  const Vec3 normal = normalize(cross(b - a, c - a)), along = normalize(b - a);
  for (const double scale : {1e-300, 1e-3, 1.0, 1e300}) {
    for (const double sine : {0.0, 1e-12, -0x1p-10, 0x1p-10})
      EXPECT_TRUE(planes.must_visit_all({{}, (along + normal * sine) * scale}, 2)) << sine;
    for (const double sine : {-0x1p-7, 0x1p-7, 1.0})
      EXPECT_FALSE(planes.must_visit_all({{}, (along + normal * sine) * scale}, 2)) << sine;
  }
  EXPECT_TRUE(planes.must_visit_all({{8.1, 0, 0}, normal}, 2));
  EXPECT_TRUE(planes.must_visit_all({{}, normal, -1}, 2));
}

TEST(SpatialSplits, ChangeNoHit) {
  const auto mesh = panes_in_soup();
  const MeshLinearScan scan(mesh);
  const CutPlanes planes = split_spatially(*mesh, triangle_boxes(*mesh)).planes;
  std::mt19937_64 random(11);
  std::uniform_real_distribution<> unit(-0.5, 1.5);
  size_t hits = 0, grazing = 0;
  TraversalCounters counters;
  for (const BvhKernels& code : all_kernels()) {
    const MeshBvh bvh(*mesh, 2, code, BvhQuality::spatial_splits);
    EXPECT_GT(bvh.statistics().references, mesh->triangles.size());
    const auto compare = [&](const Ray& ray) {
      Hit expected, hit, in_packet[2];
      const bool found = scan.closest_hit(ray, expected, counters);
      EXPECT_EQ(bvh.closest_hit(ray, hit, counters), found);
      EXPECT_EQ(hit, expected) << code.name;
      EXPECT_EQ(bvh.any_hit(ray, counters), scan.any_hit(ray, counters)) << code.name;
      const Ray twice[2] = {ray, ray};
      bvh.closest_hits(twice, in_packet, counters);
      EXPECT_EQ(in_packet[0], expected);
      hits += found;
      grazing += planes.must_visit_all(ray, 1.5);
      return expected;
    };
    for (int i = 0; i < 3000; ++i) {
      Ray ray{{unit(random), unit(random), unit(random)},
              {unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5}};
      if (i % 2) ray = grazing_ray(*mesh, random);
      const Hit hit = compare(ray);
      if (!std::isfinite(hit.t)) continue;
      // Leave just this hit in reach: no box may be culled by a t that is not in it.
      Ray until = ray, from = ray;
      until.t_max = next_up(hit.t);
      from.t_min = next_down(hit.t);
      compare(until);
      compare(from);
    }
  }
  EXPECT_GT(hits, 750 * all_kernels().size());
  EXPECT_GT(grazing, 750 * all_kernels().size());
}

/// Triangles that are tested for a ray up to `t_max`.
uint64_t tests_up_to(const MeshBvh& bvh, Ray ray, double t_max) {
  TraversalCounters counters;
  Hit hit;
  ray.t_max = t_max;
  bvh.closest_hit(ray, hit, counters);
  return counters.primitive_tests;
}

TEST(SpatialSplits, RaysThatGrazeACutPlaneAreTestedAgainstAllOnTheirLine) {
  const auto mesh = panes_in_soup();
  const auto [a, b, c] = mesh->corners(0);
  const Vec3 normal = normalize(cross(b - a, c - a));
  std::mt19937_64 random(17);
  std::uniform_real_distribution<> unit;
  for (const BvhKernels& code : all_kernels()) {
    const MeshBvh bvh(*mesh, 1, code, BvhQuality::spatial_splits);
    uint64_t near = 0, far = 0;
    for (int i = 0; i < 200; ++i) {
      Ray ray{{unit(random), unit(random), unit(random)},
              (b - a) * (unit(random) - 0.5) + (c - a) * (unit(random) - 0.5)};
      const uint64_t all = tests_up_to(bvh, ray, Bounds3::kInfinity);
      EXPECT_EQ(tests_up_to(bvh, ray, 1e-9), all) << code.name;
      TraversalCounters counters, of_two;
      ray.t_max = 1e-9;
      bvh.any_hit(ray, counters);
      EXPECT_EQ(counters.primitive_tests, all) << code.name;
      const Ray twice[2] = {ray, ray};
      Hit hits[2];
      bvh.closest_hits(twice, hits, of_two);
      EXPECT_EQ(of_two.primitive_tests, 2 * all) << code.name;
      ray.direction = ray.direction + normal * (0.1 * length(ray.direction));
      near += tests_up_to(bvh, ray, 1e-9);
      far += tests_up_to(bvh, ray, Bounds3::kInfinity);
    }
    EXPECT_LT(near, far / 2);
  }
}

}  // namespace
}  // namespace tessera
