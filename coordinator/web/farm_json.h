#pragma once

#include <string>

#include "coordinator/web/farm_monitor.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

// What is shown, as JSON texts of /api/v1. Numbers that exceed what a browser can count, such as
// the ids of workers, are strings. docs/operating.md tells the fields.

/// All but history.
std::string farm_json(const FarmSnapshot& snapshot);
std::string jobs_json(const FarmSnapshot& snapshot);
std::string workers_json(const FarmSnapshot& snapshot);
/// One of its jobs.
std::string job_json(const FarmSnapshot::Job& job);
/// Columns of equal length, by the names of FarmSample's fields.
std::string history_json(const std::vector<FarmSample>& history);
/// The tiles of a frame as rows of numbers, whose meaning "columns" tells.
std::string tiles_json(uint64_t job, uint32_t frame, const FrameShown& shown);

}  // namespace tessera
