// Tiles about which workers differ, and those that a second one traces too: a part of
// TileScheduler.
#include <algorithm>
#include <utility>

#include "coordinator/tiles/tile_scheduler.h"

namespace tessera {

std::optional<uint32_t> TileScheduler::next_check(WorkerId worker, Time now, bool busy) {
  // Where there is other work, those that others are to do are not all looked at each time.
  constexpr size_t kFew = 64;
  const size_t most = pending_.empty() ? waiting_checks_.size() : kFew;
  for (size_t i = 0; i < std::min(most, waiting_checks_.size()); ++i) {
    const uint32_t tile = waiting_checks_[i];
    if (!may_trace(tiles_[tile], worker, now, busy)) continue;
    waiting_checks_.erase(waiting_checks_.begin() + static_cast<ptrdiff_t>(i));
    return tile;
  }
  return std::nullopt;
}

SchedulerEvents TileScheduler::dispute(uint32_t index, WorkerId one, WorkerId other, Time now) {
  SchedulerEvents events;
  Tile& tile = tiles_[index];
  if (tile.disputed_by.empty()) disputed_.push_back(index);
  tile.disputed_by.insert(tile.disputed_by.end(), {one, other});
  tile.disputed_at = now;
  forget_check(index);
  merge(index, events);
  const std::vector<LeaseId> leases = tile.leases;
  for (const LeaseId id : leases) events.cancelled.push_back(drop(id));
  if (tile.state == State::done) {
    tile.state = State::pending;
    pending_.push_front(index);
    ++open_tiles_;
  }
  return events;
}

bool TileScheduler::is_party(uint32_t index, WorkerId worker) const {
  const std::vector<WorkerId>& by = tiles_[index].disputed_by;
  return std::any_of(by.begin(), by.end(),
                     [&](WorkerId id) { return voter_of(id) == voter_of(worker); });
}

std::vector<Lease> TileScheduler::leases_of(WorkerId worker) const {
  std::vector<Lease> leases;
  const auto holder = holders_.find(worker);
  if (holder == holders_.end()) return leases;
  for (const LeaseId id : holder->second.leases) leases.push_back(live_.at(id));
  return leases;
}

void TileScheduler::forget_dispute(uint32_t index) {
  tiles_[index].disputed_by.clear();
  std::erase(disputed_, index);
}

void TileScheduler::want_check(uint32_t index, std::vector<WorkerId> traced_by) {
  if (tiles_[index].state != State::done || checks_.contains(index)) return;
  checks_.emplace(index, std::move(traced_by));
  waiting_checks_.push_back(index);
}

void TileScheduler::forget_check(uint32_t index) {
  if (checks_.erase(index) > 0) std::erase(waiting_checks_, index);
}

SchedulerEvents TileScheduler::check_done(uint32_t index, LeaseId by) {
  SchedulerEvents events;
  if (!checks_.contains(index)) return events;
  forget_check(index);
  if (by != 0) ++verified_;
  const std::vector<LeaseId> leases = tiles_[index].leases;
  for (const LeaseId id : leases) {
    const Lease lease = drop(id);
    if (id != by) events.cancelled.push_back(lease);
  }
  return events;
}

SchedulerEvents TileScheduler::requeue(uint32_t index) {
  SchedulerEvents events;
  Tile& tile = tiles_[index];
  // Rows of parts that are done are wanted again.
  merge(index, events);
  if (tile.state != State::done) return events;
  events = check_done(index, 0);
  tile.state = State::pending;
  pending_.push_front(index);
  ++open_tiles_;
  return events;
}

size_t TileScheduler::abandon_checks(
    Time now, const std::function<bool(uint32_t, const std::vector<WorkerId>&)>& is_awaited) {
  // Whoever is there has traced them, or is stuck.
  if (open_tiles_ > 0 || waiting_checks_.empty() || !live_.empty()) {
    uncheckable_since_.reset();
    return 0;
  }
  if (!uncheckable_since_) uncheckable_since_ = now;
  if (now - *uncheckable_since_ < rules_.settle) return 0;
  const size_t count = std::erase_if(waiting_checks_, [&](uint32_t tile) {
    if (is_awaited(tile, checks_.at(tile))) return false;
    checks_.erase(tile);
    return true;
  });
  unverified_ += count;
  return count;
}

std::optional<uint32_t> TileScheduler::undecided(
    Time now, const std::function<bool(WorkerId)>& gets_on) const {
  const auto it = std::find_if(disputed_.begin(), disputed_.end(), [&](uint32_t index) {
    const Tile& tile = tiles_[index];
    if (tile.state != State::pending || now - tile.disputed_at < rules_.lease) return false;
    // Who could decide may be busy. Who is idle would have taken it, and who hangs never will.
    return std::all_of(holders_.begin(), holders_.end(), [&](const auto& holder) {
      return is_party(index, holder.first) || !gets_on(holder.first);
    });
  });
  return it == disputed_.end() ? std::nullopt : std::optional(*it);
}

}  // namespace tessera
