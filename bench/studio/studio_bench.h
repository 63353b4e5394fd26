#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// One line of `tessera bench studio`.
struct StudioBenchRow {
  std::string measure;
  double value = 0;
  std::string unit;  ///< of the value and its limits: "ms", "1/s", "ratio", "%", "MiB" ...
  std::optional<double> at_most{}, at_least{};  ///< neither: it is only told
  std::string note{};                           ///< what else was seen

  bool misses() const {
    return (at_most && !(value <= *at_most)) || (at_least && !(value >= *at_least));
  }
};

struct StudioBenchOptions {
  std::filesystem::path scenes;  ///< a folder, which is copied; it needs our samples
  int rounds = 12;               ///< of keys in each scene; others are multiples of it
  int samples = 64;              ///< a pixel, of the full picture
  int idle_seconds = 10;
  size_t triangles = 1'000'000;  ///< of the mesh beside an edited .mtl
  std::string browser;           ///< Chromium, for the rows of the page; empty: they are left out
  /// Told what is measured next.
  std::function<void(std::string_view)> begin = [](std::string_view) {};
  /// Called again and again while the bench waits; what it throws ends the bench and its processes.
  std::function<void()> check = [] {};
};

/// Starts a studio of its own and works with it as a page does: first over a WebSocket, then by
/// keys in a browser. `add` is called with each row as it comes. Changes the environment of this
/// process: the studio and the browser keep what they keep in a temporary folder.
void bench_studio(const StudioBenchOptions& options,
                  const std::function<void(const StudioBenchRow&)>& add);

}  // namespace tessera
