#pragma once

#include "job/job.h"

namespace tessera {

/// Throws usage_error for a frame, crop or tile size that cannot be, scene_error for a scene of too
/// many blobs.
void check_job(const JobSpec& spec);

}  // namespace tessera
