#pragma once

#include <chrono>
#include <cstdint>
#include <string>

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

  /// The frame was there before this coordinator: what was given out then is adopted.
  bool adopts = false;
  /// 16 random bytes that name this coordinator, drawn at each start. RenderLoop fills them in.
  std::string opening{};
};

}  // namespace tessera
