#include "coordinator/jobs/work_meter.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

/// The rate is that of a sixteenth of all tiles. Marks are a thousandth apart and go back a
/// quarter.
constexpr uint64_t kWindows = 16, kSteps = 1024, kReach = 4;
/// Tiles that tell what one takes in the mean: so many, or a quarter of those traced and left.
constexpr uint64_t kEnough = 32;

}  // namespace

void WorkMeter::account(Time now, size_t threads, TileWork traced, uint64_t total) {
  // Where tiles were taken back, the time spent on them belongs to the tiles before.
  while (marks_.size() > 1 && marks_.back().traced.tiles > traced.tiles) marks_.pop_back();
  const uint64_t step = std::max<uint64_t>(1, total / kSteps);
  if (traced.tiles >= marks_.back().traced.tiles + step)
    marks_.push_back({thread_seconds_, traced});
  while (marks_.size() > 2 && marks_[1].traced.tiles + total / kReach < traced.tiles) {
    marks_.pop_front();
  }
  if (now <= counted_until_) return;
  const Time since = now - std::exchange(counted_until_, now);
  if (threads == 0) return;
  worked_ += since;
  thread_seconds_ += to_seconds(since) * static_cast<double>(threads);
}

double WorkMeter::seconds(Time now, bool works) const {
  const Time since = works ? std::max(now - counted_until_, Time{0}) : Time{0};
  return before_ + to_seconds(worked_ + since);
}

WorkMeter::Mark WorkMeter::latest(TileWork traced) const {
  return traced.tiles > marks_.back().traced.tiles ? Mark{thread_seconds_, traced} : marks_.back();
}

double WorkMeter::remaining_seconds(TileWork traced, TileWork left, uint64_t total,
                                    uint64_t in_flight, size_t threads) const {
  if (threads == 0) return -1;
  const Mark end = latest(traced);
  if (end.traced.tiles < kEnough && 3 * end.traced.tiles < left.tiles) return -1;
  const uint64_t window = std::max({uint64_t{1}, total / kWindows, 2 * in_flight});
  auto start = marks_.end();
  do {
    --start;
  } while (start != marks_.begin() && (start->traced.tiles + window > end.traced.tiles ||
                                       start->thread_seconds == end.thread_seconds));
  if (end.traced.tiles <= start->traced.tiles || end.thread_seconds == start->thread_seconds)
    return -1;
  const double worked = (end.thread_seconds - start->thread_seconds) / static_cast<double>(threads);
  const double seconds = end.traced.seconds - start->traced.seconds;
  // Where nobody knows what tiles take, all take the same.
  if (!(seconds > 0) || !(left.seconds > 0)) {
    const uint64_t tiles = end.traced.tiles - start->traced.tiles;
    return worked * static_cast<double>(left.tiles) / static_cast<double>(tiles);
  }
  return worked * left.seconds / seconds;
}

}  // namespace tessera
