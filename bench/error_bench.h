#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/error/curve.h"
#include "scenes/generate/accuracy_scenes.h"

namespace tessera {

/// A way to make a picture: what is left out is as the scene says.
struct ErrorMethod {
  std::string name;              ///< as it was typed
  std::string integrator{};      ///< by the names of --integrator
  std::optional<int> pattern{};  ///< v1::Sampling::Pattern
  std::optional<int> filter{};   ///< v1::Sampling::Filter
  bool is_adaptive = false;   ///< stops at the error that the first method has with as many samples
  std::string accelerator{};  ///< by the names of --accel
};

/// "path+owen+tent+adaptive+octree": words in any order, at most one of each kind. Throws a usage
/// error for one that is none.
ErrorMethod parse_error_method(const std::string& text);

/// A picture of another renderer that is held against the same reference.
struct ErrorPeer {
  std::string name;
  double seconds = 0, samples = 0;
  Picture picture;
};

struct ErrorBenchOptions {
  std::vector<ErrorMethod> methods;
  int least_samples = 1, most_samples = 4096;  ///< both powers of two
  int seeds = 32;
  int threads = 1;
  bool cpu_time = false;      ///< seconds are processor time over threads, for machines with
                              ///< other work, in place of the wall's
  double budget_seconds = 0;  ///< for a scene, its reference included; 0: none. It makes the last
                              ///< rows fewer and with fewer seeds, never with less than kLeastSeeds
  int reference_samples = 65536;           ///< of each of both, at most; a power of two
  std::string cache_folder{};              ///< where references are kept; empty: nowhere
  std::vector<Picture> given_reference{};  ///< one or two pictures in place of rendered ones
  std::vector<ErrorPeer> peers{};
  /// Told before each picture: what comes, and the share of the scene's work that is done.
  std::function<void(const std::string& what, double share)> on_progress{};
};
inline constexpr int kLeastSeeds = 4;

/// Renders the scene by each method under many seeds, seed by seed in turns, and holds the pictures
/// against a closed form, a given reference or two converged pictures. Throws as rendering does.
SceneErrors bench_error(const AccuracyScene& scene, const ErrorBenchOptions& options);

}  // namespace tessera
