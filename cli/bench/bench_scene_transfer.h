#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "cli/bench/bench_farm.h"

namespace tessera {

/// How long a large mesh takes until all workers at once have it, verified, and what a second job
/// on it ships. `endpoint` decides how it gets to them: by messages or by shared memory.
nlohmann::json scene_transfer_row(const BenchFarmOptions& options, const std::string& endpoint);

}  // namespace tessera
