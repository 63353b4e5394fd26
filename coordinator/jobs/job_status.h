#pragma once

#include <cstdint>
#include <string>

#include "base/monotonic.h"
#include "coordinator/jobs/farm_snapshot.h"
#include "coordinator/jobs/job.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// How the job is, as clients are told, with that frame's end. `trouble`: why no tile is assigned.
v1::JobStatus status_of(const Job& job, uint32_t frame, const std::string& trouble, Time now);
/// The same for people.
FarmSnapshot::Job describe(const Job& job, Time now);

}  // namespace tessera
