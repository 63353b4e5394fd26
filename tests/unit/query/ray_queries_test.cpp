#include "query/ray_queries.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <tuple>

#include "base/error.h"
#include "query/each_ray.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/shapes/triangle.h"
#include "tests/unit/query/query_arrays.h"

namespace tessera {
namespace {

constexpr double kInf = Bounds3::kInfinity;

TEST(RayQueries, LooksForAnEndEveryFewRays) {
  std::atomic<bool> cancelled{false};
  size_t traced = 0;
  EXPECT_FALSE(for_each_chunk(100'000, {.threads = 1, .cancelled = &cancelled},
                              [&](size_t begin, size_t end) {
                                traced += end - begin;
                                cancelled = true;
                              }));
  EXPECT_LE(traced, 64U);
}

/// 1,000 triangles, of which some are there twice and one has no area.
MeshText soup() {
  std::mt19937_64 random(7);
  MeshText mesh;
  for (uint32_t i = 0; i < 990; ++i) {
    const Vec3 at = random_vector(random, 2);
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = at + random_vector(random);
      mesh.positions.push_back({float(p.x), float(p.y), float(p.z)});
    }
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    if (i % 99 == 5) mesh.triangles.push_back(mesh.triangles.back());
    if (i == 300) mesh.triangles.push_back({4, 4, 5});
  }
  return mesh;
}

OwnedRays rays_about(int count, double size, uint64_t seed) {
  std::mt19937_64 random(seed);
  OwnedRays rays;
  for (int i = 0; i < count; ++i) {
    const Vec3 o = random_vector(random, size);
    rays.add(o, random_vector(random, size * 0.5) - o);
  }
  return rays;
}

using Place = std::tuple<double, uint32_t, uint32_t>;

/// The hits of each ray, one after the other.
std::vector<std::vector<Place>> places(const AllHits& hits) {
  std::vector<std::vector<Place>> out(hits.offsets.size() - 1);
  for (size_t i = 0; i < out.size(); ++i)
    for (auto k = size_t(hits.offsets[i]); k < size_t(hits.offsets[i + 1]); ++k)
      out[i].emplace_back(hits.t[k], hits.instance[k], hits.primitive[k]);
  return out;
}

TEST(RayQueries, AllHitsAreThoseOfEveryTriangle) {
  const MeshText mesh = soup();
  const OwnedRays rays = rays_about(10'000, 4, 8);
  std::vector<std::vector<Place>> expected(rays.count());
  for (size_t i = 0; i < rays.count(); ++i) {
    const Ray ray = rays.batch()[i];
    const TriangleRay prepared(ray);
    for (uint32_t k = 0; k < mesh.triangles.size(); ++k) {
      const auto corner = [&](size_t c) {
        const auto& p = mesh.positions[mesh.triangles[k][c]];
        return Point3{p[0], p[1], p[2]};
      };
      TriangleHit hit;
      if (mesh.triangles[k][0] != mesh.triangles[k][1] &&
          intersect_triangle(prepared, corner(0), corner(1), corner(2), hit))
        expected[i].emplace_back(hit.t, 0, k);
    }
    std::sort(expected[i].begin(), expected[i].end());
  }
  for (const std::string& accelerator : available_accelerators()) {
    const RayQueries queries = queries_of(mesh.scene(), accelerator);
    const auto all = queries.all_hits(rays.batch(), {.threads = 2});
    ASSERT_TRUE(all);
    EXPECT_GT(all->t.size(), 100'000u);
    EXPECT_EQ(places(*all), expected) << accelerator;
    const OwnedHits nearest = closest(queries, rays.batch());
    for (size_t i = 0; i < rays.count(); ++i) {
      const Place first =
          expected[i].empty() ? Place{kInf, kNoInstance, kNoInstance} : expected[i].front();
      ASSERT_EQ(Place(nearest.t[i], nearest.instance[i], nearest.primitive[i]), first);
    }
  }
}

/// Every kind of shape, three hundred instances, some in groups eight deep.
std::string mixed_scene() {
  const std::string shapes[] = {
      "sphere { radius: .7 }", "torus { major_radius: .8 minor_radius: .3 }",
      "box { max { x: 1 y: 1 z: 1 } }", "disc { radius: .9 normal { y: 1 } }",
      "csg { operation: DIFFERENCE operands { shape { box { max { x: 1 y: 1 z: 1 } } } } "
      "operands { shape { sphere { center { x: 1 } radius: .6 } } } }"};
  std::mt19937_64 random(3);
  std::string text = "nodes { shape { plane { normal { y: 1 } offset: -3 } } } ";
  for (size_t i = 0; i < 300; ++i) {
    const Vec3 at = random_vector(random, 6);
    std::string node = fmt::format("shape {{ {} }}", shapes[i % std::size(shapes)]);
    for (size_t depth = 0; depth < i % 9; ++depth)
      node = fmt::format(
          "transform {{ steps {{ rotate {{ axis {{ x: 1 y: {} }} angle: 20 }} }} }} "
          "children {{ {} }}",
          depth, node);
    text += fmt::format(
        "nodes {{ name: 'n{}' transform {{ steps {{ translate {{ x: {} y: {} z: {} }} }} }} "
        "children "
        "{{ {} }} }} ",
        i, at.x, at.y, at.z, node);
  }
  return text;
}

TEST(RayQueries, AllAcceleratorsFindAllHitsOfAllShapes) {
  const OwnedRays rays = rays_about(3'000, 9, 4);
  const auto expected = queries_of(mixed_scene(), "linear").all_hits(rays.batch());
  EXPECT_GT(expected->t.size(), 10'000u);
  for (const std::string accelerator : {"bvh", "octree"}) {
    const RayQueries queries = queries_of(mixed_scene(), accelerator);
    const auto all = queries.all_hits(rays.batch());
    EXPECT_EQ(places(*all), places(*expected)) << accelerator;
    const OwnedHits nearest = closest(queries, rays.batch());
    std::vector<uint8_t> stopped(rays.count());
    queries.occluded(rays.batch(), stopped.data());
    for (size_t i = 0; i < rays.count(); ++i) {
      const auto first = static_cast<size_t>(all->offsets[i]);
      const bool is_hit = all->offsets[i + 1] > all->offsets[i];
      ASSERT_EQ(nearest.t[i], is_hit ? all->t[first] : kInf);
      ASSERT_EQ(stopped[i] != 0, is_hit);
    }
  }
}

TEST(RayQueries, ThreadsChangeNoBit) {
  const RayQueries queries = queries_of(mixed_scene());
  const OwnedRays rays = rays_about(5'000, 9, 5);
  const OwnedHits expected = closest(queries, rays.batch(), 1);
  const auto all = places(*queries.all_hits(rays.batch(), {.threads = 1}));
  for (const int threads : {2, 7}) {
    EXPECT_EQ(closest(queries, rays.batch(), threads), expected);
    EXPECT_EQ(places(*queries.all_hits(rays.batch(), {.threads = threads})), all);
  }
}

TEST(RayQueries, SurfacesAreMetWhateverLightDoes) {
  const RayQueries queries = queries_of(
      "materials { name: 'ghost' opacity { value: 0 } sides: FRONT_ONLY } "
      "textures { name: 'broken' } "
      "nodes { hidden: true shape { sphere { radius: 3 } } } "
      "nodes { name: 'veil' casts_no_shadow: true shape { materials: 'ghost' sphere { radius: 1 } "
      "} } ");
  OwnedRays rays;
  rays.add({0, 0, 0}, {0, 0, 2});  // from behind
  rays.add({0, 0, 5}, {0, 0, -1});
  const OwnedHits hits = closest(queries, rays.batch());
  EXPECT_EQ(hits.t, (std::vector<double>{0.5, 4}));
  std::vector<uint8_t> stopped(2);
  queries.occluded(rays.batch(), stopped.data());
  EXPECT_EQ(stopped, (std::vector<uint8_t>{1, 1}));
  std::vector<uint32_t> material(2);
  std::vector<double> point(6), normal(6);
  queries.attributes(rays.batch(), hits.found(),
                     {.point = point.data(), .normal = normal.data(), .material = material.data()});
  EXPECT_EQ(queries.material_names()[material[1]], "ghost");
  EXPECT_EQ(queries.instance_names()[hits.instance[0]], "veil");
  EXPECT_EQ(point, (std::vector<double>{0, 0, 1, 0, 0, 1}));
  EXPECT_EQ(normal, (std::vector<double>{0, 0, 1, 0, 0, 1}));
}

TEST(RayQueries, CullTakesOneSide) {
  const RayQueries queries = queries_of("nodes { shape { sphere { radius: 1 } } }");
  OwnedRays rays;
  rays.add({0, 0, 5}, {0, 0, -1});
  RayArrays batch = rays.batch();
  batch.cull = Cull::back;
  EXPECT_EQ(closest(queries, batch).t[0], 4);
  batch.cull = Cull::front;
  EXPECT_EQ(closest(queries, batch).t[0], 6);
}

TEST(RayQueries, StretchesAndStridesAreThoseOfTheCaller) {
  const RayQueries queries = queries_of("nodes { shape { sphere { radius: 1 } } }");
  const double origin[] = {0, 0, 5}, directions[] = {0, 0, -1, 9, 0, 0, -2, 9};
  const double t_min[] = {4, 0}, t_max[] = {7, 2};
  RayArrays rays{2, {origin, 0}, {directions, 4 * sizeof(double)}, {t_min}, {t_max}};
  const OwnedHits hits = closest(queries, rays);
  EXPECT_EQ(hits.t, (std::vector<double>{6, kInf}));  // t_min and t_max themselves are outside
  EXPECT_EQ(hits.instance, (std::vector<uint32_t>{0, kNoInstance}));
  // The same in single precision, one axis after the other.
  const float columns[] = {0, 0, 0, 0, -1, -2};
  rays.directions = {columns, sizeof(float), 2 * sizeof(float), true};
  EXPECT_EQ(closest(queries, rays), hits);
}

TEST(RayQueries, WhatIsNoRayHitsNothing) {
  const double nan = std::nan("");
  OwnedRays rays;
  rays.add({nan, 0, 0}, {0, 0, 1});
  rays.add({0, 0, 0}, {0, nan, 1});
  rays.add({0, 0, 0}, {0, 0, 0});
  rays.add({0, kInf, 0}, {0, 0, 1});
  for (const v1::Scene& scene :
       {parse_scene("nodes { shape { sphere { radius: 1 } } }"), soup().scene(), parse_scene("")}) {
    const RayQueries queries = queries_of(scene);
    EXPECT_EQ(closest(queries, rays.batch()).t, std::vector<double>(4, kInf));
    EXPECT_EQ(queries.all_hits(rays.batch())->t.size(), 0u);
    EXPECT_EQ(crossings(queries, rays.batch()), std::vector<int32_t>(4));
    EXPECT_EQ(contained(queries, rays.origins),
              contained(queries, {nan, 0, 0, 0, 0, 0, 0, 0, 0, nan, 0, 0}));
  }
}

TEST(RayQueries, WrongNumbersAreTold) {
  const RayQueries queries = queries_of("nodes { shape { sphere { radius: 1 } } }");
  OwnedRays rays;
  rays.add({0, 0, 5}, {0, 0, -1});
  RayArrays batch = rays.batch();
  batch.t_min.otherwise = -1;
  OwnedHits hits(1);
  EXPECT_THROW(queries.closest_hits(batch, hits.arrays()), Error);
  hits.instance[0] = 1;
  EXPECT_THROW(queries.spawn(rays.batch(), hits.found(), {rays.directions.data()}, hits.uv.data()),
               Error);
  hits.instance[0] = 0, hits.primitive[0] = 1;
  EXPECT_THROW(queries.spawn(rays.batch(), hits.found(), {rays.directions.data()}, hits.uv.data()),
               Error);
}

TEST(RayQueries, CancelledCallsSaySo) {
  const RayQueries queries = queries_of("nodes { shape { sphere { radius: 1 } } }");
  OwnedRays rays;
  rays.add({0, 0, 5}, {0, 0, -1});
  const std::atomic<bool> cancelled{true};
  OwnedHits hits(1);
  EXPECT_FALSE(queries.closest_hits(rays.batch(), hits.arrays(), {.cancelled = &cancelled}));
  EXPECT_FALSE(queries.all_hits(rays.batch(), {.cancelled = &cancelled}));
}

// Rays that leave a convex solid outward meet nothing; inward they meet its other side.
TEST(RayQueries, SpawnedRaysDoNotMeetTheirSurface) {
  for (const std::string shape : {"sphere { center { x: 1e3 } radius: .1 }",
                                  "box { min { x: -7 y: 1e4 z: 0 } max { x: -6 y: 10001 z: .1 } }",
                                  "plane { normal { x: 1 y: 2 z: 3 } offset: 100 }"}) {
    const RayQueries queries = queries_of("nodes { shape { " + shape + " } }");
    std::mt19937_64 random(11);
    OwnedRays rays;
    Bounds3 box = queries.bounds();
    if (box.empty()) box = {{-1, -1, -1}, {1, 1, 1}};
    for (int i = 0; i < 20'000; ++i) {
      const Vec3 d = random_vector(random);
      rays.add(box.center() - Point3{} - d * 1000, d + random_vector(random, 1e-5));
    }
    const OwnedHits hits = closest(queries, rays.batch());
    std::vector<double> normals(rays.directions.size()), origins(rays.directions.size());
    queries.attributes(rays.batch(), hits.found(), {.normal = normals.data()});
    OwnedRays bounced;
    for (size_t i = 0; i < rays.count(); ++i) {
      const Vec3 n = VectorRows{normals.data()}[i], d = random_vector(random);
      bounced.add({}, dot(n, d) < 0 ? -d : d);
    }
    queries.spawn(rays.batch(), hits.found(), {bounced.directions.data()}, origins.data());
    bounced.origins = origins;
    const OwnedHits again = closest(queries, bounced.batch());
    EXPECT_GT(std::count_if(hits.t.begin(), hits.t.end(), [](double t) { return t < kInf; }), 1000);
    EXPECT_EQ(again.t, std::vector<double>(rays.count(), kInf)) << shape;
  }
}

TEST(RayQueries, CamerasAreThoseOfTheScene) {
  const std::string text =
      "cameras { name: 'a' world_from_camera { steps { translate { z: 4 } } } } "
      "cameras { name: 'b' world_from_camera { steps { translate { x: 3 } } } } "
      "nodes { shape { sphere { radius: 1 } } }";
  const RayQueries queries = queries_of(text);
  EXPECT_EQ(queries.camera().position(), (Point3{0, 0, 4}));
  EXPECT_EQ(queries.camera("b").position(), (Point3{3, 0, 0}));
  EXPECT_EQ(queries.camera("a", 16, 12).ray(8, 6).direction, queries.camera().ray(4, 3).direction);
  EXPECT_THROW(queries.camera("c"), Error);
}

}  // namespace
}  // namespace tessera
