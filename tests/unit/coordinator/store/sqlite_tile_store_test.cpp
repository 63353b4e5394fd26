#include "coordinator/store/sqlite_tile_store.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "coordinator/store/sqlite_job_store.h"
#include "tests/file_size_limit.h"
#include "tests/temporary_folder.h"

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
  EXPECT_EQ(code_of_opening(file_), ExitCode::bad_usage);
}

TEST_F(TileStoreTest, WhereTheDiskTakesNothingTheCommandLineIsNotWrong) {
  const FileSizeLimit small(100);
  EXPECT_EQ(code_of_opening(file_), ExitCode::render_failed);
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

TEST(JobStoreOnAFullDisk, OpensAndCanBeRead) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "farm";
  v1::KeptJob job;
  job.set_job(1);
  SqliteJobStore(path).save(job);
  const FileSizeLimit full(100);
  SqliteJobStore store(path);
  EXPECT_EQ(store.last_job(), 1u);
}

TEST(JobStoreBlobs, ThatAreDamagedAreAllFoundBeforeTheyAreCountedOn) {
  const TemporaryFolder folder;
  std::vector<Digest> digests;
  {
    SqliteJobStore store(folder.path() / "farm");
    for (const char* text : {"sound", "turned", "short", "gone"}) {
      const auto bytes = std::as_bytes(std::span(std::string_view(text)));
      digests.push_back(Digest::of(bytes));
      store.put_blob(digests.back(), copy_to_blob(bytes));
      EXPECT_TRUE(store.has_blob(digests.back()));
    }
  }
  const auto path = [&](size_t i) { return folder.path() / "farm" / "blobs" / digests[i].hex(); };
  std::ofstream(path(1)) << "turneD";
  fs::resize_file(path(2), 3);
  fs::remove(path(3));
  SqliteJobStore store(folder.path() / "farm");
  EXPECT_TRUE(store.has_blob(digests[0]));
  for (const size_t i : {1, 2, 3}) {
    EXPECT_FALSE(store.has_blob(digests[i])) << i;
    EXPECT_FALSE(fs::exists(path(i))) << i;
  }
}

}  // namespace
}  // namespace tessera
