#include "coordinator/tiles/tile_verifier.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "base/digest.h"

namespace tessera {
namespace {

bool same_bits(std::span<const float> a, std::span<const float> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

}  // namespace

bool TileVerifier::selects(uint32_t tile) const {
  if (share_ <= 0) return false;
  const Digest digest = Digest::of(fmt::format("{:016x} {}", key_, tile));
  uint64_t word;
  std::memcpy(&word, digest.bytes.data(), sizeof word);
  return static_cast<double>(word >> 11) * 0x1p-53 < share_;
}

bool TileVerifier::wants_second(uint32_t tile) const {
  const std::vector<WorkerId>& by = traced_by_[tile];
  return selects(tile) || std::any_of(by.begin(), by.end(), [this](WorkerId worker) {
           return std::any_of(suspects_.begin(), suspects_.end(), [&](WorkerId suspect) {
             return voter_of(suspect) == voter_of(worker);
           });
         });
}

void TileVerifier::note_rows(uint32_t tile, WorkerId worker) {
  std::vector<WorkerId>& by = traced_by_[tile];
  if (std::find(by.begin(), by.end(), worker) == by.end()) by.push_back(worker);
}

std::vector<uint32_t> TileVerifier::tiles_of(WorkerId worker, bool by_voter) const {
  std::vector<uint32_t> tiles;
  for (uint32_t tile = 0; tile < traced_by_.size(); ++tile) {
    const std::vector<WorkerId>& by = traced_by_[tile];
    const auto is_its = [&](WorkerId id) { return same(id, worker, by_voter); };
    if (std::any_of(by.begin(), by.end(), is_its)) tiles.push_back(tile);
  }
  return tiles;
}

bool TileVerifier::note_same_rows(uint32_t tile, WorkerId worker, const PixelRect& rect,
                                  int first_row, int rows) {
  const std::vector<WorkerId>& by = traced_by_[tile];
  const auto is_its_voter = [&](WorkerId id) { return voter_of(id) == voter_of(worker); };
  if (std::any_of(by.begin(), by.end(), is_its_voter)) return false;
  std::vector<bool>& same = same_[{tile, worker}];
  same.resize(static_cast<size_t>(rect.height()));
  std::fill_n(same.begin() + (first_row - rect.y0), rows, true);
  if (std::find(same.begin(), same.end(), false) != same.end()) return false;
  same_.erase({tile, worker});
  return true;
}

void TileVerifier::forget(uint32_t tile) {
  traced_by_[tile].clear();
  same_.erase(same_.lower_bound({tile, 0}), same_.upper_bound({tile, ~WorkerId{0}}));
}

void TileVerifier::note_dispute(Mismatch mismatch) {
  const uint32_t tile = mismatch.tile;
  disputes_.insert_or_assign(tile, std::move(mismatch));
}

const Mismatch* TileVerifier::dispute(uint32_t tile) const {
  const auto it = disputes_.find(tile);
  return it == disputes_.end() ? nullptr : &it->second;
}

std::vector<uint32_t> TileVerifier::disputes_of(WorkerId worker, bool by_voter) const {
  std::vector<uint32_t> tiles;
  for (const auto& [tile, dispute] : disputes_) {
    if (same(dispute.first, worker, by_voter) || same(dispute.second, worker, by_voter)) {
      tiles.push_back(tile);
    }
  }
  return tiles;
}

std::optional<WorkerId> TileVerifier::judge(const Mismatch& dispute, std::span<const float> third) {
  if (same_bits(dispute.first_pixels, third)) return dispute.second;
  if (same_bits(dispute.second_pixels, third)) return dispute.first;
  return std::nullopt;
}

}  // namespace tessera
