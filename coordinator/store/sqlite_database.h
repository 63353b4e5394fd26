#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

struct sqlite3;
struct sqlite3_stmt;

namespace tessera {

/// An open SQLite file, with write-ahead log, for one process at a time. What a statement has
/// written survives the end of this process at any instant; after Flushed also a power cut.
class SqliteDatabase {
 public:
  /// What tells our files apart, and from other programs'.
  struct Kind {
    int application_id = 0;
    int format = 1;
    /// Statements that make a file of this format out of one of the format before: all of them take
    /// effect or none.
    std::vector<std::string> upgrade{};
    bool must_exist = false;  ///< one that is missing, empty or without tables is refused
    std::string what;         ///< "a file of finished tiles"
    std::string fails;        ///< "cannot keep finished tiles"
    /// What to do about a file that is damaged or missing.
    std::string remedy = "move it away, or restore a copy";
  };
  /// Opens the file or makes it. Throws temporary_error where that may do later: another process
  /// has used it for five seconds, or the disk is full. Throws usage_error where it cannot be used,
  /// is damaged or is something else.
  SqliteDatabase(const std::filesystem::path& file, Kind kind);
  SqliteDatabase(const SqliteDatabase&) = delete;
  SqliteDatabase& operator=(const SqliteDatabase&) = delete;
  ~SqliteDatabase();

  /// A prepared statement, with its values bound and its rows stepped through. Where SQLite fails
  /// it throws temporary_error if that may pass, as a full disk does, or else render_error.
  class Statement {
   public:
    Statement(const SqliteDatabase& database, const char* text);
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;
    ~Statement();
    /// Text and blobs must outlive the steps.
    Statement& bind(std::string_view text);
    Statement& bind_blob(std::string_view bytes);
    Statement& bind(int64_t value);
    Statement& bind_null();
    /// Whether there is a further row.
    bool step();
    int64_t integer(int column) const;
    std::string_view blob(int column) const;
    bool is_null(int column) const;

   private:
    [[noreturn]] void fail() const;
    void check(int code) const;
    const SqliteDatabase& database_;
    sqlite3_stmt* statement_ = nullptr;
    int bound_ = 0;
  };

  /// Runs statements without values or rows.
  void execute(const std::string& text);
  /// While it lives, what is written is synced at once.
  class Flushed {
   public:
    explicit Flushed(SqliteDatabase& database);
    ~Flushed();
    Flushed(const Flushed&) = delete;
    Flushed& operator=(const Flushed&) = delete;

   private:
    SqliteDatabase& database_;
  };

  /// What is executed while it lives takes effect with commit(), or not at all.
  class Transaction {
   public:
    explicit Transaction(SqliteDatabase& database);
    ~Transaction();
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;
    void commit();

   private:
    SqliteDatabase& database_;
    bool open_ = true;
  };

  /// Moves what the write-ahead log has into the database, so that the log is written again from
  /// its beginning: in the room that its file has, or, if `truncate`, from an empty file.
  void checkpoint(bool truncate);
  /// Gives up to so many pages that are not used any more back to the file system, at the next
  /// checkpoint. Returns whether there may be more of them.
  bool give_back(int pages);
  /// How many rows the last INSERT, UPDATE or DELETE wrote or deleted.
  int64_t changes() const;

  void close();
  /// Closes and deletes the file: nothing in it is needed any more.
  void remove();

 private:
  void open_patiently();
  void open();
  void upgrade(int64_t from);
  /// Errors for a file that has lost something, and for one that is something else.
  Error not_whole(const std::string& what) const;
  Error no_such_kind(const std::string& what) const;
  /// Whether the condition that made the last call fail passes by itself.
  bool may_pass() const;
  /// What SQLite finds wrong with the whole file, which it reads for that; empty: nothing.
  std::string find_damage() const;

  std::filesystem::path file_;
  Kind kind_;
  sqlite3* database_ = nullptr;
};

}  // namespace tessera
