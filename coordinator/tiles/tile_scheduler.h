#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/tiles/tile_costs.h"
#include "coordinator/tiles/tile_piece.h"
#include "coordinator/tiles/tile_rules.h"
#include "coordinator/tiles/worker_keys.h"

namespace tessera {

/// The right, for a time, to trace one tile, or a part of it.
struct Lease {
  LeaseId id = 0;
  uint32_t tile = 0;
  WorkerId worker = 0;
  Time issued{}, deadline{};
  uint64_t work_done = 0;  ///< as in Heartbeat.Progress: grows with the work; of no fixed unit
  bool started = false;    ///< as the worker said last
  bool speculative = false;
  bool check = false;  ///< of a tile whose pixels are there
  bool again = false;  ///< replaces one that came to nothing

  TilePiece piece() const { return TilePiece::of(id); }
};

/// One lease as its worker reports it.
struct LeaseProgress {
  LeaseId lease = 0;
  uint64_t work_done = 0;
  bool started = false;
  bool ours = true;  ///< given by this coordinator, not by one before it on the same store
};

/// How a worker ceased to be there.
enum class LossCause {
  left,      ///< it said so, or came anew
  vanished,  ///< nobody knows why
  crashed,   ///< its process failed by its own doing
};

/// What else follows from a call.
struct SchedulerEvents {
  std::vector<Lease> cancelled;  ///< dropped, and wanted no longer: tell their workers
  std::vector<LeaseId>
      unwanted{};  ///< that the worker which reports has, and that are none of ours
  std::optional<Lease> recalled{};  ///< given to another, unless its worker has begun with it
  std::vector<uint32_t> given_up;   ///< tiles that failed too often
  std::vector<WorkerId> blamed;     ///< workers that failed a tile, once for each
  std::vector<Lease> stalled;       ///< ended before their worker had begun with them
  std::optional<Time> took{};       ///< what completed, from its assignment on
};

/// Which tile of a job goes to whom. A tile is pending, leased (by one worker or two), done or
/// given up. Its lease is renewed by progress alone; a tile whose lease ends goes back to the front
/// of the queue. A tile that failed is tried by other workers as long as there are any, and only by
/// workers that hold nothing else, so that the next failure blames the right one.
///
/// Costly tiles come first (TileCosts). At the end of the queue, what waits in one worker's queue
/// is given to another that has nothing to do, and large tiles are split into strips for several:
/// each is leased by itself, and the tile is done when all its rows are there, whoever traced them.
/// A tile that fails is whole again. Plain values; no clock. Arguments named `busy` say that the
/// worker holds tiles of other jobs.
class TileScheduler {
 public:
  /// Tiles of the grid of that size, as cut_tiles() orders them. `keys`, which must outlive this,
  /// tells which workers are one voter; null: none are.
  TileScheduler(std::vector<PixelRect> tiles, int tile_size, const TileRules& rules,
                const WorkerKeys* keys = nullptr);
  /// So many tiles of one pixel each.
  TileScheduler(size_t tiles, const TileRules& rules);

  /// These are done though nobody was given them: before the job was taken up again, say.
  void restore(const std::vector<uint32_t>& tiles);
  /// The tile is never split: another worker than that of each part would be wanted to check it.
  void keep_whole(uint32_t tile) { tiles_[tile].kept_whole = true; }
  /// From now on the worker may hold tiles. It traces `threads` of them at a time, in the order in
  /// which it got them. If it had vanished, no tile was the cause of it.
  void join(WorkerId worker, uint32_t threads = 1);
  /// The worker is gone. Whatever it held is pending again.
  SchedulerEvents leave(WorkerId worker, LossCause cause, Time now);
  /// What it holds, in the order in which it was given that.
  std::vector<Lease> leases_of(WorkerId worker) const;
  /// Whether a lease has a number of this coordinator's, and not of one before it.
  bool is_own(LeaseId lease) const;
  /// A suspect gets no work, and others get copies of what it holds, before all else.
  void set_suspect(WorkerId worker, bool suspect);

  /// A tile for this worker: a copy of a suspect's, or the next pending one.
  std::optional<Lease> assign(WorkerId worker, Time now, bool busy = false);
  /// Whether assign() would give it one that is pending or to be checked. Pieces of tiles that were
  /// split count only if `pieces` is true.
  bool has_tile_for(WorkerId worker, Time now, bool busy, bool pieces) const;
  /// How many tiles a worker of that many threads should hold: one for each, and some that wait,
  /// so that no thread waits for the network. While tiles come back at once and many are left, more
  /// wait, and go back several at a time: each trip costs the machine as much as tracing some
  /// pixels.
  size_t depth(uint32_t threads) const;
  /// Where no tile is pending in any job: what another worker has not begun, if this one is `idle`,
  /// or a second copy of one that takes long elsewhere.
  std::optional<Lease> assign_at_end(WorkerId worker, Time now, bool busy, bool idle,
                                     SchedulerEvents& events);
  /// Whether the worker holds a tile that failed before: beside that, nothing else runs.
  bool isolates(WorkerId worker) const;
  /// All leases that the worker holds, as of now. Returns how many of them are not ours any more
  /// yet still take up the worker; those of tiles that are finished, or that there are none of, are
  /// unwanted.
  /// `leaves`: it gives back all that it does not list.
  size_t report(WorkerId worker, const std::vector<LeaseProgress>& held, Time now,
                SchedulerEvents& events, bool leaves = false);
  /// All pixels of the tile are there, the last of them by `lease`, which may be none of ours.
  SchedulerEvents complete(uint32_t tile, LeaseId lease, Time now);
  /// All pixels of that part of a tile are there, the last of them by `lease`.
  SchedulerEvents complete_part(LeaseId lease);
  /// The worker could not trace the tile of this lease.
  SchedulerEvents fail(LeaseId lease, WorkerId worker, Time now);
  /// Two workers traced the tile and got different pixels: neither counts, and neither gets the
  /// tile again. One that is given up stays so.
  SchedulerEvents dispute(uint32_t tile, WorkerId one, WorkerId other, Time now);
  /// The workers of earlier calls of dispute() for the tile.
  const std::vector<WorkerId>& disputed_by(uint32_t tile) const { return tiles_[tile].disputed_by; }
  /// Whether what the worker says of the tile decides nothing: the tile is in dispute, and the
  /// worker, or another of the same voter, is a party to it.
  bool is_party(uint32_t tile, WorkerId worker) const;
  /// One of the two is known to be wrong: the other may trace it again.
  void forget_dispute(uint32_t tile);
  /// Whether the worker is not given the tile any more: those of its voter have failed it, or
  /// vanished with it, too often.
  bool is_barred(uint32_t tile, WorkerId worker) const;
  /// Tiles that some voter is barred from, whether they are done by now or not.
  const std::set<uint32_t>& barred_tiles() const { return barred_; }
  /// A disputed tile that no other worker has taken for a whole lease, and none that `gets_on` with
  /// what it does may take soon.
  std::optional<uint32_t> undecided(Time now, const std::function<bool(WorkerId)>& gets_on) const;
  /// The tile is done, and is not finished before a worker that is none of these has traced it too.
  void want_check(uint32_t tile, std::vector<WorkerId> traced_by);
  /// One has, under `lease`, with the same pixels.
  SchedulerEvents check_done(uint32_t tile, LeaseId lease);
  /// The pixels of the tile do not count any more.
  SchedulerEvents requeue(uint32_t tile);
  /// Gives up the checks that nobody has taken for TileRules::settle in which there was nothing
  /// else to do in this job, and for which nobody `is_awaited`, who is none of those that traced
  /// the tile. Returns how many.
  size_t abandon_checks(
      Time now,
      const std::function<bool(uint32_t tile, const std::vector<WorkerId>& traced_by)>& is_awaited);
  /// So much of the time of each lease does not count: nobody listened to its worker.
  void forgive(Time silence, Time now);
  /// Ends the leases that had no progress for too long.
  SchedulerEvents expire(Time now);
  /// One of expire()'s `stalled`, whose worker did nothing else either: it is blamed, the tile is
  /// not. A check that stalls too often is given up.
  SchedulerEvents stall(const Lease& lease, Time now);

  /// Whether pixels that the worker sends under that lease count: it was given the lease by this
  /// coordinator (`ours`), or by one before it on the same store, whose leases of whole tiles are
  /// adopted: what was traced under them is as good, though nobody knows any more whether this
  /// worker got them. At most two are adopted for each tile.
  bool accepts(LeaseId lease, bool ours, WorkerId worker);
  /// Nobody has it or ever had it.
  bool untouched(uint32_t tile) const {
    return tiles_[tile].state == State::pending && tiles_[tile].attempts == 0 &&
           tiles_[tile].disputed_by.empty();
  }
  bool finished() const { return open_tiles_ == 0 && checks_.empty(); }
  size_t held_by(WorkerId worker) const;
  bool has_pending() const { return !pending_.empty() || !waiting_checks_.empty(); }
  struct TileView {
    bool done = false, given_up = false;
    uint8_t copies = 0;   ///< live leases
    WorkerId worker = 0;  ///< of the first of these
    Time issued{};
  };
  TileView view(uint32_t tile) const;
  /// Leases now, and how long completed ones took, in the mean.
  size_t live_count() const { return live_.size(); }
  /// Threads of the workers that may hold tiles, suspects apart.
  size_t working_threads() const;
  std::optional<double> mean_seconds() const;
  uint64_t retries() const { return retries_; }
  uint64_t speculative() const { return speculative_; }
  /// Checks that were done, and those that nobody could do.
  uint64_t verified() const { return verified_; }
  uint64_t unverified() const { return unverified_; }

  /// The tile that a lease, live or not, was for.
  static uint32_t tile_of(LeaseId lease) { return TilePiece::of(lease).tile; }
  TileCosts& costs() { return costs_; }
  const TileCosts& costs() const { return costs_; }
  /// The tiles that are neither done nor given up, and what they will take, as far as is foreseen.
  TileWork left() const;
  /// Tiles that were split at the end of the queue, and what moved to an idle worker before another
  /// had begun with it.
  uint64_t split_tiles() const { return split_tiles_; }
  uint64_t moved() const { return moved_; }

 private:
  enum class State : uint8_t { pending, leased, done, given_up };
  struct Tile {
    State state = State::pending;
    uint32_t attempts = 0;
    std::vector<LeaseId> leases;          ///< live ones
    std::vector<WorkerId> vanished_by{};  ///< those that did so with it, and did not come back
    std::vector<WorkerId> failed_by;
    Time failed_at{};
    std::vector<WorkerId> disputed_by;
    Time disputed_at{};
    bool kept_whole = false;
    uint32_t parts = 1;       ///< that it is split into
    uint64_t parts_done = 0;  ///< bits
    uint8_t adopted = 0;      ///< leases
    bool split() const { return parts > 1; }
  };
  struct Holder {
    uint32_t threads = 1;
    bool suspect = false;
    std::vector<LeaseId> leases;  ///< in the order in which they were given
  };

  bool may_trace(const Tile& tile, WorkerId worker, Time now, bool busy) const;
  // Each finds the packed TilePiece that is next.
  std::optional<uint32_t> next_pending(WorkerId worker, Time now, bool busy);
  std::optional<uint32_t> next_check(WorkerId worker, Time now, bool busy);
  std::optional<uint32_t> next_of_suspect(WorkerId worker, Time now, bool busy) const;
  std::optional<uint32_t> next_straggler(WorkerId worker, Time now, bool busy) const;
  /// A tile that waits in another's queue, or a part of it; the rest is pending then.
  std::optional<uint32_t> take_waiting(WorkerId worker, Time now, bool busy,
                                       SchedulerEvents& events);
  enum class Why { next, copy, moved };
  Lease give(uint32_t piece, Why why, WorkerId worker, Time now);
  void hold(const Lease& lease);
  /// Takes the tile, or what of it is pending, out of the queue.
  void forget_pending(uint32_t tile);
  size_t copies_of(uint32_t piece) const;
  /// How many parts a tile that is whole should be split into; 1: none.
  uint32_t useful_parts(uint32_t tile, size_t most) const;
  /// Splits a tile that nobody holds and that is not pending; but for the first part, which is
  /// returned, all are pending.
  uint32_t split(uint32_t tile, uint32_t parts);
  /// The tile is whole again, and pending if it is not done.
  void merge(uint32_t tile, SchedulerEvents& events);
  void order_pending();
  void forget_check(uint32_t tile);
  /// The worker goes on with a tile that a coordinator before this one gave it.
  void go_on(const LeaseProgress& progress, WorkerId worker, Time now);
  bool issued(LeaseId lease, WorkerId worker) const;
  /// The upper bits of the leases that this coordinator gives.
  uint64_t opening_tag() const;
  WorkerKeys::Voter voter_of(WorkerId worker) const {
    return keys_ ? keys_->voter_of(worker) : worker;
  }
  Time straggler_age() const;
  Time lease_length(const Tile& tile) const;
  /// Forgets a live lease; the tile is pending if that was its last.
  Lease drop(LeaseId lease);
  void blame(uint32_t tile, WorkerId worker, Time now, SchedulerEvents& events);
  /// How many of them are of the worker's voter.
  size_t count_of_voter(const std::vector<WorkerId>& by, WorkerId worker) const;
  /// After a list of who failed the tile, or vanished with it, has grown: gives the tile up once
  /// there are `most` or, where keys are voters, half as many of each of two; bars a voter from it
  /// that has so many alone.
  void judge(uint32_t tile, const std::vector<WorkerId>& by, size_t most, SchedulerEvents& events);
  void give_up(uint32_t tile, SchedulerEvents& events);

  TileRules rules_;
  const WorkerKeys* keys_;
  std::vector<PixelRect> rects_;
  std::vector<Tile> tiles_;
  TileCosts costs_;
  std::deque<uint32_t> pending_;  ///< packed pieces
  std::map<LeaseId, Lease> live_;
  std::unordered_map<LeaseId, WorkerId> issued_;      ///< all there ever were
  std::vector<uint32_t> disputed_;                    ///< tiles
  std::set<uint32_t> barred_;                         ///< tiles
  std::map<uint32_t, std::vector<WorkerId>> checks_;  ///< by tile: who cannot do it
  std::deque<uint32_t> waiting_checks_;               ///< those that no lease is for
  std::optional<Time> uncheckable_since_;
  std::unordered_map<WorkerId, Holder> holders_;
  std::set<WorkerId> suspects_;  ///< of holders_
  std::set<LeaseId> waiting_;    ///< live ones beyond the threads of their holders
  size_t threads_ = 0;           ///< of holders_
  std::map<WorkerId, std::vector<uint32_t>> vanished_with_;
  std::vector<Time> durations_;  ///< of completed leases, the first ones
  Time duration_sum_{};          ///< of these
  /// Among how many durations straggler_age() looked last, and what it found: it is asked for far
  /// more often than it changes.
  mutable std::pair<size_t, Time> straggler_age_{};
  /// How many costs must be known to look again what an open tile will take in the mean, and this.
  mutable std::pair<size_t, double> mean_left_{};
  std::optional<Time> lately_;  ///< how long these take now
  size_t open_tiles_;
  uint64_t leases_issued_ = 0, retries_ = 0, speculative_ = 0, late_copies_ = 0, verified_ = 0,
           unverified_ = 0, split_tiles_ = 0, moved_ = 0;
};

}  // namespace tessera
