#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "coordinator/tiles/tile_piece.h"
#include "renderer/film/tile.h"

namespace tessera {

/// Some tiles, and what they take together, in seconds of one thread; 0: nobody knows.
struct TileWork {
  uint64_t tiles = 0;
  double seconds = 0;

  TileWork& operator+=(const TileWork& other) {
    tiles += other.tiles;
    seconds += other.seconds;
    return *this;
  }
};

/// What the tiles of a frame will take, in seconds of one thread: what they took in an earlier
/// frame of the same grid or else what their finished neighbours took, near ones above all. Plain
/// values; no clock.
class TileCosts {
 public:
  /// The tiles of a grid of that size, as cut_tiles() orders them.
  TileCosts(const std::vector<PixelRect>& tiles, int tile_size);

  /// An earlier frame tells, if its tiles are the same.
  void learn_from(const TileCosts& earlier);
  /// As much of an earlier frame: that tile took so long.
  void learn(uint32_t tile, double seconds);
  /// That tile, or so large a share of it, has taken so long.
  void note(uint32_t tile, double seconds);
  /// What note() or learn() told of that tile; nothing: neither did.
  std::optional<double> told(uint32_t tile) const;
  /// Nothing while nothing is known.
  std::optional<double> predict(uint32_t tile) const;
  /// The tiles of this frame that note() told of.
  TileWork known() const { return {known_, sum_}; }

  /// Whether tiles should be put in order again: so much more is known.
  bool order_is_due() const { return known_ >= next_order_; }
  /// Puts tiles that are yet to be traced in order: costly ones first; of much the same costs those
  /// next to each other. Where nothing is known, one of sixteen first, from which the others' costs
  /// are learned.
  void put_in_order(std::deque<uint32_t>& tiles);

 private:
  int cell_x(uint32_t tile) const { return static_cast<int>(cell_of_[tile] % columns_); }
  int cell_y(uint32_t tile) const { return static_cast<int>(cell_of_[tile] / columns_); }
  /// The tiles around it hear that it takes so long, and forget what it told before.
  void tell_around(uint32_t tile, float seconds);
  double mean() const;
  /// By which power of two the tile differs from the mean.
  int rank(uint32_t tile, double mean) const;

  std::vector<PixelRect> tiles_;
  uint32_t columns_ = 0, rows_ = 0;
  std::vector<uint32_t> cell_of_;         ///< by tile
  std::vector<float> seconds_, earlier_;  ///< by tile; below 0: not known
  struct Known {
    double seconds = 0, weight = 0;
  };
  std::vector<Known> near_;  ///< what is known around each cell
  double sum_ = 0, earlier_sum_ = 0;
  size_t known_ = 0, learned_ = 0, next_order_ = 0;
};

}  // namespace tessera
