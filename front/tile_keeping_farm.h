#pragma once

#include <memory>

#include "front/tracing_farm.h"

namespace tessera {

/// `farm`, which traces on this machine, with finished tiles of each job kept in the file that its
/// JobSpec::kept_tiles names: a job that is interrupted leaves them there, and one that is done
/// deletes them.
std::unique_ptr<TracingFarm> keep_finished_tiles(std::unique_ptr<TracingFarm> farm);

}  // namespace tessera
