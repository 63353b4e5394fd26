#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// "queued", "running", "paused", "held", "done", "cancelled", "failed" or "unknown".
std::string state_name(const v1::JobStatus& status);

/// How much of its tiles is done, rounded down.
int percent(const v1::JobStatus& status);

/// The JSON object of `tessera status JOB --json`.
nlohmann::ordered_json status_json(const v1::JobStatus& status);

}  // namespace tessera
