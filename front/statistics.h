#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "job/job.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// Wall-clock seconds of the phases that this process goes through by itself.
struct PhaseSeconds {
  double parse = 0;
  double write = 0;
  double total = 0;
};

/// All that --stats tells about one frame.
struct FrameStatistics {
  std::string scene_digest;
  v1::FrameSettings frame;
  int width = 0, height = 0;  ///< of what was rendered: the crop's, if there is one
  PhaseSeconds seconds;
  JobReport report;
  uint64_t peak_worker_bytes = 0;
  std::string pixels_sha256;
};

/// The JSON object of --stats. Counters of the report that count no work appear under "skips".
nlohmann::ordered_json statistics_json(const FrameStatistics& statistics);

}  // namespace tessera
