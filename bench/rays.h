#pragma once

#include <string>
#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

struct BenchMesh {
  std::string name;
  TriangleMesh mesh;     ///< without degenerate triangles
  bool indoors = false;  ///< eye and light are inside of it
};

/// One line of `tessera bench rays`.
struct RayBenchRow {
  std::string scene, accelerator;
  std::string kind;  ///< primary, packets (of primary rays), shadow, diffuse, ao, shuffled
  double mrays_per_second = 0;  ///< one thread, ray set-up included
  double ratio_to_embree = 0;   ///< in the same run; 0 where Embree is absent
  size_t mismatches = 0;        ///< rays on whose answer the accelerator and Embree differ by
                                ///< more than rounding
  double build_seconds = 0;
  double bytes_per_triangle = 0;  ///< of the accelerator, without the mesh
};

struct RayBenchOptions {
  std::vector<AcceleratorKind> accelerators{AcceleratorKind::bvh};
  int image_side = 512;  ///< primary rays: the square of this
  int rounds = 9;        ///< alternating; the median counts
  int build_threads = 1;
  uint64_t seed = 1;
};

/// Runs every accelerator, and Embree where it is there, over the five kinds of rays of each mesh.
std::vector<RayBenchRow> bench_rays(const std::vector<BenchMesh>& meshes,
                                    const RayBenchOptions& options);

}  // namespace tessera
