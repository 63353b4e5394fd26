#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "coordinator/tiles/tile_scheduler.h"
#include "coordinator/tiles/tile_store.h"
#include "coordinator/tiles/worker_keys.h"
#include "proto/tessera/v1/farm.pb.h"
#include "renderer/film/film.h"
#include "renderer/film/tile.h"

namespace tessera {

/// Two workers traced the same rows and got different bits. One of them lies or is broken.
struct Mismatch {
  uint32_t tile = 0;
  int row = 0;         ///< the first that differs
  WorkerId first = 0;  ///< whose pixels are in the film
  WorkerId second = 0;
  std::vector<float> first_pixels{}, second_pixels{};  ///< of that row
};

/// What became of a band.
struct BandResult {
  bool valid = false;  ///< false: damaged, not finite, or not of this job's tiles
  bool completed_tile = false;
  bool duplicate_tile = false;  ///< the last band of a tile that was complete already
  std::optional<Mismatch> mismatch;
};

/// Puts bands into the film. The first pixels of a row stay; what comes later, in any order and
/// from any worker, is compared with them bit by bit.
class Assembler {
 public:
  Assembler(const PixelRect& crop, std::vector<PixelRect> tiles, AovSet aovs = {});

  BandResult add(const v1::TileBand& band, WorkerId from);
  /// Whether all rows of the piece that this lease is of are there, and counters of just these.
  bool has_piece(LeaseId lease) const;
  /// Completes a tile that has no pixels yet: each pixel is `value`, each counter as many times
  /// as it has pixels. False where something of it is there.
  bool fill(uint32_t tile, std::span<const float> value, const v1::Counters& of_pixel,
            WorkerId from);
  /// Takes up tiles that were kept, as far as they are sound and of this grid. Returns those that
  /// are complete. `tracer_of` names whose pixels they are; without it nobody knows.
  std::vector<uint32_t> restore(
      const std::vector<FinishedTile>& kept,
      const std::function<WorkerId(uint32_t tile, const FinishedTile&)>& tracer_of = {});
  /// A complete tile as bands whose last has its counters.
  std::vector<v1::TileBand> bands_of(uint32_t tile) const;
  /// Forgets what there is of the tile: the next pixels of its rows are the first again.
  void reopen(uint32_t tile);

  const std::vector<PixelRect>& tiles() const { return tiles_; }
  /// What the film has in that row of the tile.
  std::span<const float> row(uint32_t tile, int row) const;
  bool complete(uint32_t tile) const { return done_by_[tile] != 0; }
  /// Whose pixels completed it; 0: it is not complete.
  WorkerId done_by(uint32_t tile) const { return done_by_[tile]; }
  uint64_t tiles_done() const { return tiles_done_; }
  /// Tiles in the order in which they became complete. One that was reopened stands there for each
  /// time.
  const std::vector<uint32_t>& done_order() const { return done_order_; }
  /// Sums over complete tiles, which stop at the largest number, and what building the scene
  /// counted.
  CounterMap counters() const;
  /// What a worker counted when it built the scene. The first word counts: they are all the same.
  void note_build_counters(const v1::Counters& counters);
  const CounterMap& build_counters() const { return build_counters_; }
  Film& film() { return film_; }
  const Film& film() const { return film_; }
  /// Tiles that are not complete.
  std::vector<PixelRect> holes() const;
  /// Marks them in the film. Call once, at the end.
  void mark_holes();

 private:
  /// A tile with some of its rows.
  struct Partial {
    std::vector<WorkerId> row_from;  ///< 0: not there
    int rows_missing = 0;
    /// By the rows, of the frame, that they are of: the first, and that behind the last.
    std::map<std::pair<int, int>, std::vector<uint64_t>> counts;
  };
  bool plausible(const v1::TileBand& band) const;
  /// The numbers by names_, which grow, but for those that are too long or too many: a report need
  /// not have them all. Of sound bands alone.
  std::vector<uint64_t> counts_of(const v1::Counters& counters);
  /// Counts of all of the tile, out of those of its parts; nothing where some are missing.
  std::optional<std::vector<uint64_t>> counts_of(const Partial& partial,
                                                 const PixelRect& tile) const;
  void complete_tile(uint32_t tile, std::vector<uint64_t> counts, WorkerId from);
  /// Whose pixels are in that row of a complete tile, counted from its first.
  WorkerId owner_of(uint32_t tile, size_t row) const;
  /// Values in a row of the tile.
  size_t row_size(const PixelRect& tile) const;
  /// Where the row of the tile begins among the film's values.
  size_t row_offset(const PixelRect& tile, int row) const;
  /// Whether the film has these very bits in that row.
  bool same_row(uint32_t tile, int row, std::span<const float> values) const;

  std::vector<PixelRect> tiles_;
  std::vector<WorkerId> done_by_;  ///< whose band completed the tile; 0: not complete
  std::unordered_map<uint32_t, Partial> partial_;
  std::unordered_map<uint32_t, std::vector<WorkerId>> mixed_;  ///< complete tiles of several: rows
  Film film_;
  std::vector<float> scratch_;
  std::map<std::string, size_t> names_;        ///< of counters: their places in counts
  std::vector<std::vector<uint64_t>> counts_;  ///< by complete tile
  CounterMap build_counters_;
  uint64_t tiles_done_ = 0;
  std::vector<uint32_t> done_order_;
};

}  // namespace tessera
