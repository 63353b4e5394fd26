#include "coordinator/store/sqlite_tile_store.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <system_error>

#include "base/error.h"
#include "proto/wire/pixels.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// "TESS": tells our files from other SQLite databases.
constexpr int kApplicationId = 0x54455353;
constexpr int kFormat = 1;

}  // namespace

/// A prepared statement, with its values bound and its rows stepped through.
class SqliteTileStore::Statement {
 public:
  Statement(const SqliteTileStore& store, const char* text) : store_(store) {
    check(sqlite3_prepare_v2(store.database_, text, -1, &statement_, nullptr));
  }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;
  ~Statement() { sqlite3_finalize(statement_); }

  Statement& bind(std::string_view text) {
    check(sqlite3_bind_text64(statement_, ++bound_, text.data(), text.size(), SQLITE_STATIC,
                              SQLITE_UTF8));
    return *this;
  }
  Statement& bind_blob(std::string_view bytes) {
    check(sqlite3_bind_blob64(statement_, ++bound_, bytes.data(), bytes.size(), SQLITE_STATIC));
    return *this;
  }
  Statement& bind(const PixelRect& rect) {
    for (const int value : {rect.x0, rect.y0, rect.x1, rect.y1}) {
      check(sqlite3_bind_int(statement_, ++bound_, value));
    }
    return *this;
  }
  /// Whether there is a further row.
  bool step() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) fail();
    return code == SQLITE_ROW;
  }
  int integer(int column) const { return sqlite3_column_int(statement_, column); }
  std::string_view blob(int column) const {
    const void* bytes = sqlite3_column_blob(statement_, column);
    return {static_cast<const char*>(bytes),
            static_cast<size_t>(sqlite3_column_bytes(statement_, column))};
  }

 private:
  [[noreturn]] void fail() const {
    throw render_error(fmt::format("'{}' cannot keep finished tiles: {}", store_.file_.string(),
                                   sqlite3_errmsg(store_.database_)));
  }
  void check(int code) const {
    if (code != SQLITE_OK) fail();
  }

  const SqliteTileStore& store_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

SqliteTileStore::SqliteTileStore(const fs::path& file) : file_(file) {
  try {
    if (sqlite3_open(file.c_str(), &database_) != SQLITE_OK) {
      throw render_error(sqlite3_errmsg(database_));
    }
    // In WAL mode, NORMAL syncs at checkpoints only: a power cut may take the last tiles back, the
    // end of a process none.
    for (const char* pragma : {"PRAGMA locking_mode = EXCLUSIVE", "PRAGMA journal_mode = WAL",
                               "PRAGMA synchronous = NORMAL"}) {
      Statement(*this, pragma).step();
    }
    Statement id(*this, "PRAGMA application_id");
    id.step();
    Statement tables(*this, "SELECT count(*) FROM sqlite_master");
    tables.step();
    if (id.integer(0) != kApplicationId && tables.integer(0) > 0) {
      throw render_error("it is another program's database");
    }
    Statement format(*this, "PRAGMA user_version");
    format.step();
    if (format.integer(0) != kFormat && tables.integer(0) > 0) {
      throw render_error("it is of another version");
    }
  } catch (const Error& error) {
    close();
    throw usage_error(fmt::format("'{}': {}; expected a file of finished tiles, or none",
                                  file.string(), error.what()));
  }
  Statement(*this, fmt::format("PRAGMA application_id = {}", kApplicationId).c_str()).step();
  Statement(*this, fmt::format("PRAGMA user_version = {}", kFormat).c_str()).step();
  Statement(*this,
            "CREATE TABLE IF NOT EXISTS tiles (job TEXT, x0 INT, y0 INT, x1 INT, y1 INT, "
            "kept BLOB, PRIMARY KEY (job, x0, y0, x1, y1))")
      .step();
}

SqliteTileStore::~SqliteTileStore() { close(); }

void SqliteTileStore::close() {
  sqlite3_close(database_);
  database_ = nullptr;
}

void SqliteTileStore::keep(const Digest& job, const FinishedTile& tile) {
  const std::string hex = job.hex(), kept = tile.kept.SerializeAsString();
  Statement(*this, "INSERT OR REPLACE INTO tiles VALUES (?, ?, ?, ?, ?, ?)")
      .bind(hex)
      .bind(tile.rect)
      .bind_blob(kept)
      .step();
}

void SqliteTileStore::drop(const Digest& job, const PixelRect& tile) {
  const std::string hex = job.hex();
  Statement(*this, "DELETE FROM tiles WHERE job = ? AND x0 = ? AND y0 = ? AND x1 = ? AND y1 = ?")
      .bind(hex)
      .bind(tile)
      .step();
}

std::vector<FinishedTile> SqliteTileStore::find(const Digest& job) {
  const std::string hex = job.hex();
  Statement rows(*this, "SELECT x0, y0, x1, y1, kept FROM tiles WHERE job = ? ORDER BY rowid");
  rows.bind(hex);
  std::vector<FinishedTile> tiles;
  while (rows.step()) {
    FinishedTile tile{{rows.integer(0), rows.integer(1), rows.integer(2), rows.integer(3)}, {}};
    const std::string_view bytes = rows.blob(4);
    auto kept = parse_kept_tile(bytes);
    if (!kept) continue;
    tile.kept = std::move(*kept);
    tiles.push_back(std::move(tile));
  }
  return tiles;
}

void SqliteTileStore::remove() {
  close();
  for (const char* ending : {"", "-wal", "-shm"}) {
    std::error_code ignored;
    fs::remove(file_.string() + ending, ignored);
  }
}

}  // namespace tessera
