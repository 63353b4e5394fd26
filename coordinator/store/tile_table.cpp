#include "coordinator/store/tile_table.h"

#include <algorithm>
#include <string>
#include <utility>

#include "proto/wire/kept.h"

namespace tessera {

using Statement = SqliteDatabase::Statement;

namespace {

Statement& bind_rect(Statement& statement, const PixelRect& rect) {
  for (const int value : {rect.x0, rect.y0, rect.x1, rect.y1}) statement.bind(int64_t{value});
  return statement;
}

}  // namespace

TileTable::TileTable(SqliteDatabase& database) : database_(database) {
  database_.execute(
      "CREATE TABLE IF NOT EXISTS tiles (job TEXT, x0 INT, y0 INT, x1 INT, y1 INT, "
      "kept BLOB, PRIMARY KEY (job, x0, y0, x1, y1))");
}

void TileTable::keep(const Digest& key, const FinishedTile& tile) {
  const std::string hex = key.hex(), kept = tile.kept.SerializeAsString();
  Statement statement(database_, "INSERT OR REPLACE INTO tiles VALUES (?, ?, ?, ?, ?, ?)");
  bind_rect(statement.bind(hex), tile.rect).bind_blob(kept).step();
}

void TileTable::drop(const Digest& key, const PixelRect& tile) {
  const std::string hex = key.hex();
  Statement statement(
      database_, "DELETE FROM tiles WHERE job = ? AND x0 = ? AND y0 = ? AND x1 = ? AND y1 = ?");
  bind_rect(statement.bind(hex), tile).step();
}

void TileTable::drop_all(const Digest& key) {
  const std::string hex = key.hex();
  Statement(database_, "DELETE FROM tiles WHERE job = ?").bind(hex).step();
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
  Statement rows(database_, "SELECT x0, y0, x1, y1, kept FROM tiles WHERE job = ? ORDER BY rowid");
  rows.bind(hex);
  std::vector<FinishedTile> tiles;
  while (rows.step()) {
    const auto side = [&rows](int column) { return static_cast<int>(rows.integer(column)); };
    FinishedTile tile{{side(0), side(1), side(2), side(3)}, {}};
    auto kept = parse_kept_tile(rows.blob(4));
    if (!kept) continue;
    tile.kept = std::move(*kept);
    tiles.push_back(std::move(tile));
  }
  return tiles;
}

std::vector<StoredTile> TileTable::traced_by(const std::string& tracer) {
  Statement rows(database_, "SELECT x0, y0, x1, y1, kept, job FROM tiles");
  std::vector<StoredTile> found;
  while (rows.step()) {
    const auto kept = parse_kept_tile(rows.blob(4));
    if (!kept || std::ranges::find(kept->tracers(), tracer) == kept->tracers().end()) continue;
    const auto side = [&rows](int column) { return static_cast<int>(rows.integer(column)); };
    found.push_back(
        {Digest::from_hex(std::string(rows.blob(5))), {side(0), side(1), side(2), side(3)}});
  }
  return found;
}

}  // namespace tessera
