#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// "queued", "running", "paused", "held", "done", "cancelled", "failed" or "unknown".
std::string state_name(const v1::JobStatus& status);

/// Whether it would be rendered if there were anybody to do that: there are so many `workers`.
bool waits_for_workers(const v1::JobStatus& status, uint32_t workers);

/// How much of its tiles is done, rounded down.
int percent(const v1::JobStatus& status);

/// The JSON object of `tessera status JOB --json`.
nlohmann::ordered_json status_json(const v1::JobStatus& status, uint32_t workers);

}  // namespace tessera
