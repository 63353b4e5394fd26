#include "coordinator/store/sqlite_tile_store.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "tests/file_size_limit.h"
#include "tests/temporary_folder.h"
#include "tests/unit/coordinator/store/changed_database.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

class TileStoreTest : public testing::Test {
 protected:
  static FinishedTile tile(int x, const std::string& pixels) {
    FinishedTile tile{{x, 0, x + 16, 16}, {}};
    tile.kept.set_tile_size(16);
    tile.kept.add_bands()->set_pixels(pixels);
    return tile;
  }
  static ExitCode code_of_opening(const fs::path& file) {
    try {
      const SqliteTileStore store(file);
    } catch (const Error& error) {
      return error.code();
    }
    return ExitCode::done;
  }

  const TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path(), file_ = folder_ / "a.tiles";
  const Digest job_ = Digest::of("a job"), other_ = Digest::of("another");
};

TEST_F(TileStoreTest, FindsWhatAnEarlierOneKept) {
  {
    SqliteTileStore store(file_);
    store.keep(job_, tile(0, "one"));
    store.keep(job_, tile(16, "two"));
    store.keep(other_, tile(0, "other"));
    store.keep(job_, tile(0, std::string("new\0er", 6)));
    store.drop(job_, tile(16, {}).rect);
    store.drop(job_, tile(32, {}).rect);
  }
  SqliteTileStore store(file_);
  const auto found = store.find(job_);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].rect, tile(0, {}).rect);
  EXPECT_EQ(found[0].kept.tile_size(), 16u);
  EXPECT_EQ(found[0].kept.bands(0).pixels(), std::string("new\0er", 6));
  EXPECT_EQ(store.find(other_).size(), 1u);
  EXPECT_TRUE(store.find(Digest::of("a third")).empty());
}

TEST_F(TileStoreTest, LeavesNothingOfTheJobsThatWereAskedFor) {
  {
    SqliteTileStore store(file_);
    store.keep(other_, tile(0, "another's"));
    store.keep(other_, tile(32, "another's"));
  }
  {
    SqliteTileStore store(file_);
    EXPECT_TRUE(store.find(job_).empty());
    store.keep(job_, tile(0, "one"));
    EXPECT_EQ(store.end(), 2u);
    EXPECT_FALSE(fs::is_empty(folder_));
  }
  SqliteTileStore store(file_);
  EXPECT_TRUE(store.find(job_).empty());
  EXPECT_EQ(store.find(other_).size(), 2u);
  EXPECT_EQ(store.end(), 0u);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(TileStoreTest, IsForOneProcessAtATime) {
  const SqliteTileStore store(file_);
  EXPECT_EQ(code_of_opening(file_), ExitCode::try_again);
}

TEST_F(TileStoreTest, WhereTheDiskTakesNothingTheCommandLineIsNotWrong) {
  const FileSizeLimit small(100);
  EXPECT_EQ(code_of_opening(file_), ExitCode::try_again);
}

TEST_F(TileStoreTest, ATileIsTakenForNoOther) {
  const auto make = [&] {
    fs::remove(file_);
    SqliteTileStore store(file_);
    store.keep(job_, tile(0, "one"));
    store.keep(job_, tile(16, "two"));
    store.keep(job_, tile(32, "three"));
    store.keep(other_, tile(48, "four"));
  };
  const std::string adopt = "UPDATE tiles SET job = '" + job_.hex() + "' WHERE x0 = 48";
  for (const char* statement :
       {"UPDATE tiles SET kept = (SELECT kept FROM tiles WHERE x0 = 16) WHERE x0 = 32",
        "UPDATE tiles SET x1 = 999 WHERE x0 = 32", "UPDATE tiles SET seal = x'00' WHERE x0 = 32",
        "DELETE FROM tiles WHERE x0 = 32; UPDATE tiles SET x0 = 32, x1 = 48 WHERE x0 = 0",
        "UPDATE tiles SET kept = x'ff' WHERE x0 = 32", adopt.c_str()}) {
    SCOPED_TRACE(statement);
    make();
    change(file_, statement);
    const bool adopted = statement == adopt;
    SqliteTileStore store(file_);
    std::vector<int> found;
    for (const FinishedTile& kept : store.find(job_)) {
      found.push_back(kept.rect.x0);
      EXPECT_EQ(kept.kept.SerializeAsString(), tile(kept.rect.x0, kept.rect.x0 == 0    ? "one"
                                                                  : kept.rect.x0 == 16 ? "two"
                                                                                       : "three")
                                                   .kept.SerializeAsString());
    }
    const size_t sound = adopted ? 3 : std::string_view(statement).starts_with("DELETE") ? 1 : 2;
    EXPECT_EQ(found.size(), sound);
    EXPECT_EQ(store.end(), adopted ? 0u : 1u) << "what is damaged was dropped";
  }
}

TEST_F(TileStoreTest, TilesOfAnEarlierFormatAreFound) {
  change(file_,
         "CREATE TABLE tiles (job TEXT, x0 INT, y0 INT, x1 INT, y1 INT, kept BLOB, "
         "PRIMARY KEY (job, x0, y0, x1, y1)); "
         "PRAGMA application_id = 0x54455353; PRAGMA user_version = 1");
  const std::string kept = tile(0, "one").kept.SerializeAsString();
  std::string hex;
  for (const char c : kept) hex += fmt::format("{:02x}", static_cast<unsigned char>(c));
  change(
      file_,
      fmt::format("INSERT INTO tiles VALUES ('{}', 0, 0, 16, 16, x'{}')", job_.hex(), hex).c_str());
  for (int i = 0; i < 2; ++i) {
    SqliteTileStore store(file_);
    store.keep(job_, tile(16, "two"));
    const auto found = store.find(job_);
    ASSERT_EQ(found.size(), 2u) << i;
    EXPECT_EQ(found[0].kept.SerializeAsString(), kept);
  }
  change(file_, "PRAGMA user_version = 3");
  try {
    const SqliteTileStore store(file_);
    ADD_FAILURE() << "a later format is read";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::bad_usage);
    EXPECT_NE(std::string(error.what()).find("a later version"), std::string::npos) << error.what();
  }
}

TEST_F(TileStoreTest, TouchesNoFileOfOthers) {
  std::ofstream(folder_ / "text") << std::string(5000, 'x');
  EXPECT_EQ(code_of_opening(folder_ / "text"), ExitCode::bad_usage);
  EXPECT_EQ(fs::file_size(folder_ / "text"), 5000u);
  EXPECT_EQ(code_of_opening(folder_ / "missing" / "a.tiles"), ExitCode::bad_usage);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder_ / "other").c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "CREATE TABLE tiles (job TEXT)", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  EXPECT_EQ(code_of_opening(folder_ / "other"), ExitCode::bad_usage);
}

TEST_F(TileStoreTest, OneThatIsDamagedIsRefusedAndSaysWhatToDo) {
  {
    SqliteTileStore store(file_);
    for (int x = 0; x < 64; ++x) store.keep(job_, tile(16 * x, std::string(3000, 'p')));
  }
  constexpr int kPage = 4096;
  const auto size = static_cast<int>(fs::file_size(file_));
  {
    // Pages behind the first are those of the tables and what they lead to.
    std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(2 * kPage);
    file << std::string(static_cast<size_t>(size - 2 * kPage), '\xee');
  }
  try {
    const SqliteTileStore store(file_);
    ADD_FAILURE() << "it is served as if sound";
  } catch (const Error& error) {
    const std::string what = error.what();
    EXPECT_EQ(error.code(), ExitCode::bad_usage);
    EXPECT_TRUE(what.starts_with("'" + file_.string() + "' is damaged: ")) << what;
    EXPECT_NE(what.find("move it away, or restore a copy"), std::string::npos) << what;
    EXPECT_EQ(what.find(file_.string()), what.rfind(file_.string())) << "the path once: " << what;
  }
}

}  // namespace
}  // namespace tessera
