#include "coordinator/store/sqlite_tile_store.h"

namespace tessera {
namespace {

constexpr int kTilesApplicationId = 0x54455353;  // "TESS"

}  // namespace

SqliteTileStore::SqliteTileStore(const std::filesystem::path& file)
    : database_(file, {.application_id = kTilesApplicationId,
                       .format = 1,
                       .what = "a file of finished tiles",
                       .fails = "cannot keep finished tiles"}),
      tiles_(database_) {}

uint64_t SqliteTileStore::end() {
  for (const Digest& job : asked_for_) tiles_.drop_all(job);
  const uint64_t others = tiles_.count();
  if (others == 0) database_.remove();
  return others;
}

}  // namespace tessera
