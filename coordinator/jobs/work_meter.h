#pragma once

#include <cstdint>
#include <deque>

#include "base/monotonic.h"

namespace tessera {

/// How long a job was worked on and, from the tiles that were traced in that time, how long the
/// rest will take. Time in which nobody works at the job does not count. A plain value without a
/// clock.
class WorkMeter {
 public:
  /// `before`: the seconds for which it was worked on before this process.
  explicit WorkMeter(double before = 0) : before_(before) {}

  /// Counts the time since the last call, in which the job was worked on if it `works`. `traced`:
  /// the tiles that have been traced in this process, all of them by the last call's time.
  void account(Time now, bool works, uint64_t traced);
  /// The seconds for which it was worked on, those of earlier processes included.
  double seconds(Time now, bool works) const;
  /// The seconds that `left` tiles will take at the rate of the last sixteenth of the job's `total`
  /// tiles. `in_flight`: those that are being traced, which come back in bursts: the rate is taken
  /// over at least two of these. Below 0: not known yet.
  double remaining_seconds(uint64_t traced, uint64_t left, uint64_t total,
                           uint64_t in_flight) const;

 private:
  /// So many tiles had been traced after the job was worked on for so long.
  struct Mark {
    Time worked{};
    uint64_t traced = 0;
  };
  Mark latest(uint64_t traced) const;

  double before_;
  Time worked_{}, counted_until_{};
  std::deque<Mark> marks_{Mark{}};  ///< of ever more tiles, in steps of about a hundredth
};

}  // namespace tessera
