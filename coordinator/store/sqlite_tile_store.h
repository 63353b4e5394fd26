#pragma once

#include <filesystem>
#include <memory>

#include "coordinator/tile_store.h"

struct sqlite3;
struct sqlite3_stmt;

namespace tessera {

/// Finished tiles in a SQLite file, with write-ahead log: what keep() has returned from survives
/// the end of this process at any instant, and a file is never half written. One process at a time.
class SqliteTileStore : public TileStore {
 public:
  /// Opens the file or makes it. Throws usage_error where it cannot be used, another process uses
  /// it, or it is something else.
  explicit SqliteTileStore(const std::filesystem::path& file);
  SqliteTileStore(const SqliteTileStore&) = delete;
  SqliteTileStore& operator=(const SqliteTileStore&) = delete;
  ~SqliteTileStore() override;

  void keep(const Digest& job, const FinishedTile& tile) override;
  void drop(const Digest& job, const PixelRect& tile) override;
  std::vector<FinishedTile> find(const Digest& job) override;

  /// Closes and deletes the file: nothing in it is needed any more.
  void remove();

 private:
  class Statement;
  void close();

  std::filesystem::path file_;
  sqlite3* database_ = nullptr;
};

}  // namespace tessera
