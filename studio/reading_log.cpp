#include "studio/reading_log.h"

#include <fmt/format.h>

#include <algorithm>

namespace tessera {

void ReadingLog::note(const std::string& file, double seconds, Time now) {
  Reads& reads = reads_[file];
  reads.least = reads.count == 0 ? seconds : std::min(reads.least, seconds);
  reads.most = std::max(reads.most, seconds);
  reads.last = now;
  ++reads.count;
}

std::vector<std::string> ReadingLog::due(Time now) {
  std::vector<std::string> lines;
  std::erase_if(reads_, [&](const auto& entry) {
    const auto& [file, reads] = entry;
    if (now - reads.last < kRest) return false;
    lines.push_back(reads.count == 1
                        ? fmt::format("'{}': read in {:.1f} ms", file, 1000 * reads.most)
                        : fmt::format("'{}': read {} times, each in {:.1f} to {:.1f} ms", file,
                                      reads.count, 1000 * reads.least, 1000 * reads.most));
    return true;
  });
  return lines;
}

Time ReadingLog::deadline() const {
  Time first = Time::max();
  for (const auto& [file, reads] : reads_) first = std::min(first, reads.last + kRest);
  return first;
}

}  // namespace tessera
