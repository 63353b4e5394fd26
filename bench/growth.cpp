#include "bench/growth.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "bench/generated_meshes.h"
#include "bench/thread_seconds.h"
#include "renderer/accel/make_accelerator.h"

namespace tessera {
namespace {

/// A ball of about `count` triangles, all of much the same size.
TriangleMesh ball(size_t count) {
  TriangleMesh mesh;
  const auto rings =
      static_cast<uint32_t>(std::max(3.0, std::sqrt(static_cast<double>(count) / 4)));
  const uint32_t around = 2 * rings;
  for (uint32_t r = 0; r <= rings; ++r) {
    const double polar = std::numbers::pi * r / rings;
    for (uint32_t s = 0; s < around; ++s) {
      const double turn = 2 * std::numbers::pi * s / around;
      mesh.positions.push_back({static_cast<float>(std::sin(polar) * std::sin(turn)),
                                static_cast<float>(std::cos(polar)),
                                static_cast<float>(std::sin(polar) * std::cos(turn))});
    }
  }
  const auto at = [around](uint32_t r, uint32_t s) { return r * around + s % around; };
  for (uint32_t r = 0; r < rings; ++r) {
    for (uint32_t s = 0; s < around; ++s) {
      if (r + 1 < rings) mesh.triangles.push_back({at(r, s), at(r + 1, s), at(r + 1, s + 1)});
      if (r > 0) mesh.triangles.push_back({at(r, s), at(r + 1, s + 1), at(r, s + 1)});
    }
  }
  drop_degenerate(mesh);
  return mesh;
}

/// From all over a sphere about the mesh to all over a cube inside of it.
std::vector<Ray> rays_through(const Bounds3& box, int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto unit = [&random] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const double size = length(box.diagonal());
  std::vector<Ray> rays;
  while (std::ssize(rays) < count) {
    const Vec3 out{2 * unit() - 1, 2 * unit() - 1, 2 * unit() - 1};
    if (!(length(out) > 0.01 && length(out) < 1)) continue;
    const Vec3 d = box.diagonal();
    const Point3 target{box.min.x + d.x * unit(), box.min.y + d.y * unit(),
                        box.min.z + d.z * unit()};
    const Point3 origin = box.center() + normalize(out) * size;
    rays.push_back({origin, normalize(target - origin)});
  }
  return rays;
}

GrowthBenchRow measure(const std::string& scene, std::shared_ptr<const TriangleMesh> mesh,
                       AcceleratorKind kind, const GrowthBenchOptions& options) {
  const auto accelerator = make_mesh_accelerator(mesh, kind, options.build_threads);
  const AcceleratorStatistics statistics = accelerator->statistics();
  const auto triangles = static_cast<double>(mesh->triangles.size());
  GrowthBenchRow row{scene, std::string(accelerator_name(kind)), mesh->triangles.size()};
  row.build_seconds = statistics.build_seconds;
  row.bytes_per_triangle = static_cast<double>(statistics.bytes) / triangles;
  const std::vector<Ray> rays = rays_through(mesh->bounds(), options.rays, options.seed);
  double least = 1e300;
  for (int round = 0; round < 3; ++round) {
    TraversalCounters counters;
    const double start = thread_seconds();
    for (const Ray& ray : rays) {
      Hit hit;
      accelerator->closest_hit(ray, hit, counters);
    }
    least = std::min(least, thread_seconds() - start);
    row.node_visits_per_ray = static_cast<double>(counters.node_visits) / options.rays;
    row.triangle_tests_per_ray = static_cast<double>(counters.primitive_tests) / options.rays;
  }
  row.microseconds_per_ray = 1e6 * least / options.rays;
  return row;
}

}  // namespace

std::vector<GrowthBenchRow> bench_growth(const GrowthBenchOptions& options) {
  std::vector<GrowthBenchRow> rows;
  for (const std::string scene : {"soup", "surface"}) {
    for (size_t count = options.least; count <= options.most; count *= 10) {
      const auto mesh = std::make_shared<const TriangleMesh>(
          scene == "soup" ? triangle_soup(count, options.seed) : ball(count));
      for (const AcceleratorKind kind : options.accelerators) {
        const bool is_octree =
            kind == AcceleratorKind::octree || kind == AcceleratorKind::nonuniform_octree;
        if (is_octree && count > options.most_of_octrees) continue;
        rows.push_back(measure(scene, mesh, kind, options));
      }
    }
  }
  return rows;
}

}  // namespace tessera
