#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/jobs/farm_snapshot.h"
#include "coordinator/jobs/job.h"
#include "coordinator/jobs/scheduling.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// What is the same for all jobs while they are asked about.
struct FarmState {
  int workers = 0;  ///< there are
  BeginLimits limits{};
  std::vector<OpenJob> begun;   ///< jobs that are
  std::vector<int32_t> served;  ///< the priorities of jobs whose tiles workers hold
  std::string trouble;          ///< why no tile is assigned
};

/// What the job needs to go on, as a noun phrase; empty: nothing, or it has ended. `open`: the job
/// itself.
std::string waits_for(const Job& job, const OpenJob& open, const FarmState& farm);
/// How the job is, as clients are told, with that frame's end.
v1::JobStatus status_of(const Job& job, const OpenJob& open, const FarmState& farm, uint32_t frame,
                        Time now);
/// The same for people.
FarmSnapshot::Job describe(const Job& job, const OpenJob& open, const FarmState& farm, Time now);

}  // namespace tessera
