#include "coordinator/tiles/assembler.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <utility>

#include "base/saturating_sum.h"
#include "proto/wire/pixels.h"

namespace tessera {

static_assert(kWireChannels == kFilmChannels);

namespace {

// Of all tiles of a job together, so that its report fits a message.
constexpr size_t kMaxCounters = 256;
constexpr size_t kMaxCounterName = 64;

/// Ranges of rows that begin at `first` and follow one upon the other until `last`; none where
/// there is no such chain. `counts` are by first row: who would continue a range comes after it.
template <typename Counts>
std::vector<const std::vector<uint64_t>*> find_chain(const Counts& counts, int first, int last) {
  std::map<int, typename Counts::const_iterator> reached_by;  // rows behind a chain from `first`
  for (auto it = counts.begin(); it != counts.end(); ++it) {
    const auto [from, to] = it->first;
    if (from == first || reached_by.contains(from)) reached_by.try_emplace(to, it);
  }
  std::vector<const std::vector<uint64_t>*> chain;
  if (!reached_by.contains(last)) return chain;
  for (int row = last; row != first; row = reached_by.at(row)->first.first) {
    chain.push_back(&reached_by.at(row)->second);
  }
  return chain;
}

}  // namespace

Assembler::Assembler(const PixelRect& crop, std::vector<PixelRect> tiles, AovSet aovs)
    : tiles_(std::move(tiles)),
      done_by_(tiles_.size()),
      film_(crop, aovs),
      counts_(tiles_.size()) {}

bool Assembler::plausible(const v1::TileBand& band) const {
  const TilePiece piece = TilePiece::of(band.lease());
  if (band.tile() >= tiles_.size() || band.tile() != piece.tile) return false;
  const PixelRect tile = piece.rect(tiles_[band.tile()]);
  return !tile.empty() && band.rows() > 0 && band.first_row() >= tile.y0 &&
         band.first_row() < tile.y1 && band.rows() <= tile.y1 - band.first_row();
}

std::vector<uint64_t> Assembler::counts_of(const v1::Counters& counters) {
  std::vector<uint64_t> counts(names_.size());
  for (const auto& [name, value] : counters.values()) {
    const auto known = names_.find(name);
    const bool surplus = name.size() > kMaxCounterName || names_.size() >= kMaxCounters;
    if (known == names_.end() && surplus) continue;
    const size_t place = known != names_.end() ? known->second : names_.size();
    if (known == names_.end()) names_.emplace(name, place);
    if (counts.size() <= place) counts.resize(place + 1);
    counts[place] = value;
  }
  return counts;
}

CounterMap Assembler::counters() const {
  std::vector<uint64_t> sums(names_.size());
  for (const auto& counts : counts_) {
    for (size_t i = 0; i < counts.size(); ++i) sums[i] = saturating_sum(sums[i], counts[i]);
  }
  CounterMap result;
  for (const auto& [name, place] : names_) result[name] = sums[place];
  return result;
}

void Assembler::note_build_counters(const v1::Counters& counters) {
  if (!build_counters_.empty() || counters.values_size() > static_cast<int>(kMaxCounters)) return;
  for (const auto& [name, value] : counters.values()) {
    if (name.size() <= kMaxCounterName) build_counters_[name] = value;
  }
}

std::vector<uint32_t> Assembler::restore(
    const std::vector<FinishedTile>& kept,
    const std::function<WorkerId(uint32_t, const FinishedTile&)>& tracer_of) {
  std::vector<uint32_t> restored;
  if (kept.empty()) return restored;
  std::map<std::pair<int, int>, uint32_t> tile_at;
  for (uint32_t i = 0; i < tiles_.size(); ++i)
    tile_at.emplace(std::pair(tiles_[i].x0, tiles_[i].y0), i);
  for (const FinishedTile& tile : kept) {
    const auto place = tile_at.find({tile.rect.x0, tile.rect.y0});
    if (place == tile_at.end() || tiles_[place->second] != tile.rect) continue;
    const WorkerId from = tracer_of ? tracer_of(place->second, tile) : kFromStore;
    for (v1::TileBand band : tile.kept.bands()) {
      band.set_tile(place->second);
      band.set_lease(place->second);
      if (add(band, from).completed_tile) restored.push_back(place->second);
    }
    // What is damaged is traced again.
    if (!complete(place->second)) reopen(place->second);
  }
  return restored;
}

std::vector<PixelRect> Assembler::holes() const {
  std::vector<PixelRect> holes;
  for (uint32_t tile = 0; tile < tiles_.size(); ++tile) {
    if (!complete(tile)) holes.push_back(tiles_[tile]);
  }
  return holes;
}

void Assembler::mark_holes() {
  for (const PixelRect& hole : holes()) film_.mark_hole(hole);
}

std::vector<v1::TileBand> Assembler::bands_of(uint32_t tile) const {
  const PixelRect& rect = tiles_[tile];
  const size_t row_values = row_size(rect);
  std::vector<float> values;
  values.reserve(row_values * static_cast<size_t>(rect.height()));
  for (int row = rect.y0; row < rect.y1; ++row) {
    const auto pixels = film_.values().subspan(row_offset(rect, row), row_values);
    values.insert(values.end(), pixels.begin(), pixels.end());
  }
  std::vector<v1::TileBand> bands =
      encode_bands(values, rect.width(), rect.y0, true, film_.channels());
  for (v1::TileBand& band : bands) {
    band.set_tile(tile);
    band.set_lease(tile);
  }
  auto& counters = *bands.back().mutable_counters()->mutable_values();
  const std::vector<uint64_t>& counts = counts_[tile];
  for (const auto& [name, place] : names_) {
    if (place < counts.size()) counters[name] = counts[place];
  }
  return bands;
}

size_t Assembler::row_size(const PixelRect& tile) const {
  return static_cast<size_t>(tile.width()) * static_cast<size_t>(film_.channels());
}

size_t Assembler::row_offset(const PixelRect& tile, int row) const {
  const PixelRect& rect = film_.rect();
  return (static_cast<size_t>(row - rect.y0) * static_cast<size_t>(rect.width()) +
          static_cast<size_t>(tile.x0 - rect.x0)) *
         static_cast<size_t>(film_.channels());
}

WorkerId Assembler::owner_of(uint32_t tile, size_t row) const {
  const auto it = mixed_.find(tile);
  return it == mixed_.end() ? done_by_[tile] : it->second[row];
}

void Assembler::reopen(uint32_t tile) {
  partial_.erase(tile);
  mixed_.erase(tile);
  if (done_by_[tile] == 0) return;
  done_by_[tile] = 0;
  counts_[tile] = {};
  --tiles_done_;
}

std::span<const float> Assembler::row(uint32_t tile, int row) const {
  const PixelRect& rect = tiles_[tile];
  return film_.values().subspan(row_offset(rect, row), row_size(rect));
}

bool Assembler::same_row(uint32_t tile, int row, std::span<const float> values) const {
  return std::memcmp(this->row(tile, row).data(), values.data(), values.size_bytes()) == 0;
}

BandResult Assembler::add(const v1::TileBand& band, WorkerId from) {
  BandResult result;
  if (!plausible(band)) return result;
  const uint32_t index = band.tile();
  const PixelRect& tile = tiles_[index];
  const size_t row_values = row_size(tile);
  if (!decode_band(band, tile.width(), scratch_, film_.channels())) return result;
  // A TileRenderer gives none.
  const auto finite = [](float value) { return std::isfinite(value); };
  if (!std::all_of(scratch_.begin(), scratch_.end(), finite)) return result;
  result.valid = true;

  const bool was_complete = complete(index);
  Partial* partial = nullptr;
  if (!was_complete) {
    partial = &partial_[index];
    if (partial->row_from.empty()) {
      partial->row_from.resize(static_cast<size_t>(tile.height()));
      partial->rows_missing = tile.height();
    }
  }
  for (int i = 0; i < band.rows(); ++i) {
    const int row = band.first_row() + i;
    const auto values =
        std::span<const float>(scratch_).subspan(row_values * static_cast<size_t>(i), row_values);
    const auto row_of_tile = static_cast<size_t>(row - tile.y0);
    const WorkerId owner = partial ? partial->row_from[row_of_tile] : owner_of(index, row_of_tile);
    if (partial && owner == 0) {
      partial->row_from[row_of_tile] = from;
      --partial->rows_missing;
      film_.write(tile, row, 1, values);
    } else if (!result.mismatch && !same_row(index, row, values)) {
      const auto there = this->row(index, row);
      result.mismatch = Mismatch{
          index, row, owner, from, {there.begin(), there.end()}, {values.begin(), values.end()}};
    }
  }
  if (was_complete) {
    result.duplicate_tile = band.last();
    return result;
  }
  const PixelRect counted = TilePiece::of(band.lease()).rect(tile);
  if (band.last()) {
    partial->counts.try_emplace({counted.y0, counted.y1}, counts_of(band.counters()));
  }
  if (partial->rows_missing > 0) return result;
  if (auto sums = counts_of(*partial, tile)) {
    complete_tile(index, std::move(*sums), from);
    result.completed_tile = true;
  }
  return result;
}

void Assembler::complete_tile(uint32_t index, std::vector<uint64_t> counts, WorkerId from) {
  counts_[index] = std::move(counts);
  done_by_[index] = from;
  const auto partial = partial_.find(index);
  if (partial != partial_.end()) {
    std::vector<WorkerId>& row_from = partial->second.row_from;
    const bool mixed = std::any_of(row_from.begin(), row_from.end(),
                                   [from](WorkerId owner) { return owner != from; });
    if (mixed) mixed_[index] = std::move(row_from);
    partial_.erase(partial);
  }
  ++tiles_done_;
  done_order_.push_back(index);
}

std::optional<std::vector<uint64_t>> Assembler::counts_of(const Partial& partial,
                                                          const PixelRect& tile) const {
  const auto chain = find_chain(partial.counts, tile.y0, tile.y1);
  if (chain.empty()) return std::nullopt;
  if (chain.size() == 1) return *chain.front();
  std::vector<uint64_t> sums(names_.size());
  for (const auto& [name, place] : names_) {
    // What is true of a tile is so where it is of all its parts.
    const bool of_tile = name.starts_with("tiles_");
    for (size_t i = 0; i < chain.size(); ++i) {
      const uint64_t count = place < chain[i]->size() ? (*chain[i])[place] : 0;
      sums[place] = i == 0    ? count
                    : of_tile ? std::min(sums[place], count)
                              : saturating_sum(sums[place], count);
    }
  }
  return sums;
}

bool Assembler::has_piece(LeaseId lease) const {
  const TilePiece piece = TilePiece::of(lease);
  const auto it = partial_.find(piece.tile);
  if (it == partial_.end()) return complete(piece.tile);
  const PixelRect& tile = tiles_[piece.tile];
  const PixelRect rows = piece.rect(tile);
  if (rows.empty() || !it->second.counts.contains({rows.y0, rows.y1})) return false;
  const auto first = it->second.row_from.begin() + (rows.y0 - tile.y0);
  return std::find(first, first + rows.height(), WorkerId{0}) == first + rows.height();
}

bool Assembler::fill(uint32_t index, std::span<const float> value, const v1::Counters& of_pixel,
                     WorkerId from) {
  if (complete(index) || partial_.contains(index)) return false;
  std::vector<uint64_t> counts = counts_of(of_pixel);
  const PixelRect& tile = tiles_[index];
  for (const auto& [name, place] : names_) {
    if (place >= counts.size() || name.starts_with("tiles_")) continue;
    uint64_t& count = counts[place];
    if (__builtin_mul_overflow(count, static_cast<uint64_t>(tile.area()), &count)) {
      count = std::numeric_limits<uint64_t>::max();
    }
  }
  scratch_.resize(row_size(tile));
  for (size_t i = 0; i < scratch_.size(); ++i) scratch_[i] = value[i % value.size()];
  for (int row = tile.y0; row < tile.y1; ++row) film_.write(tile, row, 1, scratch_);
  complete_tile(index, std::move(counts), from);
  return true;
}

}  // namespace tessera
