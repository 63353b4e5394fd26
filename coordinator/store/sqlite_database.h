#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

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
    std::string what;   ///< "a file of finished tiles"
    std::string fails;  ///< "cannot keep finished tiles"
  };
  /// Opens the file or makes it. Throws usage_error where it cannot be used, another process uses
  /// it, or it is something else.
  SqliteDatabase(const std::filesystem::path& file, Kind kind);
  SqliteDatabase(const SqliteDatabase&) = delete;
  SqliteDatabase& operator=(const SqliteDatabase&) = delete;
  ~SqliteDatabase();

  /// A prepared statement, with its values bound and its rows stepped through. Throws render_error
  /// where SQLite fails: a full disk, say.
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
    /// Whether there is a further row.
    bool step();
    int64_t integer(int column) const;
    std::string_view blob(int column) const;

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

  void close();
  /// Closes and deletes the file: nothing in it is needed any more.
  void remove();

 private:
  void open();
  /// What SQLite finds wrong with the whole file, which it reads for that; empty: nothing.
  std::string find_damage() const;

  std::filesystem::path file_;
  Kind kind_;
  sqlite3* database_ = nullptr;
};

}  // namespace tessera
