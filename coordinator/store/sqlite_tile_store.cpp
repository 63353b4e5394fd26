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

}  // namespace tessera
