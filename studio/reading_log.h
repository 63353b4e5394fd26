#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "base/monotonic.h"

namespace tessera {

/// What the log tells of how long scenes took to be read. A scene that is read again and again, as
/// while someone types, gets one line once it rests. Not thread-safe.
class ReadingLog {
 public:
  /// For so long nothing more is read of a scene that rests.
  static constexpr Time kRest = std::chrono::seconds(1);

  void note(const std::string& file, double seconds, Time now);
  /// The lines that are due, which are not told again.
  std::vector<std::string> due(Time now);
  /// When the next line is due; Time::max(): none will be.
  Time deadline() const;

 private:
  struct Reads {
    size_t count = 0;
    double least = 0, most = 0;  ///< seconds
    Time last{};
  };
  std::map<std::string, Reads> reads_;  ///< by file; not told yet
};

}  // namespace tessera
