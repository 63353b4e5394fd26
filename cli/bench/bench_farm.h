#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace tessera {

struct BenchFarmOptions {
  std::string scene;  ///< a file to render at 1080p; empty: a scene of spheres made for this
  int workers = 4;
  int repeats = 5;
  int rings = 2000;    ///< of the sphere whose mesh is sent to all workers
  std::string only{};  ///< one of bench_farm_kinds(); empty: all
};

/// What its rows are about.
const std::vector<std::string>& bench_farm_kinds();

/// What distribution costs, one row a measure: `measure, seconds, reference_seconds, ratio, limit,
/// beyond_limit`. Each pair is measured in turns; seconds are medians, the ratio is the median of
/// the pairs'. What is no pair has no ratio: its limit is of the seconds.
nlohmann::json bench_farm(const BenchFarmOptions& options);

}  // namespace tessera
