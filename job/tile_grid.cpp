#include "job/tile_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "base/error.h"

namespace tessera {
namespace {

/// The bits of x and y in turns.
uint64_t morton(uint32_t x, uint32_t y) {
  const auto spread = [](uint64_t v) {
    v = (v | v << 16) & 0x0000ffff0000ffff;
    v = (v | v << 8) & 0x00ff00ff00ff00ff;
    v = (v | v << 4) & 0x0f0f0f0f0f0f0f0f;
    v = (v | v << 2) & 0x3333333333333333;
    return (v | v << 1) & 0x5555555555555555;
  };
  return spread(x) | spread(y) << 1;
}

}  // namespace

int choose_tile_size(const PixelRect& crop, int workers) {
  constexpr int kSmallest = 16, kLargest = 64, kStep = 8;
  constexpr int64_t kTilesPerWorker = 100;
  const int64_t enough = kTilesPerWorker * std::max(1, workers);
  int side = kLargest;
  while (side > kSmallest && crop.area() < enough * side * side) side -= kStep;
  return side;
}

namespace {

/// The tiles of the frame's grid that `crop` touches.
struct GridRange {
  int first_x, last_x, first_y, last_y;
  int64_t count() const { return int64_t{last_x - first_x + 1} * (last_y - first_y + 1); }
};

GridRange grid_range(const PixelRect& crop, int tile_size) {
  return {crop.x0 / tile_size, (crop.x1 - 1) / tile_size, crop.y0 / tile_size,
          (crop.y1 - 1) / tile_size};
}

}  // namespace

void check_tile_size(const PixelRect& crop, int tile_size) {
  if (tile_size < 1) {
    throw usage_error(fmt::format("tile size {}; expected at least 1", tile_size));
  }
  const int64_t count = grid_range(crop, tile_size).count();
  if (count > kMaxTiles) {
    throw usage_error(fmt::format("tile size {} gives {} tiles; expected at most {}", tile_size,
                                  count, kMaxTiles));
  }
}

std::vector<PixelRect> cut_tiles(const PixelRect& crop, int tile_size) {
  check_tile_size(crop, tile_size);
  const auto [first_x, last_x, first_y, last_y] = grid_range(crop, tile_size);
  struct Cell {
    uint64_t order;
    PixelRect rect;
  };
  std::vector<Cell> cells;
  cells.reserve(static_cast<size_t>(grid_range(crop, tile_size).count()));
  for (int y = first_y; y <= last_y; ++y) {
    for (int x = first_x; x <= last_x; ++x) {
      const auto end = [tile_size](int cell) { return (int64_t{cell} + 1) * tile_size; };
      const PixelRect rect{std::max(crop.x0, x * tile_size), std::max(crop.y0, y * tile_size),
                           static_cast<int>(std::min<int64_t>(crop.x1, end(x))),
                           static_cast<int>(std::min<int64_t>(crop.y1, end(y)))};
      cells.push_back(
          {morton(static_cast<uint32_t>(x - first_x), static_cast<uint32_t>(y - first_y)), rect});
    }
  }
  std::sort(cells.begin(), cells.end(),
            [](const Cell& a, const Cell& b) { return a.order < b.order; });
  std::vector<PixelRect> tiles;
  tiles.reserve(cells.size());
  for (const Cell& cell : cells) tiles.push_back(cell.rect);
  return tiles;
}

}  // namespace tessera
