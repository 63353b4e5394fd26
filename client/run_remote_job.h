#pragma once

#include <atomic>
#include <string>

#include "base/monotonic.h"
#include "job/job.h"
#include "proto/transport/transport.h"

namespace tessera {

/// Has `job` rendered by the coordinator behind `transport`, which errors call `endpoint`. `stop`
/// cancels it there. `tiles` is told each part of the picture once, soon after it is done; without
/// it none is asked for. Throws render_error if the coordinator is silent for `patience`.
JobResult run_remote_job(ClientTransport& transport, const std::string& endpoint,
                         const JobSpec& job, const ProgressCallback& progress,
                         const std::atomic<bool>& stop, Time patience = std::chrono::seconds(15),
                         const TileCallback& tiles = {});

}  // namespace tessera
