#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Something that a scene may have many of and that its picture does not depend on.
struct UnneededKind {
  std::string name, description;
  /// Adds a thousand of them to the scene of the benchmark, or to its mesh of 2,562 vertices.
  void (*add)(LoadedScene& scene);
  /// Counters of building and tracing whose sum says how many were left out; one after '-' is
  /// subtracted. Empty where nothing counts them.
  std::vector<std::string> counters{};
};
const std::vector<UnneededKind>& unneeded_kinds();

/// The scene of the benchmark: spheres and a mesh on a ground under three lights.
LoadedScene skip_bench_scene();

/// A line of `tessera bench skip`: the scene beside the same scene with a thousand things of one
/// kind that its picture does not depend on.
struct SkipRow {
  std::string name, description;
  bool same_bits = false;
  int64_t left_out = 0;                  ///< by the counters of the kind
  double seconds = 0, seconds_with = 0;  ///< medians of tracing, in processor time
  double ratio = 0;                      ///< median over the turns of with / without
};

struct SkipBenchOptions {
  int repeats = 9;
  bool quick = false;  ///< a sixteenth of the pixels
};

/// Renders both scenes on this thread, in turns after a warm-up.
SkipRow bench_skip(const UnneededKind& kind, const SkipBenchOptions& options);

/// The ratio that a row should keep to; a row beyond it is marked, as times are never exact.
inline constexpr double kMostSkipRatio = 1.01;

/// What `tessera bench skip` writes.
std::string skip_table(const std::vector<SkipRow>& rows);
std::string skip_json(const std::vector<SkipRow>& rows);

}  // namespace tessera
