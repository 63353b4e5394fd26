#pragma once

#include <cstdint>

#include "coordinator/jobs/scheduling.h"
#include "coordinator/tiles/tile_rules.h"

namespace tessera {

/// How jobs are taken on; the defaults are for a farm.
struct JobRules : TileRules {
  int expected_workers = 4;  ///< threads that trace, for the choice of a tile size; above 0
  /// The share of tiles that a second worker traces too, from 0 to 1, and what chooses them.
  double verify = 0;
  uint64_t verify_key = 0;
  /// Keys of workers that are let in; 0: there are no keys. See WorkerKeys.
  size_t worker_keys = 0;
  /// What the submissions that clients are sending may take together: blobs, scenes and films.
  uint64_t client_budget_bytes = uint64_t{32} << 30;
  /// Of the frames that run, whose films may not take more than client_budget_bytes either, a sum
  /// of its own. A frame whose film alone is larger than both allow is refused; others wait.
  BeginLimits begin{};
  size_t scenes_of_worker = 16;  ///< that a worker is told of at one time; above 0
  /// Where workers can map the memory of this process; 0: they cannot. RenderLoop fills it in.
  uint32_t shared_by_process = 0;
};

}  // namespace tessera
