// N15, N16, N18, N20: every accelerator gives the bits of the linear scan.
#include "tests/numerics/accelerators.h"
#include "bench/generated_meshes.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"

namespace tessera::numerics {
namespace {

TriangleMesh grid_of_boxes(int n) {
  TriangleMesh mesh;
  for (int i = 0; i < n * n * n; ++i) {
    const auto x = static_cast<float>(i % n), y = static_cast<float>(i / n % n);
    const auto z = static_cast<float>(i / n / n);
    const auto base = static_cast<uint32_t>(mesh.positions.size());
    for (int c = 0; c < 8; ++c)
      mesh.positions.push_back(
          {x + (c & 1 ? 0.5f : 0), y + (c & 2 ? 0.5f : 0), z + (c & 4 ? 0.5f : 0)});
    for (const auto& q : {std::array<uint32_t, 4>{0, 2, 3, 1},
                          {4, 5, 7, 6},
                          {0, 1, 5, 4},
                          {2, 6, 7, 3},
                          {0, 4, 6, 2},
                          {1, 3, 7, 5}}) {
      mesh.triangles.push_back({base + q[0], base + q[1], base + q[2]});
      mesh.triangles.push_back({base + q[0], base + q[2], base + q[3]});
    }
  }
  return mesh;
}

TEST(N15, AxisParallelRaysInFacesEdgesAndCorners) {
  const auto mesh = std::make_shared<const TriangleMesh>(grid_of_boxes(4));
  const Accelerators all = Accelerators::over(mesh);
  size_t wrong = 0, hits = 0;
  for (const Vec3& d : axis_directions()) {
    for (int i = 0; i < 9 * 9 * 9; ++i) {
      // Every half step is a face, an edge or a corner of some box.
      const Point3 origin{i % 9 * 0.5 - 0.5, i / 9 % 9 * 0.5 - 0.5, i / 81 * 0.5 - 0.5};
      wrong += static_cast<size_t>(disagreements(all, {origin, d}));
      Hit hit;
      TraversalCounters counters;
      hits += all.all[0]->closest_hit({origin, d}, hit, counters);
    }
  }
  EXPECT_GT(hits, 1000u);
  EXPECT_EQ(wrong, 0u);
}

TEST(N16, WhatIsNotANumberHitsNothingAndSpreadsNowhere) {
  const double inf = Bounds3::kInfinity, nan = std::nan("");
  const double odd[] = {nan, inf, -inf, 1e308, -1e308, 0, 1e-310};
  Random random(16, 1);
  const auto mesh = std::make_shared<const TriangleMesh>(icosphere(2));
  const Accelerators meshes = Accelerators::over(mesh);
  const std::shared_ptr<const Shape> shape = make_mesh_shape(mesh, AcceleratorKind::bvh, 1);
  const std::vector<Instance> scene{{shape},
                                    {std::make_shared<Sphere>(Point3{5, 0, 0}, 1)},
                                    {std::make_shared<Plane>(Vec3{0, 1, 0}, -3)},
                                    {std::make_shared<Box>(Bounds3{{-5, -1, -1}, {-4, 1, 1}})}};
  const Accelerators instances = Accelerators::over(scene);
  for (int i = 0; i < 20000; ++i) {
    Ray ray{Point3{} + random.in_cube(1), random.direction()};
    double* parts[8] = {&ray.origin.x,    &ray.origin.y,    &ray.origin.z, &ray.direction.x,
                        &ray.direction.y, &ray.direction.z, &ray.t_min,    &ray.t_max};
    for (int k = 0; k <= random.below(3); ++k) *parts[random.below(8)] = odd[random.below(7)];
    EXPECT_EQ(disagreements(meshes, ray), 0) << describe(ray) << ray.t_min << " " << ray.t_max;
    EXPECT_EQ(disagreements(instances, ray), 0) << describe(ray) << ray.t_min << " " << ray.t_max;
    Hit hit;
    TraversalCounters counters;
    if (instances.all[0]->closest_hit(ray, hit, counters)) {
      EXPECT_FALSE(std::isnan(hit.t));
    }
  }
}

TEST(N16, BadTrianglesAreDroppedAndCounted) {
  TriangleMesh mesh = icosphere(1);
  const size_t good = mesh.triangles.size();
  const float nan = std::nanf("");
  const auto base = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.push_back({nan, 0, 0});
  mesh.positions.push_back({0, HUGE_VALF, 0});
  mesh.triangles.insert(mesh.triangles.begin(), {base, 0, 1});
  mesh.triangles.push_back({0, 1, base + 1});
  mesh.triangles.push_back({0, 1, 4000000000u});
  mesh.triangles.push_back({3, 3, 1});
  const MeshDefects defects = drop_degenerate(mesh);
  EXPECT_EQ(defects.not_finite, 2u);
  EXPECT_EQ(defects.bad_index, 1u);
  EXPECT_EQ(defects.coincident, 1u);
  EXPECT_EQ(mesh.triangles.size(), good);
}

void add_triangle(TriangleMesh& mesh, Random& random, const Vec3& at, double size) {
  const auto base = static_cast<uint32_t>(mesh.positions.size());
  for (int k = 0; k < 3; ++k) {
    const Vec3 p = at + random.in_cube(size);
    mesh.positions.push_back(
        {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  mesh.triangles.push_back({base, base + 1, base + 2});
}

void expect_sound_tree(TriangleMesh mesh, const char* name, double spread, int rays) {
  drop_degenerate(mesh);
  const auto shared = std::make_shared<const TriangleMesh>(std::move(mesh));
  const Accelerators all = Accelerators::over(shared);
  for (size_t i = 1; i < all.all.size(); ++i) {
    EXPECT_LE(all.all[i]->statistics().depth, WideTree::kMaxDepth) << name;
    EXPECT_LE(all.all[i]->statistics().nodes, shared->triangles.size() + 1) << name;
  }
  Random random(18, 1);
  int wrong = 0;
  for (int i = 0; i < rays; ++i) {
    const Point3 origin = Point3{} + random.in_cube(spread);
    wrong += disagreements(all, {origin, (Point3{} + random.in_cube(spread * 0.3)) - origin});
  }
  EXPECT_EQ(wrong, 0) << name;
}

TEST(N18, DegenerateInputBuildsABoundedTree) {
  Random random(18, 1);
  TriangleMesh same;
  for (int i = 0; i < 100000; ++i) {
    if (i == 0) add_triangle(same, random, {}, 1);
    same.triangles.push_back({0, 1, 2});
  }
  expect_sound_tree(same, "identical triangles", 2, 20);
  TriangleMesh line;
  for (int i = 0; i < 2000; ++i) add_triangle(line, random, Vec3{i * 1.0, 0, 0}, 0.5);
  expect_sound_tree(line, "collinear", 2000, 100);
  TriangleMesh centred;
  for (int i = 0; i < 2000; ++i) {
    const auto base = static_cast<uint32_t>(centred.positions.size());
    const float r = 0.001f * static_cast<float>(i + 1);
    centred.positions.insert(centred.positions.end(), {{-r, -r, -r}, {r, r, r}, {r, -r, 0}});
    centred.triangles.push_back({base, base + 1, base + 2});
  }
  expect_sound_tree(centred, "one centre", 3, 200);
  TriangleMesh mixed;
  add_triangle(mixed, random, {}, 1e6);
  for (int i = 0; i < 2000; ++i) add_triangle(mixed, random, random.in_cube(1), 0.01);
  expect_sound_tree(mixed, "one huge among tiny", 2, 200);
  TriangleMesh doubling;
  for (int k = -120; k <= 120; ++k) {
    const double size = std::ldexp(1, k);
    add_triangle(doubling, random, Vec3{size, 0, 0}, size * 0.5);
  }
  expect_sound_tree(doubling, "doubling sizes", 1, 500);
  for (int n = 1; n <= 5; ++n) {
    TriangleMesh few;
    for (int i = 0; i < n; ++i) add_triangle(few, random, {}, 1);
    expect_sound_tree(few, "few", 2, 100);
  }
}

/// Triangles of which one in `one_in` lies within `reach` of the origin on each axis, and the
/// others within 1. Each takes up `size` of that on each axis.
TriangleMesh extreme_mesh(size_t count, const Vec3& reach, size_t one_in, double size,
                          Random& random) {
  TriangleMesh mesh;
  for (size_t i = 0; i < count; ++i) {
    const Vec3 within = i % one_in == 0 ? reach : Vec3{1, 1, 1};
    const auto base = static_cast<uint32_t>(mesh.positions.size());
    const Vec3 center = random.in_cube(1 - size);
    for (int k = 0; k < 3; ++k) {
      const Vec3 at = center + random.in_cube(size);
      mesh.positions.push_back({static_cast<float>(at.x * within.x),
                                static_cast<float>(at.y * within.y),
                                static_cast<float>(at.z * within.z)});
    }
    mesh.triangles.push_back({base, base + 1, base + 2});
  }
  drop_degenerate(mesh);
  return mesh;
}

/// Rays from near the origin, from afar and from triangles to points of triangles: how many hit.
/// Trees must have `leaves` leaves at least.
size_t expect_agreement(const std::shared_ptr<const TriangleMesh>& mesh, const Vec3& reach,
                        size_t leaves, int rays, Random& random, const std::string& name) {
  const Accelerators all = Accelerators::over(mesh);
  for (const auto& accelerator : all.all) {
    EXPECT_LE(accelerator->statistics().depth, WideTree::kMaxDepth) << name;
    if (dynamic_cast<const MeshLinearScan*>(accelerator.get()) == nullptr) {
      EXPECT_GE(accelerator->statistics().leaves, leaves) << name;
    }
  }
  const auto on_triangle = [&] {
    const auto [a, b, c] = mesh->corners(random.below(mesh->triangles.size()));
    const double u = random.uniform(0, 0.5), v = random.uniform(0, 0.5);
    return a + (b - a) * u + (c - a) * v;
  };
  size_t hits = 0;
  int wrong = 0;
  for (int i = 0; i < rays; ++i) {
    Point3 origin = Point3{} + random.in_cube(2);
    if (i % 3 == 1) {
      const Vec3 at = random.in_cube(2);
      origin = Point3{at.x * reach.x, at.y * reach.y, at.z * reach.z};
    }
    if (i % 3 == 2) origin = on_triangle();
    Vec3 direction = on_triangle() - origin;
    if (i % 2 == 0) direction = normalize(direction);
    const Ray ray{origin, direction};
    wrong += disagreements(all, ray);
    Hit hit;
    TraversalCounters counters;
    hits += all.all[0]->closest_hit(ray, hit, counters);
  }
  EXPECT_EQ(wrong, 0) << name;
  return hits;
}

TEST(N18, CoordinatesNearTheEndOfSinglePrecisionBuildAndTraceAsByTheScan) {
  // Extents and their sums overflow single precision, where the trees' builders work.
  size_t hits = 0;
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    Random random(518, seed);
    for (const double size : {1e37, 1.7e38, 2.5e38, 3.4e38}) {
      for (const Vec3& axes : {Vec3{1, 1, 1}, Vec3{1, 1e-38, 1e-38}, Vec3{1e-30, 1, 1e-19}}) {
        for (const size_t count : {100, 1000, 10000}) {
          for (const size_t one_in : {1, 2, 50}) {
            const Vec3 reach = axes * size;
            // Small ones that a tree can tell apart, or ones as large as all of them.
            const double part = one_in == 1 ? 0.02 : 0.9;
            const auto mesh = std::make_shared<const TriangleMesh>(
                extreme_mesh(count, reach, one_in, part, random));
            const std::string name = "seed " + std::to_string(seed) + ": " + std::to_string(count) +
                                     " triangles within " + describe({Point3{} + reach, axes}) +
                                     ", one in " + std::to_string(one_in);
            const size_t leaves = one_in == 1 ? count / 50 : 1;
            const int rays = count == 10000 ? 6 : 30;
            hits += expect_agreement(mesh, reach, leaves, rays, random, name);
          }
        }
      }
    }
  }
  EXPECT_GT(hits, 2000u);
}

TEST(N18, TinyCoordinatesBuildAndTraceAsByTheScan) {
  Random random(618, 1);
  size_t hits = 0;
  for (const double size : {1e-30, 1e-37, 1e-40, 1e-43}) {
    const Vec3 reach = Vec3{1, 1, 1} * size;
    const auto mesh =
        std::make_shared<const TriangleMesh>(extreme_mesh(500, reach, 1, 0.5, random));
    ASSERT_GT(mesh->triangles.size(), 100u);
    hits += expect_agreement(mesh, reach, 1, 100, random, describe({Point3{} + reach, reach}));
  }
  EXPECT_GT(hits, 30u);
}

/// Primitives that each accelerator tests for a ray, on the average, at most: from about the middle
/// of where `aim` draws its targets.
template <typename Aim>
double most_tests(const Accelerators& all, const Point3& from, Aim&& aim) {
  constexpr int kRays = 200;
  double most = 0;
  for (size_t i = 1; i < all.all.size(); ++i) {
    Random random(218, 1);
    TraversalCounters counters;
    for (int k = 0; k < kRays; ++k) {
      Hit hit;
      all.all[i]->closest_hit({from, aim(random) - from}, hit, counters);
      all.all[i]->any_hit({from, aim(random) - from}, counters);
    }
    most = std::max(most, static_cast<double>(counters.primitive_tests) / (2 * kRays));
  }
  return most;
}

TEST(N18, TreesCullFarFromTheOriginAndBesideSomethingHuge) {
  for (const double far : {0.0, 1e4, 1e6}) {
    const Vec3 by{far, -far, 0.5 * far};
    const auto mesh = std::make_shared<const TriangleMesh>(moved(icosphere(5), 1, by));
    Accelerators all = Accelerators::over(mesh);
    if (has_embree()) all.all.pop_back();  // its boxes all overlap there
    EXPECT_LT(
        most_tests(all, Point3{} + by, [&](Random& r) { return Point3{} + by + r.direction(); }),
        64)
        << "of " << mesh->triangles.size() << " at " << far;
    std::vector<Instance> balls;
    Random random(318, 1);
    for (int i = 0; i < 3000; ++i)
      balls.push_back(
          {std::make_shared<Sphere>(Point3{} + by + random.in_cube(40), 0.5), Transform{}});
    EXPECT_LT(most_tests(Accelerators::over(balls), Point3{} + by,
                         [&](Random& r) { return Point3{} + by + r.direction(); }),
              64)
        << "at " << far;
  }
  Random random(418, 1);
  TriangleMesh mesh;
  add_triangle(mesh, random, {}, 1e7);
  std::vector<Instance> balls{{std::make_shared<Sphere>(Point3{0, -1e7, 0}, 1e7 - 1), Transform{}}};
  for (int i = 0; i < 3000; ++i) {
    add_triangle(mesh, random, random.in_cube(1), 0.01);
    balls.push_back({std::make_shared<Sphere>(Point3{} + random.in_cube(1), 0.01), Transform{}});
  }
  const auto aim = [](Random& r) { return Point3{} + r.in_cube(1); };
  Accelerators all = Accelerators::over(std::make_shared<const TriangleMesh>(std::move(mesh)));
  if (has_embree()) all.all.pop_back();
  // The octrees' voxels are no narrower than 2^-19 of the whole.
  std::erase_if(all.all, [](const auto& a) { return dynamic_cast<const MeshOctree*>(a.get()); });
  EXPECT_LT(most_tests(all, {0.1, 0.2, 0.3}, aim), 64);
  all = Accelerators::over(balls);
  std::erase_if(all.all,
                [](const auto& a) { return dynamic_cast<const InstanceOctree*>(a.get()); });
  EXPECT_LT(most_tests(all, {0.1, 0.2, 0.3}, aim), 64);
}

TEST(N18, TreesDoNotDependOnThreads) {
  const TriangleMesh mesh = triangle_soup(300000, 5);
  const MeshBvh one(mesh, 1), three(mesh, 3);
  EXPECT_EQ(one.statistics().nodes, three.statistics().nodes);
  EXPECT_EQ(one.statistics().bytes, three.statistics().bytes);
  Random random(118, 1);
  TraversalCounters a, b;
  for (int i = 0; i < 2000; ++i) {
    const Ray ray{Point3{} + random.in_cube(2), random.direction()};
    Hit hit_a, hit_b;
    one.closest_hit(ray, hit_a, a);
    three.closest_hit(ray, hit_b, b);
    EXPECT_EQ(hit_a, hit_b);
  }
  EXPECT_EQ(a.node_visits, b.node_visits);
  EXPECT_EQ(a.primitive_tests, b.primitive_tests);
}

TEST(N18, AnEmptySceneHitsNothing) {
  const auto empty = std::make_shared<const TriangleMesh>();
  Hit hit;
  TraversalCounters counters;
  const Ray ray{{0, 0, 0}, {0, 0, 1}};
  EXPECT_FALSE(
      make_mesh_accelerator(empty, AcceleratorKind::bvh, 2)->closest_hit(ray, hit, counters));
  EXPECT_FALSE(make_instance_accelerator({}, AcceleratorKind::bvh, 2)->any_hit(ray, counters));
  std::vector<Instance> hollow(5, {make_mesh_shape(empty, AcceleratorKind::bvh, 1)});
  EXPECT_FALSE(
      make_instance_accelerator(hollow, AcceleratorKind::bvh, 2)->closest_hit(ray, hit, counters));
}

TEST(N20, AcceleratorsAgreeOnTrianglesSeenEdgeOn) {
  size_t hits = 0;
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(120, seed);
    // Far apart, so that none hides another; every second one a sliver. Now and then enough of them
    // for an octree to cut them up.
    TriangleMesh mesh;
    const int count = seed % 6 == 0 ? 300 : 12;
    for (int i = 0; i < count; ++i) {
      const Vec3 a = random.in_cube(1) + Vec3{i * 7.0, 0, 0}, b = a + random.in_cube(1);
      const Vec3 along = (b - a) * random.uniform();
      const double off = i % 2 ? 1 : std::pow(10, random.uniform(-7, -2));
      const Vec3 c = a + along + random.in_cube(off);
      const auto base = static_cast<uint32_t>(mesh.positions.size());
      for (const Vec3& p : {a, b, c})
        mesh.positions.push_back(
            {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
      mesh.triangles.push_back({base, base + 1, base + 2});
    }
    // Beside something huge boxes are told apart in double alone, and by a smaller margin.
    if (seed % 12 == 0) add_triangle(mesh, random, {1e9, 1e9, 0}, 1e9);
    drop_degenerate(mesh);
    const auto shared = std::make_shared<const TriangleMesh>(mesh);
    const Accelerators all = Accelerators::over(shared);
    int wrong = 0;
    for (int i = 0; i < 1000; ++i) {
      // In the plane of a triangle, through two points of it, often close to a corner.
      const auto t = random.below(static_cast<size_t>(count));
      const auto [a, b, c] = shared->corners(t);
      const double corner = random.below(2) ? 1 : std::pow(10, random.uniform(-4, 0));
      const Point3 p = a + (b - a) * (corner * random.uniform());
      const Point3 q = a + (c - a) * (corner * random.uniform());
      const double back = random.uniform(0, 5) / corner;
      const Ray ray{p + (p - q) * back, (q - p) * std::pow(10, random.uniform(-3, 3))};
      wrong += disagreements(all, ray);
      Hit hit;
      TraversalCounters counters;
      if (!all.all[0]->closest_hit(ray, hit, counters)) continue;
      ++hits;
      // Leave just this hit in reach: boxes must not be culled by a t that is not in them.
      Ray until = ray, from = ray;
      until.t_max = next_up(hit.t);
      from.t_min = next_down(hit.t);
      wrong += disagreements(all, until) + disagreements(all, from);
    }
    EXPECT_EQ(wrong, 0) << "seed " << seed << " stream 120";
  }
  EXPECT_GT(hits, 5000u);
}

}  // namespace
}  // namespace tessera::numerics
