// N01, N02, N03: rays from inside a closed mesh, many aimed at its vertices and edges, all hit it.
#include "bench/generated_meshes.h"
#include "tests/numerics/accelerators.h"

namespace tessera::numerics {
namespace {

const Vec3 kOffset{1.48376, 0.01234, -2.23423};

/// A shard is an offset: 0, 10^0 to 10^6, so that a mesh gets its trees once.
class Watertight : public testing::TestWithParam<double> {
 protected:
  static std::vector<TriangleMesh> closed_meshes(Random& random) {
    return {icosphere(0), icosphere(2), icosphere(5), bumpy_sphere(16, random)};
  }
};
using N01 = Watertight;
using N02 = Watertight;
const auto kOffsets = testing::Values(0.0, 1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6);

/// Misses among all accelerators; the linear scan takes part where the mesh is small.
struct MissCounter {
  size_t rays = 0, misses = 0;
  std::string first;

  void trace(const Accelerators& accelerators, const Ray& ray) {
    for (const auto& accelerator : accelerators.all) {
      TraversalCounters counters;
      Hit hit;
      const bool closest = accelerator->closest_hit(ray, hit, counters);
      ++rays;
      if (closest && accelerator->any_hit(ray, counters)) continue;
      if (misses++ == 0) first = describe(ray);
    }
  }
};

/// Towards a vertex, a point of an edge, or anywhere.
Vec3 aim(const TriangleMesh& mesh, const Point3& origin, Random& random) {
  const auto corner = mesh.corners(random.below(mesh.triangles.size()));
  if (random.below(3) == 0) return corner[0] - origin;
  const double shares[5] = {0, 0.25, 0.5, 0.75, 1};
  const double s = random.below(2) ? random.uniform() : shares[random.below(5)];
  return (corner[0] + (corner[1] - corner[0]) * s) - origin;
}

/// `full` rays in all shards and meshes together, from near the middle.
void expect_closed(double offset, uint64_t stream, int64_t full, bool aimed,
                   const std::vector<TriangleMesh>& meshes) {
  for (const TriangleMesh& base : meshes) {
    const Vec3 by = kOffset * offset;
    const auto mesh = std::make_shared<const TriangleMesh>(moved(base, 1, by));
    const auto all =
        Accelerators::over(mesh, mesh->triangles.size() < 1000 ? Which::all : Which::fast_anywhere);
    for (uint64_t seed = 1; seed <= 8; ++seed) {
      Random random(stream, seed);
      MissCounter count;
      // The large one gets a sixteenth of the rays.
      const int64_t share = mesh->triangles.size() < 1000 ? 5 : 1;
      for (int64_t i = 0; i < long_ray_count(full / 8 / 8 * share / 16); ++i) {
        const Point3 origin = Point3{} + by + random.in_cube(0.25);
        count.trace(all, {origin, aimed ? aim(*mesh, origin, random) : random.direction()});
      }
      EXPECT_EQ(count.misses, 0u) << "of " << count.rays << ", seed " << seed << " stream "
                                  << stream << ": " << count.first;
    }
  }
}

TEST_P(N01, NoRandomRayLeavesAClosedMesh) {
  Random random(1);
  expect_closed(GetParam(), 1, 100'000'000, false, closed_meshes(random));
}
INSTANTIATE_TEST_SUITE_P(Offset, N01, kOffsets);

TEST_P(N02, NoRayAimedAtAVertexOrEdgeLeavesAClosedMesh) {
  Random random(2);
  expect_closed(GetParam(), 2, 100'000'000, true, closed_meshes(random));
}
INSTANTIATE_TEST_SUITE_P(Offset, N02, kOffsets);

/// t of the plane of a triangle, in quad precision.
Quad exact_t(const std::array<Point3, 3>& p, const Ray& ray) {
  const QuadVec a(p[0]);
  const QuadVec n = cross(QuadVec(p[1]) - a, QuadVec(p[2]) - a);
  return dot(n, a - QuadVec(ray.origin)) / dot(n, QuadVec(ray.direction));
}

class N03 : public testing::TestWithParam<double> {};

TEST_P(N03, ClosedAtEveryScale) {
  const double offset = GetParam();
  const TriangleMesh base = icosphere(2);
  for (double scale = 1e-6; scale < 2e6; scale *= 10) {
    if (scale / offset < 0x1p-20) continue;
    const Vec3 by = kOffset * offset;
    const auto mesh = std::make_shared<const TriangleMesh>(moved(base, scale, by));
    const Accelerators all = Accelerators::over(mesh);
    for (uint64_t seed = 1; seed <= 8; ++seed) {
      Random random(3, seed);
      MissCounter count;
      for (int64_t i = 0; i < long_ray_count(10'000'000 / 100 / 8); ++i) {
        const Point3 origin = Point3{} + by + random.in_cube(0.25) * scale;
        const Ray ray{origin, aim(*mesh, origin, random)};
        count.trace(all, ray);
        Hit hit;
        TraversalCounters counters;
        if (!all.all[0]->closest_hit(ray, hit, counters)) continue;
        const auto error =
            static_cast<double>(fabsq(exact_t(mesh->corners(hit.primitive), ray) - hit.t));
        const double size = size_of(origin) + size_of(ray.at(hit.t));
        EXPECT_LE(error * length(ray.direction), 8 * kUnitRoundoff * size) << describe(ray);
      }
      EXPECT_EQ(count.misses, 0u) << "scale " << scale << " seed " << seed << ": " << count.first;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Offset, N03, testing::Values(1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7));

}  // namespace
}  // namespace tessera::numerics
