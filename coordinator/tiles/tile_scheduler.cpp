#include "coordinator/tiles/tile_scheduler.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "coordinator/tiles/identity.h"

namespace tessera {
namespace {

constexpr size_t kMaxFailures = 3;
// A worker that vanished may have been killed by its tile, but is more often killed by something
// else: tiles get the benefit of the doubt for longer.
constexpr size_t kMaxVanished = 12;
constexpr size_t kMaxLeasesOfTile = 2;
constexpr size_t kDurationsKept = 1024;
// A worker that vanishes takes no more than this of work along that was done and not sent.
constexpr Time kAtOnce = std::chrono::milliseconds(100);
// The upper bits of a lease: a tag of the coordinator that gave it, and which of its leases it is.
constexpr int kTagShift = 52, kCountShift = 32;
/// How often, in a frame, the costs of all its open tiles are added up.
constexpr size_t kForecasts = 128;

std::vector<PixelRect> row_of_pixels(size_t count) {
  std::vector<PixelRect> result;
  for (int x = 0; x < static_cast<int>(count); ++x) result.push_back({x, 0, x + 1, 1});
  return result;
}

}  // namespace

TileScheduler::TileScheduler(std::vector<PixelRect> tiles, int tile_size, const TileRules& rules,
                             const WorkerKeys* keys)
    : rules_(rules),
      keys_(keys),
      rects_(std::move(tiles)),
      tiles_(rects_.size()),
      costs_(rects_, tile_size),
      pending_(rects_.size()),
      open_tiles_(rects_.size()) {
  leases_issued_ = opening_tag() << (kTagShift - kCountShift);
  std::iota(pending_.begin(), pending_.end(), 0u);
}

TileScheduler::TileScheduler(size_t tiles, const TileRules& rules)
    : TileScheduler(row_of_pixels(tiles), 1, rules) {}

void TileScheduler::restore(const std::vector<uint32_t>& tiles) {
  for (const uint32_t tile : tiles) {
    tiles_[tile].state = State::done;
    --open_tiles_;
  }
  std::erase_if(pending_, [this](uint32_t tile) { return tiles_[tile].state == State::done; });
}

void TileScheduler::join(WorkerId worker, uint32_t threads) {
  const auto [holder, fresh] = holders_.try_emplace(worker);
  if (fresh) threads_ += holder->second.threads = std::max(1u, threads);
  const auto it = vanished_with_.find(worker);
  if (it == vanished_with_.end()) return;
  for (const uint32_t tile : it->second) std::erase(tiles_[tile].vanished_by, worker);
  vanished_with_.erase(it);
}

void TileScheduler::set_suspect(WorkerId worker, bool suspect) {
  const auto it = holders_.find(worker);
  if (it == holders_.end() || it->second.suspect == suspect) return;
  it->second.suspect = suspect;
  if (suspect) {
    suspects_.insert(worker);
  } else {
    suspects_.erase(worker);
  }
}

size_t TileScheduler::working_threads() const {
  size_t count = threads_;
  for (const WorkerId suspect : suspects_) count -= holders_.at(suspect).threads;
  return count;
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
    std::vector<WorkerId>& by = tiles_[lease.tile].vanished_by;
    by.push_back(worker);
    judge(lease.tile, by, kMaxVanished, events);
  }
  threads_ -= it->second.threads;
  suspects_.erase(worker);
  holders_.erase(it);
  return events;
}

bool TileScheduler::may_trace(const Tile& tile, WorkerId worker, Time now, bool busy) const {
  const auto index = static_cast<uint32_t>(&tile - tiles_.data());
  if (is_party(index, worker) || is_barred(index, worker)) return false;
  if (tile.state == State::done) {
    const auto check = checks_.find(index);
    const auto is_its_voter = [&](WorkerId by) { return voter_of(by) == voter_of(worker); };
    if (check == checks_.end() ||
        std::any_of(check->second.begin(), check->second.end(), is_its_voter)) {
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
  return now - tile.failed_at >= rules_.lease ||
         std::all_of(holders_.begin(), holders_.end(),
                     [&](const auto& other) { return has_failed(other.first); });
}

void TileScheduler::order_pending() {
  if (!costs_.order_is_due()) return;
  // What was given out before is wanted first.
  const auto fresh =
      std::stable_partition(pending_.begin(), pending_.end(), [this](uint32_t packed) {
        const TilePiece piece = TilePiece::unpack(packed);
        return !piece.whole() || tiles_[piece.tile].attempts > 0;
      });
  std::deque<uint32_t> tiles(fresh, pending_.end());
  costs_.put_in_order(tiles);
  std::copy(tiles.begin(), tiles.end(), fresh);
}

std::optional<uint32_t> TileScheduler::next_pending(WorkerId worker, Time now, bool busy) {
  order_pending();
  for (auto it = pending_.begin(); it != pending_.end(); ++it) {
    const TilePiece piece = TilePiece::unpack(*it);
    const Tile& tile = tiles_[piece.tile];
    if (!may_trace(tile, worker, now, busy)) continue;
    const size_t left = pending_.size();
    pending_.erase(it);
    const size_t busy_threads = live_.size() - waiting_.size();
    const size_t idle = threads_ - std::min(threads_, busy_threads);
    if (!piece.whole() || tile.attempts > 0 || left >= idle) return piece.packed();
    // Not every thread can have one.
    const uint32_t parts = useful_parts(piece.tile, 2 * idle / left);
    return parts > 1 ? split(piece.tile, parts) : piece.packed();
  }
  return std::nullopt;
}

Time TileScheduler::lease_length(const Tile& tile) const {
  return rules_.lease * (int64_t{1} << tile.failed_by.size());
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
  return to_seconds(duration_sum_) / static_cast<double>(durations_.size());
}

TileWork TileScheduler::left() const {
  auto& [due, mean] = mean_left_;
  const uint64_t known = costs_.known().tiles;
  if (open_tiles_ > 0 && known >= due) {
    double sum = 0;
    for (uint32_t tile = 0; tile < tiles_.size(); ++tile) {
      const State state = tiles_[tile].state;
      const bool open = state == State::pending || state == State::leased;
      if (open) sum += costs_.predict(tile).value_or(0);
    }
    mean = sum / static_cast<double>(open_tiles_);
    due = known + 1 + tiles_.size() / kForecasts;
  }
  return {open_tiles_, mean * static_cast<double>(open_tiles_)};
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
  if (it == holders_.end() || it->second.suspect || isolates(worker)) return std::nullopt;
  if (const auto check = next_check(worker, now, busy)) return give(*check, Why::next, worker, now);
  if (const auto copy = next_of_suspect(worker, now, busy)) {
    return give(*copy, Why::copy, worker, now);
  }
  if (const auto next = next_pending(worker, now, busy)) return give(*next, Why::next, worker, now);
  return std::nullopt;
}

bool TileScheduler::has_tile_for(WorkerId worker, Time now, bool busy, bool pieces) const {
  const auto it = holders_.find(worker);
  if (it == holders_.end() || it->second.suspect || isolates(worker)) return false;
  const auto may = [&](uint32_t tile) { return may_trace(tiles_[tile], worker, now, busy); };
  const auto may_have = [&](uint32_t packed) {
    const TilePiece piece = TilePiece::unpack(packed);
    return (pieces || piece.whole()) && may(piece.tile);
  };
  return std::any_of(pending_.begin(), pending_.end(), may_have) ||
         std::any_of(waiting_checks_.begin(), waiting_checks_.end(), may);
}

Lease TileScheduler::give(uint32_t packed, Why why, WorkerId worker, Time now) {
  const TilePiece piece = TilePiece::unpack(packed);
  Tile& tile = tiles_[piece.tile];
  Lease lease;
  lease.id = ++leases_issued_ << kCountShift | packed;
  lease.tile = piece.tile;
  lease.worker = worker;
  lease.issued = now;
  lease.deadline = now + lease_length(tile);
  lease.speculative = why == Why::copy;
  if (lease.speculative) ++speculative_;
  if (tile.state == State::done) {
    lease.check = true;
  } else {
    lease.again = tile.attempts++ > 0 && why == Why::next && piece.whole();
    if (lease.again) ++retries_;
    tile.state = State::leased;
  }
  hold(lease);
  return lease;
}

void TileScheduler::hold(const Lease& lease) {
  Holder& holder = holders_.at(lease.worker);
  tiles_[lease.tile].leases.push_back(lease.id);
  live_.emplace(lease.id, lease);
  issued_.emplace(lease.id, lease.worker);
  holder.leases.push_back(lease.id);
  if (holder.leases.size() > holder.threads && !lease.started) waiting_.insert(lease.id);
}

Lease TileScheduler::drop(LeaseId id) {
  const auto it = live_.find(id);
  const Lease lease = it->second;
  live_.erase(it);
  waiting_.erase(id);
  Holder& holder = holders_.at(lease.worker);
  std::erase(holder.leases, id);
  // The next in its queue begins.
  if (holder.leases.size() >= holder.threads) waiting_.erase(holder.leases[holder.threads - 1]);
  Tile& tile = tiles_[lease.tile];
  std::erase(tile.leases, id);
  const TilePiece piece = lease.piece();
  const bool wanted = tile.state == State::leased && piece.parts == tile.parts &&
                      (tile.parts_done >> piece.part & 1) == 0;
  if (wanted && copies_of(piece.packed()) == 0) {
    if (piece.whole()) tile.state = State::pending;
    pending_.push_front(piece.packed());
  }
  if (tile.leases.empty() && checks_.contains(lease.tile)) waiting_checks_.push_front(lease.tile);
  return lease;
}

size_t TileScheduler::report(WorkerId worker, const std::vector<LeaseProgress>& held, Time now,
                             SchedulerEvents& events, bool leaves) {
  size_t foreign = 0;
  bool grew = false;
  std::map<LeaseId, LeaseProgress> by_id;
  for (const LeaseProgress& progress : held) {
    by_id.emplace(progress.lease, progress);
    const bool goes_on = !progress.ours && holders_.contains(worker) &&
                         !issued_.contains(progress.lease) &&
                         accepts(progress.lease, false, worker);
    if (goes_on) go_on(progress, worker, now);
    const auto it = live_.find(progress.lease);
    if (it != live_.end() && it->second.worker == worker) {
      grew |= progress.work_done > it->second.work_done;
      continue;
    }
    ++foreign;
    const uint32_t tile = tile_of(progress.lease);
    if (tile >= tiles_.size() || tiles_[tile].state == State::done) {
      events.unwanted.push_back(progress.lease);
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
      if (leaves || now - lease.issued >= rules_.settle) drop(id);
      continue;
    }
    const bool renewed = it->second.work_done > lease.work_done ||
                         (it->second.started && !lease.started) || (!lease.started && grew);
    if (renewed) lease.deadline = now + lease_length(tiles_[lease.tile]);
    lease.work_done = std::max(lease.work_done, it->second.work_done);
    lease.started |= it->second.started;
    if (lease.started) waiting_.erase(id);
  }
  return foreign;
}

uint64_t TileScheduler::opening_tag() const { return number_of(rules_.opening) >> kTagShift; }

bool TileScheduler::is_own(LeaseId lease) const { return lease >> kTagShift == opening_tag(); }

bool TileScheduler::accepts(LeaseId lease, bool ours, WorkerId worker) {
  if (ours || issued_.contains(lease)) return issued(lease, worker);
  // Leases of another coordinator whose tag happens to be the same (one in 4,096) could be ones
  // that we shall give: their tiles are traced again.
  if (!rules_.adopts || is_own(lease)) return false;
  // Into which parts that coordinator had split a tile is not known any more.
  if (tile_of(lease) >= tiles_.size() || !TilePiece::of(lease).whole()) return false;
  // No more than there are honest ones.
  Tile& tile = tiles_[tile_of(lease)];
  if (tile.adopted >= kMaxLeasesOfTile) return false;
  ++tile.adopted;
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
  hold(lease);
}

SchedulerEvents TileScheduler::complete(uint32_t index, LeaseId by, Time now) {
  SchedulerEvents events;
  Tile& tile = tiles_[index];
  if (tile.state == State::done) return events;
  forget_pending(index);
  if (tile.state != State::given_up) --open_tiles_;
  tile.state = State::done;
  tile.parts = 1;
  tile.parts_done = 0;
  const std::vector<LeaseId> leases = tile.leases;
  for (const LeaseId id : leases) {
    const Lease lease = drop(id);
    if (id != by) {
      events.cancelled.push_back(lease);
      continue;
    }
    events.took = now - lease.issued;
    if (lease.piece().whole()) {
      if (durations_.size() < kDurationsKept) {
        durations_.push_back(*events.took);
        duration_sum_ += *events.took;
      }
      lately_ = lately_ ? (*lately_ * 7 + *events.took) / 8 : *events.took;
    }
  }
  return events;
}

void TileScheduler::forget_pending(uint32_t index) {
  const Tile& tile = tiles_[index];
  if (tile.state == State::pending) std::erase(pending_, index);
  if (!tile.split()) return;
  std::erase_if(pending_,
                [index](uint32_t packed) { return TilePiece::unpack(packed).tile == index; });
}

SchedulerEvents TileScheduler::fail(LeaseId id, WorkerId worker, Time now) {
  SchedulerEvents events;
  const auto it = live_.find(id);
  if (it == live_.end() || it->second.worker != worker) return events;
  blame(drop(id).tile, worker, now, events);
  return events;
}

bool TileScheduler::issued(LeaseId lease, WorkerId worker) const {
  const auto it = issued_.find(lease);
  return it != issued_.end() && it->second == worker;
}

void TileScheduler::forgive(Time silence, Time now) {
  for (auto& [id, lease] : live_) {
    lease.deadline = std::min(now + lease_length(tiles_[lease.tile]), lease.deadline + silence);
  }
}

SchedulerEvents TileScheduler::expire(Time now) {
  SchedulerEvents events;
  std::vector<LeaseId> ended;
  for (const auto& [id, lease] : live_) {
    if (lease.deadline <= now) ended.push_back(id);
  }
  for (const LeaseId id : ended) {
    const Lease lease = drop(id);
    if (lease.started) {
      blame(lease.tile, lease.worker, now, events);
    } else {
      events.stalled.push_back(lease);
    }
  }
  return events;
}

SchedulerEvents TileScheduler::stall(const Lease& lease, Time now) {
  SchedulerEvents events;
  if (lease.check && checks_.contains(lease.tile)) {
    blame(lease.tile, lease.worker, now, events);
  } else {
    events.blamed.push_back(lease.worker);
  }
  return events;
}

void TileScheduler::blame(uint32_t index, WorkerId worker, Time now, SchedulerEvents& events) {
  merge(index, events);
  Tile& tile = tiles_[index];
  events.blamed.push_back(worker);
  tile.failed_by.push_back(worker);
  tile.failed_at = now;
  judge(index, tile.failed_by, kMaxFailures, events);
}

size_t TileScheduler::count_of_voter(const std::vector<WorkerId>& by, WorkerId worker) const {
  return static_cast<size_t>(std::count_if(
      by.begin(), by.end(), [&](WorkerId id) { return voter_of(id) == voter_of(worker); }));
}

void TileScheduler::judge(uint32_t index, const std::vector<WorkerId>& by, size_t most,
                          SchedulerEvents& events) {
  if (!keys_ || !keys_->by_key()) {
    if (by.size() >= most) give_up(index, events);
    return;
  }
  // What one key says is not enough, however often.
  std::set<WorkerKeys::Voter> voters;
  for (const WorkerId id : by) {
    if (count_of_voter(by, id) >= (most + 1) / 2) voters.insert(voter_of(id));
  }
  if (voters.size() >= 2) return give_up(index, events);
  if (count_of_voter(by, by.back()) >= most) barred_.insert(index);
}

bool TileScheduler::is_barred(uint32_t index, WorkerId worker) const {
  if (!barred_.contains(index)) return false;
  const Tile& tile = tiles_[index];
  return count_of_voter(tile.failed_by, worker) >= kMaxFailures ||
         count_of_voter(tile.vanished_by, worker) >= kMaxVanished;
}

void TileScheduler::give_up(uint32_t index, SchedulerEvents& events) {
  Tile& tile = tiles_[index];
  // Nobody is able to check it: it stays as it is.
  if (tile.state == State::done) {
    if (checks_.contains(index)) ++unverified_;
    return forget_check(index);
  }
  if (tile.state == State::given_up) return;
  merge(index, events);
  if (tile.state == State::pending) std::erase(pending_, index);
  tile.state = State::given_up;
  --open_tiles_;
  events.given_up.push_back(index);
}

}  // namespace tessera
