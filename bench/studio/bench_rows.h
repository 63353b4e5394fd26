#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "base/monotonic.h"
#include "bench/studio/page_client.h"
#include "bench/studio/studio_bench.h"
#include "bench/studio/studio_process.h"

// The parts of bench_studio(), and what they share.

namespace tessera {

/// A bench under way. Refers to what its owner keeps.
struct StudioBench {
  const StudioBenchOptions& options;
  std::filesystem::path folder;  ///< that the studio has opened
  const std::function<void(const StudioBenchRow&)>& add;
  const StudioProcess& studio;
};

/// From keys, movements of the camera and clicks to pixels.
void add_view_rows(const StudioBench& bench);
/// Reconnecting, full pictures, memory, idling.
void add_lasting_rows(const StudioBench& bench);
/// What the page measures of itself in a browser while it is typed in.
void add_browser_rows(const StudioBench& bench);

inline constexpr int kViewWidth = 960, kViewHeight = 540;

double milliseconds_since(Time begin);
void pause(int milliseconds);
/// What a page asks for that shows the file.
nlohmann::json view_of(const std::string& file, int width = kViewWidth, int height = kViewHeight);
/// A page that shows that file, with its first pixels there; with `whole`, its last.
PageClient show(const StudioProcess& studio, const std::string& file, bool whole = false);

}  // namespace tessera
