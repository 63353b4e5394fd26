#pragma once

#include <string>
#include <vector>

#include "coordinator/store/sqlite_database.h"
#include "coordinator/tiles/tile_store.h"

namespace tessera {

/// The table of finished tiles in a database, which must outlive it: as TileStore. A tile is bound
/// to its key and its place by a digest over these and its bytes, so that a row that is damaged, or
/// that has come to be another tile's, is never taken for a tile.
class TileTable {
 public:
  explicit TileTable(SqliteDatabase& database);
  /// SqliteDatabase::Kind::upgrade for the table as it was before tiles were bound. Tiles that it
  /// has then stay unbound.
  static std::vector<std::string> upgrade();

  void keep(const Digest& key, const FinishedTile& tile);
  void drop(const Digest& key, const PixelRect& tile);
  /// By several statements that each take little room in the log, even where the disk is full.
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
