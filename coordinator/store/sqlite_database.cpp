#include "coordinator/store/sqlite_database.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <system_error>
#include <utility>

#include "base/error.h"

namespace tessera {

namespace fs = std::filesystem;

SqliteDatabase::Statement::Statement(const SqliteDatabase& database, const char* text)
    : database_(database) {
  check(sqlite3_prepare_v2(database_.database_, text, -1, &statement_, nullptr));
}

SqliteDatabase::Statement::~Statement() { sqlite3_finalize(statement_); }

SqliteDatabase::Statement& SqliteDatabase::Statement::bind(std::string_view text) {
  check(sqlite3_bind_text64(statement_, ++bound_, text.data(), text.size(), SQLITE_STATIC,
                            SQLITE_UTF8));
  return *this;
}

SqliteDatabase::Statement& SqliteDatabase::Statement::bind_blob(std::string_view bytes) {
  check(sqlite3_bind_blob64(statement_, ++bound_, bytes.data(), bytes.size(), SQLITE_STATIC));
  return *this;
}

SqliteDatabase::Statement& SqliteDatabase::Statement::bind(int64_t value) {
  check(sqlite3_bind_int64(statement_, ++bound_, value));
  return *this;
}

bool SqliteDatabase::Statement::step() {
  const int code = sqlite3_step(statement_);
  if (code != SQLITE_ROW && code != SQLITE_DONE) fail();
  return code == SQLITE_ROW;
}

int64_t SqliteDatabase::Statement::integer(int column) const {
  return sqlite3_column_int64(statement_, column);
}

std::string_view SqliteDatabase::Statement::blob(int column) const {
  const void* bytes = sqlite3_column_blob(statement_, column);
  return {static_cast<const char*>(bytes),
          static_cast<size_t>(sqlite3_column_bytes(statement_, column))};
}

void SqliteDatabase::Statement::fail() const {
  throw render_error(fmt::format("'{}' {}: {}", database_.file_.string(), database_.kind_.fails,
                                 sqlite3_errmsg(database_.database_)));
}

void SqliteDatabase::Statement::check(int code) const {
  if (code != SQLITE_OK) fail();
}

SqliteDatabase::SqliteDatabase(const fs::path& file, Kind kind)
    : file_(file), kind_(std::move(kind)) {
  std::string damage;
  try {
    open();
    damage = find_damage();
    if (damage.empty()) return;
  } catch (const Error& error) {
    const int code = database_ ? sqlite3_errcode(database_) & 0xff : SQLITE_NOMEM;
    const bool ours = code == SQLITE_OK || code == SQLITE_ROW || code == SQLITE_DONE;
    const std::string what = ours                  ? error.what()
                             : code == SQLITE_BUSY ? "another process uses it"
                                                   : sqlite3_errmsg(database_);
    close();
    // Nothing is wrong with what was asked for: another time it will do.
    if (code == SQLITE_FULL || code == SQLITE_IOERR || code == SQLITE_NOMEM) throw;
    if (code != SQLITE_CORRUPT && code != SQLITE_NOTADB) {
      throw usage_error(
          fmt::format("'{}': {}; expected {}, or none", file.string(), what, kind_.what));
    }
    damage = what;
  }
  close();
  throw usage_error(
      fmt::format("'{}' is damaged: {}; expected {} as it was written: move it away, or restore a "
                  "copy",
                  file.string(), damage, kind_.what));
}

std::string SqliteDatabase::find_damage() const {
  Statement check(*this, "PRAGMA quick_check(1)");
  std::string found = check.step() ? std::string(check.blob(0)) : "it cannot be checked";
  if (found == "ok") return "";
  for (char& c : found) {
    if (c == '\n') c = ' ';
  }
  return found;
}

void SqliteDatabase::open() {
  if (sqlite3_open(file_.c_str(), &database_) != SQLITE_OK) {
    throw render_error(sqlite3_errmsg(database_));
  }
  // In WAL mode, NORMAL syncs at checkpoints only: a power cut may take the last writes back, the
  // end of a process none.
  for (const char* pragma : {"PRAGMA locking_mode = EXCLUSIVE", "PRAGMA journal_mode = WAL",
                             "PRAGMA synchronous = NORMAL"}) {
    Statement(*this, pragma).step();
  }
  Statement id(*this, "PRAGMA application_id");
  id.step();
  Statement tables(*this, "SELECT count(*) FROM sqlite_master");
  tables.step();
  const bool used = tables.integer(0) > 0;
  if (id.integer(0) != kind_.application_id && used) {
    throw render_error("it is another program's database");
  }
  Statement format(*this, "PRAGMA user_version");
  format.step();
  if (format.integer(0) != kind_.format && used) throw render_error("it is of another version");
  if (used) return;
  execute(fmt::format("PRAGMA application_id = {}", kind_.application_id));
  execute(fmt::format("PRAGMA user_version = {}", kind_.format));
}

SqliteDatabase::~SqliteDatabase() { close(); }

void SqliteDatabase::execute(const std::string& text) { Statement(*this, text.c_str()).step(); }

SqliteDatabase::Flushed::Flushed(SqliteDatabase& database) : database_(database) {
  database_.execute("PRAGMA synchronous = FULL");
}

SqliteDatabase::Flushed::~Flushed() {
  try {
    database_.execute("PRAGMA synchronous = NORMAL");
  } catch (const Error&) {
    // Then all that follows is synced at once too.
  }
}

void SqliteDatabase::close() {
  sqlite3_close(database_);
  database_ = nullptr;
}

void SqliteDatabase::remove() {
  close();
  for (const char* ending : {"", "-wal", "-shm"}) {
    std::error_code ignored;
    fs::remove(file_.string() + ending, ignored);
  }
}

}  // namespace tessera
