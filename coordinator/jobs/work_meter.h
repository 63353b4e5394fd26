#pragma once

#include <cstdint>
#include <deque>

#include "base/monotonic.h"
#include "coordinator/tiles/tile_costs.h"

namespace tessera {

/// How long a job was worked on and, from what was traced by how many threads in that time, how
/// long the rest will take. Time in which nobody works at the job does not count. A plain value
/// without a clock.
class WorkMeter {
 public:
  /// `before`: the seconds for which it was worked on before this process.
  explicit WorkMeter(double before = 0) : before_(before) {}

  /// Counts the time since the last call, in which so many threads worked at the job; 0: nobody
  /// did. `traced`: what has been traced in this process, all of it by the last call's time, of
  /// `total` tiles.
  void account(Time now, size_t threads, TileWork traced, uint64_t total);
  /// The seconds for which it was worked on, those of earlier processes included.
  double seconds(Time now, bool works) const;
  /// The seconds that `left` will take so many threads, each at the rate that threads had in the
  /// last sixteenth of the job's `total` tiles. `in_flight`: those that are being traced, which
  /// come back in bursts: the rate is taken over at least two of these. Below 0: not known yet.
  double remaining_seconds(TileWork traced, TileWork left, uint64_t total, uint64_t in_flight,
                           size_t threads) const;

 private:
  /// So much had been traced after threads had worked for so long, all together.
  struct Mark {
    double thread_seconds = 0;
    TileWork traced{};
  };
  Mark latest(TileWork traced) const;

  double before_, thread_seconds_ = 0;
  Time worked_{}, counted_until_{};
  std::deque<Mark> marks_{Mark{}};  ///< of ever more tiles
};

}  // namespace tessera
