#include "coordinator/tile_scheduler.h"

#include <algorithm>
#include <numeric>

namespace tessera {
namespace {

constexpr size_t kMaxFailures = 3;
// A worker that vanished may have been killed by its tile, but is more often killed by something
// else: tiles get the benefit of the doubt for longer.
constexpr uint8_t kMaxVanished = 12;
constexpr size_t kMaxLeasesOfTile = 2;
// Second copies may be one in so many of all tiles, or kFreeCopies if that is more.
constexpr uint64_t kTilesPerCopy = 20;
constexpr uint64_t kFreeCopies = 4;
constexpr double kStragglerFactor = 1.5;
constexpr int kOverdueLeases = 3;
constexpr size_t kDurationsKept = 1024;
// A worker that vanishes takes no more than this of work along that was done and not sent.
constexpr Time kAtOnce = std::chrono::milliseconds(100);
// The upper bits of a lease: which coordinator gave it, and which of its leases it is.
constexpr int kEpochShift = 52, kCountShift = 32;
constexpr uint64_t kEpochTags = uint64_t{1} << (64 - kEpochShift);

}  // namespace

TileScheduler::TileScheduler(size_t tiles, const CoordinatorOptions& options)
    : options_(options), tiles_(tiles), pending_(tiles), open_tiles_(tiles) {
  leases_issued_ = epoch_tag() << (kEpochShift - kCountShift);
  std::iota(pending_.begin(), pending_.end(), 0u);
}

void TileScheduler::restore(const std::vector<uint32_t>& tiles) {
  for (const uint32_t tile : tiles) {
    tiles_[tile].state = State::done;
    --open_tiles_;
  }
  std::erase_if(pending_, [this](uint32_t tile) { return tiles_[tile].state == State::done; });
}

void TileScheduler::join(WorkerId worker) {
  holders_.try_emplace(worker);
  const auto it = vanished_with_.find(worker);
  if (it == vanished_with_.end()) return;
  for (const uint32_t tile : it->second) --tiles_[tile].vanished;
  vanished_with_.erase(it);
}

void TileScheduler::set_suspect(WorkerId worker, bool suspect) {
  const auto it = holders_.find(worker);
  if (it != holders_.end()) it->second.suspect = suspect;
}

size_t TileScheduler::held_by(WorkerId worker) const {
  const auto it = holders_.find(worker);
  return it == holders_.end() ? 0 : it->second.leases.size();
}

SchedulerEvents TileScheduler::leave(WorkerId worker, LossCause cause, Time now) {
  SchedulerEvents events;
  const auto it = holders_.find(worker);
  if (it == holders_.end()) return events;
  const std::vector<LeaseId> leases = it->second.leases;
  for (const LeaseId id : leases) {
    const Lease lease = drop(id);
    if (cause == LossCause::crashed) blame(lease.tile, worker, now, events);
    if (cause != LossCause::vanished) continue;
    vanished_with_[worker].push_back(lease.tile);
    if (++tiles_[lease.tile].vanished >= kMaxVanished) give_up(lease.tile, events);
  }
  holders_.erase(worker);
  return events;
}

bool TileScheduler::may_trace(const Tile& tile, WorkerId worker, Time now, bool busy) const {
  if (std::count(tile.disputed_by.begin(), tile.disputed_by.end(), worker) > 0) return false;
  if (tile.state == State::done) {
    const auto check = checks_.find(static_cast<uint32_t>(&tile - tiles_.data()));
    if (check == checks_.end() ||
        std::count(check->second.begin(), check->second.end(), worker) > 0) {
      return false;
    }
  }
  if (tile.failed_by.empty()) return true;
  if (busy || !holders_.at(worker).leases.empty()) return false;
  const auto has_failed = [&](WorkerId id) {
    return std::find(tile.failed_by.begin(), tile.failed_by.end(), id) != tile.failed_by.end();
  };
  if (!has_failed(worker)) return true;
  // The others may all be stuck, so after a while it is its turn again.
  return now - tile.failed_at >= options_.lease ||
         std::all_of(holders_.begin(), holders_.end(),
                     [&](const auto& other) { return has_failed(other.first); });
}

std::optional<uint32_t> TileScheduler::next_pending(WorkerId worker, Time now, bool busy) {
  for (auto it = pending_.begin(); it != pending_.end(); ++it) {
    const uint32_t tile = *it;
    if (!may_trace(tiles_[tile], worker, now, busy)) continue;
    pending_.erase(it);
    return tile;
  }
  return std::nullopt;
}

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

Time TileScheduler::straggler_age() const {
  if (durations_.empty()) return options_.lease;
  std::vector<Time> sorted = durations_;
  const auto p90 = sorted.begin() + static_cast<ptrdiff_t>(sorted.size() * 9 / 10);
  std::nth_element(sorted.begin(), p90, sorted.end());
  const Time limit{static_cast<int64_t>(static_cast<double>(p90->count()) * kStragglerFactor)};
  return std::max(options_.speculate_after, limit);
}

std::optional<uint32_t> TileScheduler::next_straggler(WorkerId worker, Time now, bool busy) const {
  if (live_.empty()) return std::nullopt;
  const bool within_budget =
      speculative_ < std::max<uint64_t>(kFreeCopies, tiles_.size() / kTilesPerCopy);
  // Whoever reports progress for ever and sends nothing holds no tile back for good.
  const Time overdue = kOverdueLeases * options_.lease;
  const Time age = within_budget ? std::min(straggler_age(), overdue) : overdue;
  const Lease* slowest = nullptr;
  for (const auto& [id, lease] : live_) {
    const Tile& tile = tiles_[lease.tile];
    if (lease.worker == worker || tile.leases.size() >= kMaxLeasesOfTile) continue;
    if (!may_trace(tile, worker, now, busy)) continue;
    if (!holders_.at(lease.worker).suspect && now - lease.issued < age) continue;
    if (!slowest || lease.issued < slowest->issued) slowest = &lease;
  }
  return slowest ? std::optional(slowest->tile) : std::nullopt;
}

Time TileScheduler::lease_length(const Tile& tile) const {
  return options_.lease * (int64_t{1} << tile.failed_by.size());
}

bool TileScheduler::isolates(WorkerId worker) const {
  const auto it = holders_.find(worker);
  return it != holders_.end() && it->second.leases.size() == 1 &&
         !tiles_[tile_of(it->second.leases[0])].failed_by.empty();
}

TileScheduler::TileView TileScheduler::view(uint32_t index) const {
  const Tile& tile = tiles_[index];
  TileView view;
  view.done = tile.state == State::done;
  view.given_up = tile.state == State::given_up;
  view.copies = static_cast<uint8_t>(tile.leases.size());
  if (!tile.leases.empty()) {
    const Lease& lease = live_.at(tile.leases.front());
    view.worker = lease.worker;
    view.issued = lease.issued;
  }
  return view;
}

std::optional<double> TileScheduler::mean_seconds() const {
  if (durations_.empty()) return std::nullopt;
  const Time sum = std::accumulate(durations_.begin(), durations_.end(), Time{0});
  return to_seconds(sum) / static_cast<double>(durations_.size());
}

size_t TileScheduler::depth(uint32_t threads) const {
  const size_t tracing = std::max<size_t>(threads, 1);
  const size_t least = tracing + (tracing + 1) / 2;
  if (!lately_ || *lately_ > kAtOnce || holders_.empty()) return least;
  // Less and less towards the end, when whoever is quick shall find something to do.
  return std::max(least, pending_.size() / (2 * holders_.size()));
}

std::optional<Lease> TileScheduler::assign(WorkerId worker, Time now, bool busy) {
  const auto it = holders_.find(worker);
  if (it == holders_.end() || it->second.suspect) return std::nullopt;
  Holder& holder = it->second;
  if (isolates(worker)) return std::nullopt;
  Lease lease;
  if (const auto check = next_check(worker, now, busy)) {
    lease.tile = *check;
    lease.check = true;
  } else if (const auto next = next_pending(worker, now, busy)) {
    lease.tile = *next;
  } else if (const auto straggler = next_straggler(worker, now, busy)) {
    lease.tile = *straggler;
    lease.speculative = true;
    ++speculative_;
  } else {
    return std::nullopt;
  }
  Tile& tile = tiles_[lease.tile];
  lease.id = ++leases_issued_ << kCountShift | lease.tile;
  lease.worker = worker;
  lease.issued = now;
  lease.deadline = now + lease_length(tile);
  if (tile.state == State::done) {
    lease.check = true;
  } else {
    lease.again = tile.attempts++ > 0 && !lease.speculative;
    if (lease.again) ++retries_;
    tile.state = State::leased;
  }
  tile.leases.push_back(lease.id);
  live_.emplace(lease.id, lease);
  issued_.emplace(lease.id, worker);
  holder.leases.push_back(lease.id);
  return lease;
}

Lease TileScheduler::drop(LeaseId id) {
  const auto it = live_.find(id);
  const Lease lease = it->second;
  live_.erase(it);
  std::erase(holders_.at(lease.worker).leases, id);
  Tile& tile = tiles_[lease.tile];
  std::erase(tile.leases, id);
  if (tile.leases.empty() && tile.state == State::leased) {
    tile.state = State::pending;
    pending_.push_front(lease.tile);
  }
  if (tile.leases.empty() && checks_.contains(lease.tile)) waiting_checks_.push_front(lease.tile);
  return lease;
}

size_t TileScheduler::report(WorkerId worker, const std::vector<LeaseProgress>& held, Time now,
                             SchedulerEvents& events) {
  size_t foreign = 0;
  bool grew = false;
  std::map<LeaseId, LeaseProgress> by_id;
  for (const LeaseProgress& progress : held) {
    by_id.emplace(progress.lease, progress);
    const bool ours = !holders_.contains(worker) || !adopt(progress.lease, worker);
    if (!ours) go_on(progress, worker, now);
    const auto it = live_.find(progress.lease);
    if (it != live_.end() && it->second.worker == worker) {
      grew |= progress.work_done > it->second.work_done;
      continue;
    }
    ++foreign;
    const uint32_t tile = tile_of(progress.lease);
    if (tile >= tiles_.size() || tiles_[tile].state == State::done) {
      events.cancelled.push_back({.id = progress.lease, .tile = tile, .worker = worker});
    }
  }
  const auto holder = holders_.find(worker);
  if (holder == holders_.end()) return foreign;
  const std::vector<LeaseId> leases = holder->second.leases;
  for (const LeaseId id : leases) {
    Lease& lease = live_.at(id);
    const auto it = by_id.find(id);
    if (it == by_id.end()) {
      // The assignment or its result was lost on the way.
      if (now - lease.issued >= options_.settle) drop(id);
      continue;
    }
    const bool renewed = it->second.work_done > lease.work_done ||
                         (it->second.started && !lease.started) || (!lease.started && grew);
    if (renewed) lease.deadline = now + lease_length(tiles_[lease.tile]);
    lease.work_done = std::max(lease.work_done, it->second.work_done);
    lease.started |= it->second.started;
  }
  return foreign;
}

uint64_t TileScheduler::epoch_tag() const { return options_.epoch % kEpochTags; }

bool TileScheduler::adopt(LeaseId lease, WorkerId worker) {
  const bool of_another = options_.farm != 0 && lease >> kEpochShift != epoch_tag();
  if (!of_another || tile_of(lease) >= tiles_.size() || issued_.contains(lease)) return false;
  // No more than there are honest ones.
  if (adopted_ >= tiles_.size() * kMaxLeasesOfTile) return false;
  ++adopted_;
  issued_.emplace(lease, worker);
  return true;
}

void TileScheduler::go_on(const LeaseProgress& progress, WorkerId worker, Time now) {
  const uint32_t index = tile_of(progress.lease);
  Tile& tile = tiles_[index];
  if (tile.state != State::pending || !may_trace(tile, worker, now, false)) return;
  std::erase(pending_, index);
  Lease lease{.id = progress.lease, .tile = index, .worker = worker, .issued = now};
  lease.deadline = now + lease_length(tile);
  lease.work_done = progress.work_done;
  lease.started = progress.started;
  ++tile.attempts;
  tile.state = State::leased;
  tile.leases.push_back(lease.id);
  live_.emplace(lease.id, lease);
  holders_.at(worker).leases.push_back(lease.id);
}

SchedulerEvents TileScheduler::complete(uint32_t index, LeaseId by, Time now) {
  SchedulerEvents events;
  Tile& tile = tiles_[index];
  if (tile.state == State::done) return events;
  if (tile.state == State::pending) std::erase(pending_, index);
  if (tile.state != State::given_up) --open_tiles_;
  tile.state = State::done;
  const std::vector<LeaseId> leases = tile.leases;
  for (const LeaseId id : leases) {
    const Lease lease = drop(id);
    if (id != by) {
      events.cancelled.push_back(lease);
      continue;
    }
    events.took = now - lease.issued;
    if (durations_.size() < kDurationsKept) durations_.push_back(*events.took);
    lately_ = lately_ ? (*lately_ * 7 + *events.took) / 8 : *events.took;
  }
  return events;
}

SchedulerEvents TileScheduler::fail(LeaseId id, WorkerId worker, Time now) {
  SchedulerEvents events;
  const auto it = live_.find(id);
  if (it == live_.end() || it->second.worker != worker) return events;
  blame(drop(id).tile, worker, now, events);
  return events;
}

SchedulerEvents TileScheduler::dispute(uint32_t index, WorkerId one, WorkerId other, Time now) {
  SchedulerEvents events;
  Tile& tile = tiles_[index];
  if (tile.disputed_by.empty()) disputed_.push_back(index);
  tile.disputed_by.insert(tile.disputed_by.end(), {one, other});
  tile.disputed_at = now;
  forget_check(index);
  const std::vector<LeaseId> leases = tile.leases;
  for (const LeaseId id : leases) events.cancelled.push_back(drop(id));
  if (tile.state == State::done) {
    tile.state = State::pending;
    pending_.push_front(index);
    ++open_tiles_;
  }
  return events;
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
  if (tile.state != State::done) return events;
  events = check_done(index, 0);
  tile.state = State::pending;
  pending_.push_front(index);
  ++open_tiles_;
  return events;
}

size_t TileScheduler::abandon_checks(Time now) {
  // Whoever is there has traced them, or is stuck.
  if (open_tiles_ > 0 || waiting_checks_.empty() || !live_.empty()) {
    uncheckable_since_.reset();
    return 0;
  }
  if (!uncheckable_since_) uncheckable_since_ = now;
  if (now - *uncheckable_since_ < options_.lease) return 0;
  const size_t count = waiting_checks_.size();
  unverified_ += count;
  for (const uint32_t tile : waiting_checks_) checks_.erase(tile);
  waiting_checks_.clear();
  return count;
}

std::optional<uint32_t> TileScheduler::undecided(Time now) const {
  const auto it = std::find_if(disputed_.begin(), disputed_.end(), [&](uint32_t index) {
    const Tile& tile = tiles_[index];
    if (tile.state != State::pending || now - tile.disputed_at < options_.lease) return false;
    // Who could decide may be busy.
    return std::none_of(holders_.begin(), holders_.end(), [&](const auto& holder) {
      return std::count(tile.disputed_by.begin(), tile.disputed_by.end(), holder.first) == 0;
    });
  });
  return it == disputed_.end() ? std::nullopt : std::optional(*it);
}

bool TileScheduler::issued(LeaseId lease, WorkerId worker) const {
  const auto it = issued_.find(lease);
  return it != issued_.end() && it->second == worker;
}

SchedulerEvents TileScheduler::expire(Time now) {
  SchedulerEvents events;
  std::vector<LeaseId> ended;
  for (const auto& [id, lease] : live_) {
    if (lease.deadline <= now) ended.push_back(id);
  }
  for (const LeaseId id : ended) {
    const Lease lease = drop(id);
    if (lease.started) blame(lease.tile, lease.worker, now, events);
  }
  return events;
}

void TileScheduler::blame(uint32_t index, WorkerId worker, Time now, SchedulerEvents& events) {
  Tile& tile = tiles_[index];
  events.blamed.push_back(worker);
  tile.failed_by.push_back(worker);
  tile.failed_at = now;
  if (tile.failed_by.size() >= kMaxFailures) give_up(index, events);
}

void TileScheduler::give_up(uint32_t index, SchedulerEvents& events) {
  Tile& tile = tiles_[index];
  // Nobody is able to check it: it stays as it is.
  if (tile.state == State::done) {
    if (checks_.contains(index)) ++unverified_;
    return forget_check(index);
  }
  if (tile.state == State::given_up) return;
  if (tile.state == State::pending) std::erase(pending_, index);
  tile.state = State::given_up;
  --open_tiles_;
  events.given_up.push_back(index);
}

}  // namespace tessera
