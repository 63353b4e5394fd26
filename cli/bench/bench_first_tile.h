#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "cli/bench/bench_farm.h"

namespace tessera {

/// How long it takes from the start of `tessera submit` until somebody who watches the web page's
/// server has a picture with a tile in it, of a scene that the farm knows. `folder` is for files.
nlohmann::json first_tile_row(const BenchFarmOptions& options, const std::string& folder);

}  // namespace tessera
