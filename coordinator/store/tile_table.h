#pragma once

#include <string>
#include <vector>

#include "coordinator/store/sqlite_database.h"
#include "coordinator/tiles/tile_store.h"

namespace tessera {

/// The table of finished tiles in a database, which must outlive it: as TileStore.
class TileTable {
 public:
  explicit TileTable(SqliteDatabase& database);

  void keep(const Digest& key, const FinishedTile& tile);
  void drop(const Digest& key, const PixelRect& tile);
  void drop_all(const Digest& key);
  /// Tiles of whatever job, and of one.
  uint64_t count();
  uint64_t count(const Digest& key);
  std::vector<FinishedTile> find(const Digest& key);
  /// As JobStore::tiles_traced_by().
  std::vector<StoredTile> traced_by(const std::string& tracer);

 private:
  SqliteDatabase& database_;
};

}  // namespace tessera
