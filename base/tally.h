#pragma once

#include <cstdint>
#include <optional>

#include "base/monotonic.h"

namespace tessera {

/// For what others may make happen ever so often: it is to be told at once, and then once a period,
/// with how often it was.
class Tally {
 public:
  explicit Tally(Time period = std::chrono::seconds(10)) : period_(period) {}

  /// Counts one more. How many there were since it was last told, where it is to be told now.
  std::optional<uint64_t> note(Time now) {
    ++count_;
    if (told_ && now - *told_ < period_) return std::nullopt;
    told_ = now;
    const uint64_t count = count_;
    count_ = 0;
    return count;
  }

 private:
  Time period_;
  std::optional<Time> told_;
  uint64_t count_ = 0;
};

}  // namespace tessera
