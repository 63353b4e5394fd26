#include "coordinator/store/tile_table.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "base/plural.h"
#include "proto/wire/kept.h"

namespace tessera {

using Statement = SqliteDatabase::Statement;

namespace {

/// So many that deleting tiles of any usual size touches less than the log has room for.
constexpr const char* kDropSome =
    "DELETE FROM tiles WHERE rowid IN (SELECT rowid FROM tiles WHERE job = ? LIMIT 64)";

Statement& bind_rect(Statement& statement, const PixelRect& rect) {
  for (const int value : {rect.x0, rect.y0, rect.x1, rect.y1}) statement.bind(int64_t{value});
  return statement;
}

PixelRect rect_at(const Statement& row, int column) {
  const auto side = [&](int i) { return static_cast<int>(row.integer(column + i)); };
  return {side(0), side(1), side(2), side(3)};
}

/// What binds the bytes of a tile to its key and its place.
Digest seal_of(const Digest& key, const PixelRect& rect, std::string_view kept) {
  const std::string place =
      fmt::format("{} {} {} {} {} ", key.hex(), rect.x0, rect.y0, rect.x1, rect.y1);
  DigestStream stream;
  stream.add(std::as_bytes(std::span(place)));
  stream.add(std::as_bytes(std::span(kept)));
  return stream.finish();
}

std::string_view bytes_of(const Digest& digest) {
  return {reinterpret_cast<const char*>(digest.bytes.data()), digest.bytes.size()};
}

}  // namespace

TileTable::TileTable(SqliteDatabase& database) : database_(database) {
  database_.execute(
      "CREATE TABLE IF NOT EXISTS tiles (job TEXT, x0 INT, y0 INT, x1 INT, y1 INT, "
      "kept BLOB, seal BLOB, tracers TEXT, PRIMARY KEY (job, x0, y0, x1, y1))");
  // Tiles are looked for by it alone: their own bytes are not read for that.
  database_.execute(
      "CREATE INDEX IF NOT EXISTS tiles_by_tracers ON tiles (tracers) WHERE tracers IS NOT NULL");
}

std::vector<std::string> TileTable::upgrade() {
  return {"ALTER TABLE tiles ADD COLUMN seal BLOB", "ALTER TABLE tiles ADD COLUMN tracers TEXT"};
}

void TileTable::keep(const Digest& key, const FinishedTile& tile) {
  const std::string hex = key.hex(), kept = tile.kept.SerializeAsString();
  const Digest seal = seal_of(key, tile.rect, kept);
  const std::string tracers = fmt::format("{}", fmt::join(tile.kept.tracers(), " "));
  Statement statement(database_,
                      "INSERT OR REPLACE INTO tiles (job, x0, y0, x1, y1, kept, seal, tracers) "
                      "VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
  bind_rect(statement.bind(hex), tile.rect).bind_blob(kept).bind_blob(bytes_of(seal));
  if (tracers.empty()) {
    statement.bind_null();
  } else {
    statement.bind(std::string_view(tracers));
  }
  statement.step();
}

void TileTable::drop(const Digest& key, const PixelRect& tile) {
  const std::string hex = key.hex();
  Statement statement(
      database_, "DELETE FROM tiles WHERE job = ? AND x0 = ? AND y0 = ? AND x1 = ? AND y1 = ?");
  bind_rect(statement.bind(hex), tile).step();
}

void TileTable::drop_all(const Digest& key) {
  const std::string hex = key.hex();
  do {
    Statement(database_, kDropSome).bind(hex).step();
  } while (database_.changes() > 0);
}

uint64_t TileTable::count() {
  Statement rows(database_, "SELECT count(*) FROM tiles");
  rows.step();
  return static_cast<uint64_t>(rows.integer(0));
}

uint64_t TileTable::count(const Digest& key) {
  const std::string hex = key.hex();
  Statement rows(database_, "SELECT count(*) FROM tiles WHERE job = ?");
  rows.bind(hex).step();
  return static_cast<uint64_t>(rows.integer(0));
}

std::vector<FinishedTile> TileTable::find(const Digest& key) {
  const std::string hex = key.hex();
  std::vector<FinishedTile> tiles;
  std::vector<PixelRect> damaged;
  {
    Statement rows(database_,
                   "SELECT x0, y0, x1, y1, kept, seal FROM tiles WHERE job = ? ORDER BY rowid");
    rows.bind(hex);
    while (rows.step()) {
      const PixelRect rect = rect_at(rows, 0);
      auto kept = parse_kept_tile(rows.blob(4));
      const bool bound = rows.is_null(5) ||  // by a version that bound none
                         rows.blob(5) == bytes_of(seal_of(key, rect, rows.blob(4)));
      if (kept && bound) {
        tiles.push_back({rect, std::move(*kept)});
      } else {
        damaged.push_back(rect);
      }
    }
  }
  if (damaged.empty()) return tiles;
  spdlog::warn("{} under {} {} damaged, or not of that place: dropped, to be traced again",
               counted(damaged.size(), "stored tile"), hex, damaged.size() == 1 ? "is" : "are");
  try {
    for (const PixelRect& rect : damaged) drop(key, rect);
  } catch (const Error&) {
    // On a full disk, say. They are found again another time.
  }
  return tiles;
}

std::vector<StoredTile> TileTable::traced_by(const std::string& tracer) {
  Statement rows(database_,
                 "SELECT x0, y0, x1, y1, job FROM tiles WHERE rowid IN "
                 "(SELECT rowid FROM tiles WHERE tracers IS NOT NULL AND instr(tracers, ?))");
  rows.bind(std::string_view(tracer));
  std::vector<StoredTile> found;
  while (rows.step()) {
    found.push_back({Digest::from_hex(std::string(rows.blob(4))), rect_at(rows, 0)});
  }
  return found;
}

}  // namespace tessera
