#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/skips.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// How two pictures of one scene may differ, with a skip and without.
enum class SkipBound {
  bits,     ///< not at all
  largest,  ///< by this much in any channel of any pixel, relative to its value where above 1
  rms,      ///< by this root mean square over pixels and channels
};

/// A kind of work that is skipped, and a scene that has much of it.
struct SkipCase {
  std::string name;
  std::string scene;  ///< what it is, in a few words
  bool Skips::*skip;
  LoadedScene (*make)();
  /// Counters whose sum, with the skip less without it, is how often it was skipped; one after '-'
  /// is taken off.
  std::vector<std::string> skipped;
  /// Those whose sum with the skip is how often it might have been.
  std::vector<std::string> of;
  SkipBound bound = SkipBound::bits;
  double limit = 0;  ///< of `bound`
};
/// One for every member of Skips, in their order.
const std::vector<SkipCase>& skip_cases();

/// A line of `tessera bench skip`.
struct SkipRow {
  std::string name, scene;
  bool same_bits = false;
  double difference = 0;  ///< in the measure of the case's bound
  SkipBound bound = SkipBound::bits;
  double limit = 0;
  bool within = false;  ///< the difference is what it may be
  uint64_t skipped = 0, of = 0;
  double seconds_off = 0, seconds_on = 0;  ///< medians of building and tracing, processor time
  double saving = 0;                       ///< median over the turns, as a share of seconds_off
};

struct SkipBenchOptions {
  int repeats = 9;
  bool quick = false;  ///< a sixteenth of the pixels
  std::function<void(const std::string& name)> on_progress{};
};

/// Renders the case's scene on this thread, with the skip and without in turns, after a warm-up.
SkipRow bench_skip(const SkipCase& skip, const SkipBenchOptions& options);

/// What `tessera bench skip` writes.
std::string skip_table(const std::vector<SkipRow>& rows);
std::string skip_json(const std::vector<SkipRow>& rows);

}  // namespace tessera
