#pragma once

#include <cstdint>
#include <filesystem>
#include <set>

#include "coordinator/store/sqlite_database.h"
#include "coordinator/store/tile_table.h"
#include "coordinator/tiles/tile_store.h"

namespace tessera {

/// Finished tiles in a SQLite file of their own: what keep() has returned from survives the end of
/// this process at any instant, and a file is never half written. One process at a time.
class SqliteTileStore : public TileStore {
 public:
  /// Opens the file or makes it, as SqliteDatabase does.
  explicit SqliteTileStore(const std::filesystem::path& file);

  void keep(const Digest& key, const FinishedTile& tile) override { tiles_.keep(key, tile); }
  void drop(const Digest& key, const PixelRect& tile) override { tiles_.drop(key, tile); }
  void drop_all(const Digest& key) override { tiles_.drop_all(key); }
  std::vector<FinishedTile> find(const Digest& key) override {
    asked_for_.insert(key);
    return tiles_.find(key);
  }

  /// Nothing of the jobs that were asked for is needed any more: closes and deletes the file,
  /// unless tiles of others are in it. Returns how many.
  uint64_t end();

 private:
  std::set<Digest> asked_for_;
  SqliteDatabase database_;
  TileTable tiles_;
};

}  // namespace tessera
