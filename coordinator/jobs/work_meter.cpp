#include "coordinator/jobs/work_meter.h"

#include <algorithm>
#include <utility>

#include "job/job.h"

namespace tessera {
namespace {

constexpr size_t kMostMarks = 256;
/// The rate is that of so small a share of all tiles, so that a tenth at a steady rate, with a step
/// between marks, covers it.
constexpr uint64_t kWindows = 16;

}  // namespace

void WorkMeter::account(Time now, bool works, uint64_t traced) {
  // Tiles that do not count any more take the time that they took along.
  while (marks_.size() > 1 && marks_.back().traced > traced) marks_.pop_back();
  if (traced > marks_.back().traced) marks_.push_back({worked_, traced});
  if (marks_.size() > kMostMarks) {
    size_t index = 0;
    std::erase_if(marks_, [&index](const Mark&) { return index++ % 2 == 1; });
  }
  if (now <= counted_until_) return;
  const Time since = now - std::exchange(counted_until_, now);
  if (works) worked_ += since;
}

double WorkMeter::seconds(Time now, bool works) const {
  const Time since = works ? std::max(now - counted_until_, Time{0}) : Time{0};
  return before_ + to_seconds(worked_ + since);
}

WorkMeter::Mark WorkMeter::latest(uint64_t traced) const {
  return traced > marks_.back().traced ? Mark{worked_, traced} : marks_.back();
}

double WorkMeter::remaining_seconds(uint64_t traced, uint64_t left, uint64_t total,
                                    uint64_t in_flight) const {
  const Mark end = latest(traced);
  const uint64_t window = std::max({uint64_t{1}, total / kWindows, 2 * in_flight});
  auto start = marks_.end();
  do {
    --start;
  } while (start != marks_.begin() &&
           (start->traced + window > end.traced || start->worked == end.worked));
  if (end.traced <= start->traced || end.worked == start->worked) return -1;
  const double mean =
      to_seconds(end.worked - start->worked) / static_cast<double>(end.traced - start->traced);
  return tessera::remaining_seconds(mean * static_cast<double>(end.traced), end.traced, left);
}

}  // namespace tessera
