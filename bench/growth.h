#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/accel/accelerator.h"

namespace tessera {

/// One line of `tessera bench growth`: an accelerator over a mesh of one size.
struct GrowthBenchRow {
  std::string scene;  ///< soup: triangles all over a cube; surface: those of a ball
  std::string accelerator;
  size_t triangles = 0;
  double build_seconds = 0;         ///< on the wall, with all threads of the options
  double microseconds_per_ray = 0;  ///< one thread, rays all over, closest hits
  double node_visits_per_ray = 0;
  double triangle_tests_per_ray = 0;
  double bytes_per_triangle = 0;
};

struct GrowthBenchOptions {
  std::vector<AcceleratorKind> accelerators{AcceleratorKind::bvh, AcceleratorKind::octree,
                                            AcceleratorKind::nonuniform_octree};
  size_t least = 1'000, most = 10'000'000;  ///< triangles; sizes in between are powers of ten
  size_t most_of_octrees = 1'000'000;       ///< larger ones take minutes to build
  int rays = 200'000;
  int build_threads = 1;
  uint64_t seed = 1;
};

std::vector<GrowthBenchRow> bench_growth(const GrowthBenchOptions& options);

/// The kinds of text that `tessera bench growth` writes.
std::string growth_table(const std::vector<GrowthBenchRow>& rows);
std::string growth_json(const std::vector<GrowthBenchRow>& rows);
/// Build time and time a ray over the number of triangles, both axes logarithmic.
std::string growth_svg(const std::vector<GrowthBenchRow>& rows);

}  // namespace tessera
