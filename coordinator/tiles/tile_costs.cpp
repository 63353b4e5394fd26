#include "coordinator/tiles/tile_costs.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tessera {
namespace {

// Fewer tiles than this are traced in the order of their grid: there is little to learn.
constexpr size_t kFewTiles = 64;
// One tile in so many rows and columns is traced first.
constexpr int kProbes = 4;
constexpr int kNeighbours = 2;  // rows and columns on each side that tell of a tile
constexpr float kUnknown = -1;
/// Halvings and doublings of the mean that are told apart: finer ones would tear neighbours apart,
/// which see the same part of the scene.
constexpr int kLeastRank = -2, kMostRank = 4;

/// How much a tile that many columns and rows away tells of another.
double nearness(int x, int y) { return std::exp(-(x * x + y * y) / 1.5); }

/// What is not a number is left out, and nobody has traced a tile for years.
bool is_possible(double seconds) { return seconds >= 0 && seconds < 1e8; }

}  // namespace

TileCosts::TileCosts(const std::vector<PixelRect>& tiles, int tile_size)
    : tiles_(tiles), seconds_(tiles.size(), kUnknown) {
  int first_x = 1 << 30, first_y = 1 << 30, last_x = 0, last_y = 0;
  for (const PixelRect& tile : tiles) {
    first_x = std::min(first_x, tile.x0 / tile_size);
    first_y = std::min(first_y, tile.y0 / tile_size);
    last_x = std::max(last_x, tile.x0 / tile_size);
    last_y = std::max(last_y, tile.y0 / tile_size);
  }
  if (tiles.empty()) return;
  columns_ = static_cast<uint32_t>(last_x - first_x + 1);
  rows_ = static_cast<uint32_t>(last_y - first_y + 1);
  near_.resize(static_cast<size_t>(columns_) * rows_);
  cell_of_.reserve(tiles.size());
  for (uint32_t i = 0; i < tiles.size(); ++i) {
    const auto x = static_cast<uint32_t>(tiles[i].x0 / tile_size - first_x);
    const auto y = static_cast<uint32_t>(tiles[i].y0 / tile_size - first_y);
    cell_of_.push_back(y * columns_ + x);
  }
}

void TileCosts::learn_from(const TileCosts& earlier) {
  if (earlier.tiles_ != tiles_) return;
  for (uint32_t tile = 0; tile < tiles_.size(); ++tile) {
    if (const auto seconds = earlier.told(tile)) learn(tile, *seconds);
  }
}

void TileCosts::learn(uint32_t tile, double seconds) {
  if (!is_possible(seconds)) return;
  earlier_.resize(tiles_.size(), kUnknown);
  const auto now = static_cast<float>(seconds), before = earlier_[tile];
  if (seconds_[tile] < 0) tell_around(tile, now);
  earlier_[tile] = now;
  learned_ += before < 0;
  earlier_sum_ += static_cast<double>(now) - static_cast<double>(std::max(0.f, before));
}

void TileCosts::note(uint32_t tile, double seconds) {
  if (!is_possible(seconds)) return;
  const auto now = static_cast<float>(seconds), before = seconds_[tile];
  tell_around(tile, now);
  seconds_[tile] = now;
  known_ += before < 0;
  sum_ += static_cast<double>(now) - static_cast<double>(std::max(0.f, before));
}

std::optional<double> TileCosts::told(uint32_t tile) const {
  const float seconds = seconds_[tile] >= 0 || earlier_.empty() ? seconds_[tile] : earlier_[tile];
  return seconds < 0 ? std::nullopt : std::optional<double>(seconds);
}

void TileCosts::tell_around(uint32_t tile, float seconds) {
  const auto before = told(tile);
  const double more = static_cast<double>(seconds) - before.value_or(0);
  const int columns = static_cast<int>(columns_), rows = static_cast<int>(rows_);
  for (int y = std::max(0, cell_y(tile) - kNeighbours);
       y <= std::min(rows - 1, cell_y(tile) + kNeighbours); ++y) {
    for (int x = std::max(0, cell_x(tile) - kNeighbours);
         x <= std::min(columns - 1, cell_x(tile) + kNeighbours); ++x) {
      Known& near = near_[static_cast<size_t>(y) * columns_ + static_cast<size_t>(x)];
      const double weight = nearness(x - cell_x(tile), y - cell_y(tile));
      near.seconds += weight * more;
      near.weight += before ? 0 : weight;
    }
  }
}

std::optional<double> TileCosts::predict(uint32_t tile) const {
  if (const auto seconds = told(tile)) return seconds;
  const Known& near = near_[cell_of_[tile]];
  if (near.weight > 0) return near.seconds / near.weight;
  return known_ > 0 || !earlier_.empty() ? std::optional(mean()) : std::nullopt;
}

double TileCosts::mean() const {
  return known_ > 0 ? sum_ / static_cast<double>(known_)
                    : earlier_sum_ / static_cast<double>(std::max<size_t>(1, learned_));
}

int TileCosts::rank(uint32_t tile, double mean) const {
  const auto cost = predict(tile);
  if (!cost) return cell_x(tile) % kProbes == 1 && cell_y(tile) % kProbes == 1 ? 1 : 0;
  if (!(*cost > 0)) return kLeastRank;
  return std::clamp(std::ilogb(*cost / mean), kLeastRank, kMostRank);
}

void TileCosts::put_in_order(std::deque<uint32_t>& tiles) {
  const size_t count = tiles_.size();
  // After the probes, and then each time that twice as much is known.
  const size_t known = std::max(known_, learned_);
  next_order_ = known == 0 ? std::max<size_t>(1, count / (kProbes * kProbes)) : 2 * known;
  if (next_order_ > count / 2) next_order_ = ~size_t{0};
  if (count < kFewTiles) return;
  const double mean_cost = mean();
  std::vector<std::pair<int, uint32_t>> order;
  order.reserve(tiles.size());
  for (const uint32_t tile : tiles) order.emplace_back(-rank(tile, mean_cost), tile);
  std::sort(order.begin(), order.end());
  std::transform(order.begin(), order.end(), tiles.begin(),
                 [](const auto& entry) { return entry.second; });
}

}  // namespace tessera
