#pragma once

#include <atomic>
#include <memory>

#include "coordinator/job.h"
#include "proto/transport/transport.h"

namespace tessera {

/// Submits `job` to the coordinator behind `transport`, serves it the blobs that it lacks, waits
/// for the end and fetches the picture. `stop` cancels the job there. Throws render_error if nobody
/// answers for `patience_seconds`.
JobResult run_remote_job(ClientTransport& transport, const JobSpec& job,
                         const ProgressCallback& progress, const std::atomic<bool>& stop,
                         double patience_seconds = 15);

}  // namespace tessera
