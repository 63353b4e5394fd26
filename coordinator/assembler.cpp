#include "coordinator/assembler.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "proto/wire/pixels.h"

namespace tessera {

static_assert(kWireChannels == kFilmChannels);

namespace {

constexpr int kMaxCounters = 256;
constexpr size_t kMaxCounterName = 64;

}  // namespace

bool plausible_counters(const v1::Counters& counters) {
  return counters.values_size() <= kMaxCounters &&
         std::all_of(counters.values().begin(), counters.values().end(),
                     [](const auto& entry) { return entry.first.size() <= kMaxCounterName; });
}

Assembler::Assembler(const PixelRect& crop, std::vector<PixelRect> tiles)
    : tiles_(std::move(tiles)), done_by_(tiles_.size()), film_(crop) {}

bool Assembler::plausible(const v1::TileBand& band) const {
  if (band.tile() >= tiles_.size() || band.tile() != TileScheduler::tile_of(band.lease())) {
    return false;
  }
  const PixelRect& tile = tiles_[band.tile()];
  return band.rows() > 0 && band.first_row() >= tile.y0 && band.first_row() < tile.y1 &&
         band.rows() <= tile.y1 - band.first_row() && plausible_counters(band.counters());
}

bool Assembler::same_row(const PixelRect& tile, int row, const float* values) const {
  const PixelRect& rect = film_.rect();
  const size_t offset = (static_cast<size_t>(row - rect.y0) * static_cast<size_t>(rect.width()) +
                         static_cast<size_t>(tile.x0 - rect.x0)) *
                        kFilmChannels;
  const size_t size = static_cast<size_t>(tile.width()) * kFilmChannels;
  return std::memcmp(film_.values().data() + offset, values, size * sizeof(float)) == 0;
}

BandResult Assembler::add(const v1::TileBand& band, WorkerId from) {
  BandResult result;
  if (!plausible(band)) return result;
  const uint32_t index = band.tile();
  const PixelRect& tile = tiles_[index];
  const size_t row_values = static_cast<size_t>(tile.width()) * kFilmChannels;
  scratch_.resize(row_values * static_cast<size_t>(band.rows()));
  if (!decode_band(band, scratch_)) return result;
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
    const float* values = scratch_.data() + row_values * static_cast<size_t>(i);
    WorkerId& owner =
        partial ? partial->row_from[static_cast<size_t>(row - tile.y0)] : done_by_[index];
    if (owner == 0) {
      owner = from;
      --partial->rows_missing;
      film_.write(tile, row, 1, std::span(values, row_values));
    } else if (!result.mismatch && !same_row(tile, row, values)) {
      result.mismatch = Mismatch{index, row, owner, from};
    }
  }
  if (was_complete) {
    result.duplicate_tile = band.last();
    return result;
  }
  if (band.last() && !partial->counters) partial->counters = band.counters();
  if (partial->rows_missing == 0 && partial->counters) {
    for (const auto& [name, value] : partial->counters->values()) counters_[name] += value;
    done_by_[index] = from;
    partial_.erase(index);
    ++tiles_done_;
    result.completed_tile = true;
  }
  return result;
}

}  // namespace tessera
