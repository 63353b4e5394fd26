#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "coordinator/tiles/assembler.h"
#include "coordinator/tiles/tile_scheduler.h"
#include "coordinator/tiles/worker_keys.h"

namespace tessera {

/// Which tiles of a job a second worker traces too, who traced what, and who of two that differ was
/// wrong. A worker of whose tiles n are wrong is found out with a probability of 1 - (1 - share)^n
/// at least. Plain values; no clock.
class TileVerifier {
 public:
  /// `share` from 0 to 1; `key` is drawn and known to nobody else, so that no worker can tell which
  /// of its tiles are looked at.
  /// `keys`, which must outlive this, tells which workers are one voter; null: none are.
  TileVerifier(size_t tiles, double share, uint64_t key, const WorkerKeys* keys = nullptr)
      : share_(share), key_(key), keys_(keys), traced_by_(tiles) {}

  bool selects(uint32_t tile) const;
  /// Whether a second worker is to trace it too: selects(), or a suspect has traced of it.
  bool wants_second(uint32_t tile) const;
  /// What this worker said is not what another did: all that it traces is looked at.
  void suspect(WorkerId worker) { suspects_.push_back(worker); }

  /// Rows of the tile were taken from the worker.
  void note_rows(uint32_t tile, WorkerId worker);
  /// Whose rows a tile has, or may have.
  const std::vector<WorkerId>& traced_by(uint32_t tile) const { return traced_by_[tile]; }
  /// Tiles that have, or may have, rows of that worker or, with `by_voter`, of any of the same
  /// voter.
  std::vector<uint32_t> tiles_of(WorkerId worker, bool by_voter = false) const;
  /// The tile is complete, and these rows came again, with the same bits. True once all of `tile`'s
  /// rows came so from this worker, and it is another voter's than those that traced it.
  bool note_same_rows(uint32_t tile, WorkerId worker, const PixelRect& rect, int first_row,
                      int rows);
  /// Nothing of it counts any more.
  void forget(uint32_t tile);

  /// Two differ; a third is to judge.
  void note_dispute(Mismatch mismatch);
  /// What is known to judge by once the tile is complete again; null: it was not in dispute.
  const Mismatch* dispute(uint32_t tile) const;
  /// Who of the two was wrong, as the third's pixels of the row say; nothing where both were.
  static std::optional<WorkerId> judge(const Mismatch& dispute, std::span<const float> third);
  /// Tiles about which this worker and another differ; `by_voter` as of tiles_of().
  std::vector<uint32_t> disputes_of(WorkerId worker, bool by_voter = false) const;
  void settle(uint32_t tile) { disputes_.erase(tile); }

 private:
  WorkerKeys::Voter voter_of(WorkerId worker) const {
    return keys_ ? keys_->voter_of(worker) : worker;
  }
  /// Whether `a` is the worker `b` or, with `by_voter`, of the same voter.
  bool same(WorkerId a, WorkerId b, bool by_voter) const {
    return a == b || (by_voter && voter_of(a) == voter_of(b));
  }

  double share_;
  uint64_t key_;
  const WorkerKeys* keys_;
  std::vector<std::vector<WorkerId>> traced_by_;                     ///< by tile
  std::map<std::pair<uint32_t, WorkerId>, std::vector<bool>> same_;  ///< rows
  std::map<uint32_t, Mismatch> disputes_;
  std::vector<WorkerId> suspects_;
};

}  // namespace tessera
