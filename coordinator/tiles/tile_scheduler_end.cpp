// What workers do at the end of the queue, so that the last tile ends soon: a part of
// TileScheduler.
#include <algorithm>

#include "coordinator/tiles/tile_scheduler.h"

namespace tessera {
namespace {

constexpr size_t kMaxLeasesOfPiece = 2;
// Second copies may be one in so many of all tiles, or kFreeCopies if that is more.
constexpr uint64_t kTilesPerCopy = 20;
constexpr uint64_t kFreeCopies = 4;
constexpr double kStragglerFactor = 1.5;
constexpr int kOverdueLeases = 3;
/// So many of what waits in queues are looked at for one worker.
constexpr int kMostLookedAt = 64;

}  // namespace

size_t TileScheduler::copies_of(uint32_t piece) const {
  const std::vector<LeaseId>& leases = tiles_[TilePiece::unpack(piece).tile].leases;
  return static_cast<size_t>(std::count_if(leases.begin(), leases.end(), [&](LeaseId id) {
    return static_cast<uint32_t>(id) == piece;
  }));
}

std::optional<Lease> TileScheduler::assign_at_end(WorkerId worker, Time now, bool busy, bool idle,
                                                  SchedulerEvents& events) {
  const auto it = holders_.find(worker);
  if (it == holders_.end() || it->second.suspect || isolates(worker)) return std::nullopt;
  if (const auto taken = idle ? take_waiting(worker, now, busy, events) : std::nullopt) {
    return give(*taken, Why::moved, worker, now);
  }
  if (const auto straggler = next_straggler(worker, now, busy)) {
    ++late_copies_;
    return give(*straggler, Why::copy, worker, now);
  }
  return std::nullopt;
}

Time TileScheduler::straggler_age() const {
  if (durations_.empty()) return rules_.lease;
  auto& [among, age] = straggler_age_;
  if (among == durations_.size()) return age;
  std::vector<Time> sorted = durations_;
  const auto p90 = sorted.begin() + static_cast<ptrdiff_t>(sorted.size() * 9 / 10);
  std::nth_element(sorted.begin(), p90, sorted.end());
  const Time limit{static_cast<int64_t>(static_cast<double>(p90->count()) * kStragglerFactor)};
  among = durations_.size();
  return age = std::max(rules_.speculate_after, limit);
}

std::optional<uint32_t> TileScheduler::next_of_suspect(WorkerId worker, Time now, bool busy) const {
  for (const WorkerId suspect : suspects_) {
    if (suspect == worker) continue;
    for (const LeaseId id : holders_.at(suspect).leases) {
      const auto piece = static_cast<uint32_t>(id);
      const Tile& tile = tiles_[tile_of(id)];
      if (tile.state != State::leased || copies_of(piece) >= kMaxLeasesOfPiece) continue;
      if (may_trace(tile, worker, now, busy)) return piece;
    }
  }
  return std::nullopt;
}

std::optional<uint32_t> TileScheduler::next_straggler(WorkerId worker, Time now, bool busy) const {
  if (live_.empty()) return std::nullopt;
  const bool within_budget =
      late_copies_ < std::max<uint64_t>(kFreeCopies, tiles_.size() / kTilesPerCopy);
  // Whoever reports progress for ever and sends nothing holds no tile back for good.
  const Time overdue = kOverdueLeases * rules_.lease;
  const Time age = within_budget ? std::min(straggler_age(), overdue) : overdue;
  // In the order in which they were given; but one of before a restart, which counts from when it
  // was heard of again, may hide others for as long.
  for (const auto& [id, lease] : live_) {
    if (now - lease.issued < age) break;
    const auto piece = static_cast<uint32_t>(id);
    if (lease.worker == worker || copies_of(piece) >= kMaxLeasesOfPiece) continue;
    if (may_trace(tiles_[lease.tile], worker, now, busy)) return piece;
  }
  return std::nullopt;
}

uint32_t TileScheduler::useful_parts(uint32_t index, size_t most) const {
  const auto cost = costs_.predict(index);
  if (tiles_[index].kept_whole || !cost) return 1;
  const double parts = std::min(
      {*cost / to_seconds(rules_.smallest_part), static_cast<double>(most),
       static_cast<double>(rects_[index].height()), static_cast<double>(TilePiece::kMaxParts)});
  return static_cast<uint32_t>(std::max(1.0, parts));
}

uint32_t TileScheduler::split(uint32_t index, uint32_t parts) {
  Tile& tile = tiles_[index];
  tile.state = State::leased;
  tile.parts = parts;
  tile.parts_done = 0;
  ++split_tiles_;
  for (uint32_t part = parts - 1; part > 0; --part) {
    pending_.push_front(TilePiece{index, part, parts}.packed());
  }
  return TilePiece{index, 0, parts}.packed();
}

void TileScheduler::merge(uint32_t index, SchedulerEvents& events) {
  Tile& tile = tiles_[index];
  if (!tile.split()) return;
  forget_pending(index);
  tile.parts = 1;
  tile.parts_done = 0;
  const std::vector<LeaseId> leases = tile.leases;
  for (const LeaseId id : leases) events.cancelled.push_back(drop(id));
  if (tile.state != State::leased) return;
  tile.state = State::pending;
  pending_.push_front(index);
}

std::optional<uint32_t> TileScheduler::take_waiting(WorkerId worker, Time now, bool busy,
                                                    SchedulerEvents& events) {
  int looked_at = 0;
  for (const LeaseId id : waiting_) {
    if (++looked_at > kMostLookedAt) break;
    const Lease& lease = live_.at(id);
    const TilePiece piece = lease.piece();
    const Tile& tile = tiles_[piece.tile];
    const bool alone = tile.state == State::leased && copies_of(piece.packed()) == 1;
    if (lease.worker == worker || !alone || !tile.failed_by.empty()) continue;
    if (!may_trace(tile, worker, now, busy)) continue;
    const auto cost = costs_.predict(piece.tile);
    // What is begun in no time is not worth the messages.
    const bool worth_it = cost ? *cost / piece.parts >= to_seconds(rules_.smallest_part) / 2
                               : now - lease.issued >= rules_.speculate_after;
    if (!worth_it) continue;
    events.recalled = drop(id);
    pending_.pop_front();
    ++moved_;
    const uint32_t parts = piece.whole() ? useful_parts(piece.tile, threads_) : 1;
    return parts > 1 ? split(piece.tile, parts) : piece.packed();
  }
  return std::nullopt;
}

SchedulerEvents TileScheduler::complete_part(LeaseId by) {
  SchedulerEvents events;
  const TilePiece piece = TilePiece::of(by);
  if (!live_.contains(by) || !tiles_[piece.tile].split()) return events;
  Tile& tile = tiles_[piece.tile];
  tile.parts_done |= uint64_t{1} << piece.part;
  const std::vector<LeaseId> leases = tile.leases;
  for (const LeaseId id : leases) {
    if (TilePiece::of(id) != piece) continue;
    const Lease lease = drop(id);
    if (id != by) events.cancelled.push_back(lease);
  }
  return events;
}

}  // namespace tessera
