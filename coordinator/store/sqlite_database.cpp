#include "coordinator/store/sqlite_database.h"

#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <system_error>
#include <thread>
#include <utility>

#include "base/descriptors.h"
#include "base/error.h"
#include "base/monotonic.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

/// How long the file is waited for while another process uses it: a program that copies it, say.
constexpr std::chrono::seconds kPatience{5};
/// The log keeps its file, and with it room on a full disk, up to this size.
constexpr int kLogBytes = 8 << 20;

}  // namespace

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

SqliteDatabase::Statement& SqliteDatabase::Statement::bind_null() {
  check(sqlite3_bind_null(statement_, ++bound_));
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

bool SqliteDatabase::Statement::is_null(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}

void SqliteDatabase::Statement::fail() const {
  const int cause = sqlite3_system_errno(database_.database_);
  const std::string what =
      fmt::format("'{}' {}: {}{}", database_.file_.string(), database_.kind_.fails,
                  sqlite3_errmsg(database_.database_),
                  cause == 0 ? "" : fmt::format(" ({})", std::strerror(cause)));
  if (database_.may_pass()) throw temporary_error(what);
  throw render_error(what);
}

void SqliteDatabase::Statement::check(int code) const {
  if (code != SQLITE_OK) fail();
}

SqliteDatabase::SqliteDatabase(const fs::path& file, Kind kind)
    : file_(file), kind_(std::move(kind)) {
  std::string damage;
  try {
    open_patiently();
    damage = find_damage();
    if (damage.empty()) return;
  } catch (const Error&) {
    const int code = database_ ? sqlite3_errcode(database_) & 0xff : SQLITE_OK;
    const bool ours = code == SQLITE_OK || code == SQLITE_ROW || code == SQLITE_DONE;
    const std::string what = ours ? "" : sqlite3_errmsg(database_);
    const bool passes = !ours && may_pass();
    close();
    if (code == SQLITE_BUSY) {
      throw temporary_error(
          fmt::format("'{}': another process uses it, a coordinator or a program that copies it; "
                      "expected it to be free within {} s",
                      file.string(), kPatience.count()));
    }
    if (passes || ours) throw;
    if (code != SQLITE_CORRUPT && code != SQLITE_NOTADB) throw no_such_kind(what);
    damage = what;
  }
  close();
  throw not_whole("damaged: " + damage);
}

Error SqliteDatabase::not_whole(const std::string& what) const {
  return usage_error(fmt::format("'{}' is {}; expected {} as it was written: {}", file_.string(),
                                 what, kind_.what, kind_.remedy));
}

Error SqliteDatabase::no_such_kind(const std::string& what) const {
  return usage_error(
      fmt::format("'{}': {}; expected {}, or none", file_.string(), what, kind_.what));
}

bool SqliteDatabase::may_pass() const {
  const int cause = sqlite3_system_errno(database_);
  switch (sqlite3_errcode(database_) & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_FULL:
    case SQLITE_NOMEM:
      return true;
    // Who is not allowed to write the file will not be allowed to later.
    case SQLITE_IOERR:
      return cause != EACCES && cause != EPERM && cause != EROFS;
    case SQLITE_CANTOPEN:
      return cause == EMFILE || cause == ENFILE || cause == ENOMEM;
    default:
      return false;
  }
}

void SqliteDatabase::open_patiently() {
  for (const Time until = monotonic_now() + kPatience;;) {
    try {
      return open();
    } catch (const Error&) {
      const bool busy = database_ && (sqlite3_errcode(database_) & 0xff) == SQLITE_BUSY;
      if (!busy || monotonic_now() >= until) throw;
    }
    close();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
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
  const SpareDescriptors spare;
  std::error_code failure;
  const uintmax_t bytes = fs::file_size(file_, failure);
  // SQLite would make it, and delete the log that may have all of it.
  if (kind_.must_exist &&
      (failure ? failure == std::errc::no_such_file_or_directory : bytes == 0)) {
    throw not_whole(failure ? "missing" : "empty");
  }
  // SQLite would open it all the same, and say of the log that it is a bad descriptor.
  if (!failure && ::access(file_.c_str(), W_OK) != 0) throw no_such_kind(std::strerror(errno));
  if (sqlite3_open(file_.c_str(), &database_) != SQLITE_OK) {
    throw render_error(sqlite3_errmsg(database_));
  }
  // It would be written to a database that is there already, to no effect.
  if (failure || bytes == 0) execute("PRAGMA auto_vacuum = INCREMENTAL");
  // In WAL mode, NORMAL syncs at checkpoints only: a power cut may take the last writes back, the
  // end of a process none.
  for (const char* pragma : {"PRAGMA locking_mode = EXCLUSIVE", "PRAGMA journal_mode = WAL",
                             "PRAGMA synchronous = NORMAL"}) {
    execute(pragma);
  }
  // Zeroes over what is deleted would all be written to the log first.
  execute("PRAGMA secure_delete = OFF");
  execute(fmt::format("PRAGMA journal_size_limit = {}", kLogBytes));
  Statement id(*this, "PRAGMA application_id");
  id.step();
  Statement tables(*this, "SELECT count(*) FROM sqlite_master");
  tables.step();
  const bool used = tables.integer(0) > 0;
  if (id.integer(0) != kind_.application_id && used) {
    throw no_such_kind("it is another program's database");
  }
  if (!used && kind_.must_exist) throw not_whole("empty");
  Statement format(*this, "PRAGMA user_version");
  format.step();
  if (used) return upgrade(format.integer(0));
  execute(fmt::format("PRAGMA application_id = {}", kind_.application_id));
  execute(fmt::format("PRAGMA user_version = {}", kind_.format));
}

void SqliteDatabase::upgrade(int64_t from) {
  if (from == kind_.format) return;
  if (from + 1 != kind_.format || kind_.upgrade.empty()) {
    throw no_such_kind(
        fmt::format("it is of format {}, of {} version of this program, which reads "
                    "format {}",
                    from, from > kind_.format ? "a later" : "an earlier", kind_.format));
  }
  Transaction transaction(*this);
  for (const std::string& statement : kind_.upgrade) execute(statement);
  execute(fmt::format("PRAGMA user_version = {}", kind_.format));
  transaction.commit();
}

SqliteDatabase::~SqliteDatabase() { close(); }

void SqliteDatabase::execute(const std::string& text) {
  Statement statement(*this, text.c_str());
  while (statement.step()) {
  }
}

SqliteDatabase::Transaction::Transaction(SqliteDatabase& database) : database_(database) {
  database_.execute("BEGIN IMMEDIATE");
}

SqliteDatabase::Transaction::~Transaction() {
  if (open_) sqlite3_exec(database_.database_, "ROLLBACK", nullptr, nullptr, nullptr);
}

void SqliteDatabase::Transaction::commit() {
  database_.execute("COMMIT");
  open_ = false;
}

void SqliteDatabase::checkpoint(bool truncate) {
  execute(truncate ? "PRAGMA wal_checkpoint(TRUNCATE)" : "PRAGMA wal_checkpoint(RESTART)");
}

bool SqliteDatabase::give_back(int pages) {
  // Neither is open when the vacuum ends: SQLite would not write the log anew then.
  const auto value = [this](const char* pragma) {
    Statement row(*this, pragma);
    return row.step() ? row.integer(0) : 0;
  };
  // A database of an earlier format gives nothing back.
  constexpr int kIncremental = 2;
  if (value("PRAGMA auto_vacuum") != kIncremental || value("PRAGMA freelist_count") == 0) {
    return false;
  }
  execute(fmt::format("PRAGMA incremental_vacuum({})", pages));
  return true;
}

int64_t SqliteDatabase::changes() const { return sqlite3_changes64(database_); }

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
