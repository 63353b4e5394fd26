#pragma once

#include <chrono>
#include <cstdint>

#include "base/monotonic.h"

namespace tessera {

/// When tiles are given to whom; the defaults are for a farm. Lengths of time are above zero.
struct TileRules {
  Time lease = std::chrono::seconds(10);          ///< a tile without progress
  Time settle = std::chrono::milliseconds(2500);  ///< for what was sent to show in heartbeats
  /// A second copy of a tile is issued no sooner than this after the first.
  Time speculate_after = std::chrono::milliseconds(100);
  /// No tile is split into parts that take less than this.
  Time smallest_part = std::chrono::milliseconds(4);

  // What RenderLoop fills in.
  uint64_t farm = 0;   ///< of the store; 0: jobs end with this process
  uint64_t epoch = 0;  ///< another at each start of a coordinator, below 2^44
};

}  // namespace tessera
