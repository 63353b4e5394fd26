#pragma once

#include <optional>
#include <string>
#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// Where the rays of a bench begin and go.
struct BenchView {
  Point3 eye, target, light;
};

struct BenchMesh {
  std::string name;
  TriangleMesh mesh;              ///< without degenerate triangles
  std::optional<BenchView> view;  ///< else from outside of it
};

/// From inside the box: from near a corner to the middle, the light below the ceiling.
BenchView view_inside(const Bounds3& box);

/// One line of `tessera bench rays`.
struct RayBenchRow {
  std::string scene, accelerator;
  std::string kind;  ///< primary, packets (of primary rays), shadow, diffuse, ao, shuffled
  double mrays_per_second = 0;  ///< one thread, ray set-up included
  double ratio_to_embree = 0;   ///< in the same run; 0 where Embree is absent
  size_t mismatches = 0;        ///< of `rays_checked`, answers without the bits of a linear scan
  size_t rays_checked = 0;      ///< every so many, as far as the scan's time allows
  size_t unlike_embree = 0;     ///< of all rays, answers that differ by more than rounding
  double node_visits_per_ray = 0, primitive_tests_per_ray = 0;  ///< 0 for Embree, which has none
  double build_seconds = 0;
  double bytes_per_triangle = 0;  ///< of the accelerator, without the mesh
};

struct RayBenchOptions {
  std::vector<AcceleratorKind> accelerators{AcceleratorKind::bvh};
  int image_side = 512;  ///< primary rays: the square of this
  int rounds = 9;        ///< alternating; the median counts
  int build_threads = 1;
  uint64_t seed = 1;
  size_t oracle_tests = size_t{1} << 25;  ///< triangles that a linear scan may test for each row
};

/// Runs every accelerator, and Embree where it is there, over the five kinds of rays of each mesh.
std::vector<RayBenchRow> bench_rays(const std::vector<BenchMesh>& meshes,
                                    const RayBenchOptions& options);

/// One row for each accelerator and kind over all scenes, named "geometric mean": of speeds,
/// ratios, build times and bytes; counts are summed.
std::vector<RayBenchRow> geometric_means(const std::vector<RayBenchRow>& rows);

}  // namespace tessera
