#pragma once

#include <spdlog/sinks/base_sink.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace tessera {

/// The last lines of the log, for the page.
class LogRing {
 public:
  struct Line {
    uint64_t number = 0;       ///< from 1, one more each
    int64_t milliseconds = 0;  ///< since 1970
    std::string level, text;
  };
  /// Adds itself to the default logger, before threads start.
  static std::shared_ptr<LogRing> attach();

  /// Those with a number above `after`, from any thread.
  std::vector<Line> after(uint64_t after) const;

 private:
  class Sink;
  void add(Line line);

  mutable std::mutex mutex_;
  std::deque<Line> lines_;
  uint64_t count_ = 0;
};

}  // namespace tessera
