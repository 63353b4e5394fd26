// N01, N02, N03: rays from inside a closed mesh, many aimed at its vertices and edges, all hit it.
#include <quadmath.h>

#include "bench/generated_meshes.h"
#include "tests/numerics/support.h"

namespace tessera::numerics {
namespace {

const Vec3 kOffset{1.48376, 0.01234, -2.23423};

std::vector<TriangleMesh> closed_meshes(Pcg32& random) {
  return {icosphere(0), icosphere(2), icosphere(5), bumpy_sphere(16, random)};
}

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
Vec3 aim(const TriangleMesh& mesh, const Point3& origin, Pcg32& random) {
  const auto corner = mesh.corners(random.below(static_cast<uint32_t>(mesh.triangles.size())));
  if (random.below(3) == 0) return corner[0] - origin;
  const double shares[5] = {0, 0.25, 0.5, 0.75, 1};
  const double s = random.below(2) ? random.unit() : shares[random.below(5)];
  return (corner[0] + (corner[1] - corner[0]) * s) - origin;
}

TEST(N01, NoRandomRayLeavesAClosedMesh) {
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    Pcg32 random(seed, 1);
    MissCounter count;
    for (const TriangleMesh& base : closed_meshes(random)) {
      for (double k = 0; k <= 1e6; k = k == 0 ? 1 : k * 10) {
        const auto mesh = std::make_shared<const TriangleMesh>(moved(base, 1, kOffset * k));
        const Accelerators all = Accelerators::over(mesh, mesh->triangles.size() < 1000);
        for (int i = 0; i < 400; ++i) {
          const Point3 origin = Point3{} + kOffset * k + random.in_cube(0.25);
          count.trace(all, {origin, random.direction()});
        }
      }
    }
    EXPECT_EQ(count.misses, 0u) << "of " << count.rays << ", seed " << seed
                                << " stream 1: " << count.first;
  }
}

TEST(N02, NoRayAimedAtAVertexOrEdgeLeavesAClosedMesh) {
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    Pcg32 random(seed, 2);
    MissCounter count;
    for (const TriangleMesh& base : closed_meshes(random)) {
      for (double k = 0; k <= 1e6; k = k == 0 ? 1 : k * 10) {
        const auto mesh = std::make_shared<const TriangleMesh>(moved(base, 1, kOffset * k));
        const Accelerators all = Accelerators::over(mesh, mesh->triangles.size() < 1000);
        for (int i = 0; i < 1500; ++i) {
          const Point3 origin = Point3{} + kOffset * k + random.in_cube(0.25);
          count.trace(all, {origin, aim(*mesh, origin, random)});
        }
      }
    }
    EXPECT_EQ(count.misses, 0u) << "of " << count.rays << ", seed " << seed
                                << " stream 2: " << count.first;
  }
}

/// t of the plane of a triangle, in quad precision.
__float128 exact_t(const std::array<Point3, 3>& p, const Ray& ray) {
  __float128 e1[3], e2[3], to[3], d[3];
  for (int a = 0; a < 3; ++a) {
    e1[a] = static_cast<__float128>(p[1][a]) - p[0][a];
    e2[a] = static_cast<__float128>(p[2][a]) - p[0][a];
    to[a] = static_cast<__float128>(p[0][a]) - ray.origin[a];
    d[a] = ray.direction[a];
  }
  __float128 above = 0, below = 0;
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    const __float128 n = e1[b] * e2[c] - e1[c] * e2[b];
    above += n * to[a];
    below += n * d[a];
  }
  return above / below;
}

TEST(N03, ClosedAtEveryScaleAndOffset) {
  const TriangleMesh base = icosphere(2);
  for (double scale = 1e-6; scale < 2e6; scale *= 100) {
    for (double offset = 1; offset < 2e7; offset *= 100) {
      if (scale / offset < 0x1p-20) continue;
      Pcg32 random(1, 3);
      const Vec3 by = kOffset * offset;
      const auto mesh = std::make_shared<const TriangleMesh>(moved(base, scale, by));
      const Accelerators all = Accelerators::over(mesh);
      MissCounter count;
      for (int i = 0; i < 500; ++i) {
        const Point3 origin = Point3{} + by + random.in_cube(0.25) * scale;
        const Ray ray{origin, aim(*mesh, origin, random)};
        count.trace(all, ray);
        Hit hit;
        TraversalCounters counters;
        if (!all.all[0]->closest_hit(ray, hit, counters)) continue;
        const auto error =
            static_cast<double>(fabsq(exact_t(mesh->corners(hit.primitive), ray) - hit.t));
        const double size = length(origin - Point3{}) + length(ray.at(hit.t) - Point3{});
        EXPECT_LE(error * length(ray.direction), 8 * kUnitRoundoff * size) << describe(ray);
      }
      EXPECT_EQ(count.misses, 0u) << "scale " << scale << " offset " << offset << ": "
                                  << count.first;
    }
  }
}

}  // namespace
}  // namespace tessera::numerics
