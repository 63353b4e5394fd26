#include "coordinator/store/sqlite_tile_store.h"

namespace tessera {
namespace {

constexpr int kTilesApplicationId = 0x54455353;  // "TESS"

}  // namespace

SqliteTileStore::SqliteTileStore(const std::filesystem::path& file)
    : database_(file, {.application_id = kTilesApplicationId,
                       .format = 2,
                       .upgrade = TileTable::upgrade(),
                       .what = "a file of finished tiles",
                       .fails = "cannot keep finished tiles"}),
      tiles_(database_) {}

uint64_t SqliteTileStore::end() {
  uint64_t others = tiles_.count();
  for (const Digest& key : asked_for_) others -= tiles_.count(key);
  // Deleting rows takes time and room; a file goes at once.
  if (others == 0) return database_.remove(), others;
  for (const Digest& key : asked_for_) tiles_.drop_all(key);
  return others;
}

}  // namespace tessera
