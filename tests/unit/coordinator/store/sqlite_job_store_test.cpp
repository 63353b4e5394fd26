// The folder of `serve --store`: what is damaged, what only cannot be read now, and what is
// missing.
#include "coordinator/store/sqlite_job_store.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/error.h"
#include "tests/file_size_limit.h"
#include "tests/temporary_folder.h"
#include "tests/unit/coordinator/store/changed_database.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// While it lives this process can open no further file.
class NoDescriptors {
 public:
  NoDescriptors() {
    getrlimit(RLIMIT_NOFILE, &before_);
    const int next = dup(STDIN_FILENO);
    close(next);
    rlimit none = before_;
    none.rlim_cur = static_cast<rlim_t>(next);
    setrlimit(RLIMIT_NOFILE, &none);
  }
  ~NoDescriptors() { setrlimit(RLIMIT_NOFILE, &before_); }
  NoDescriptors(const NoDescriptors&) = delete;
  NoDescriptors& operator=(const NoDescriptors&) = delete;

 private:
  rlimit before_{};
};

class JobStoreTest : public testing::Test {
 protected:
  static v1::KeptJob job(uint64_t number) {
    v1::KeptJob kept;
    kept.set_job(number);
    kept.mutable_request()->set_tile_size(16);
    kept.mutable_request()->mutable_crop()->set_x1(64);
    kept.mutable_request()->mutable_crop()->set_y1(48);
    v1::JobFrame& frame = *kept.mutable_request()->add_frames();
    frame.set_scene_digest(Digest::of("a scene").hex());
    frame.mutable_settings()->set_width(64);
    frame.mutable_settings()->set_height(48);
    frame.mutable_settings()->set_samples_per_pixel(1);
    kept.add_tile_keys(Digest::of(std::to_string(number)).hex());
    return kept;
  }
  static FinishedTile tile(int x, size_t bytes = 100) {
    FinishedTile tile{{x, 0, x + 16, 16}, {}};
    tile.kept.set_tile_size(16);
    tile.kept.add_bands()->set_pixels(std::string(bytes, static_cast<char>('a' + x / 16 % 26)));
    return tile;
  }
  static Digest put(SqliteJobStore& store, std::string_view text) {
    const auto bytes = std::as_bytes(std::span(text));
    store.put_blob(Digest::of(bytes), copy_to_blob(bytes));
    return Digest::of(bytes);
  }
  fs::path path_of(const Digest& blob) const { return home_ / "blobs" / blob.hex(); }
  /// A store with two jobs and a blob.
  void make_store() {
    SqliteJobStore store(home_);
    store.save(job(1));
    store.save(job(2));
    blob_ = put(store, "bytes");
  }
  /// What an Error says, with its code before it; empty where none is thrown.
  static std::string refusal(const std::function<void()>& action) {
    try {
      action();
    } catch (const Error& error) {
      return std::to_string(static_cast<int>(error.code())) + " " + error.what();
    }
    return "";
  }
  std::string refusal_of_opening() const {
    return refusal([this] { const SqliteJobStore store(home_); });
  }
  std::vector<uint64_t> numbers_of_jobs(SqliteJobStore& store) {
    std::vector<uint64_t> numbers;
    for (const v1::KeptJob& kept : store.jobs()) numbers.push_back(kept.job());
    return numbers;
  }

  const TemporaryFolder temporary_;
  const fs::path home_ = temporary_.path() / "farm", database_ = home_ / "farm.db";
  Digest blob_;
};

TEST_F(JobStoreTest, OnAFullDiskOpensAndCanBeRead) {
  SqliteJobStore(home_).save(job(1));
  const FileSizeLimit full(100);
  SqliteJobStore store(home_);
  EXPECT_EQ(store.last_job(), 1u);
}

TEST_F(JobStoreTest, BlobsThatAreDamagedAreAllFoundBeforeTheyAreCountedOnAndKeptAside) {
  std::vector<Digest> digests;
  {
    SqliteJobStore store(home_);
    for (const char* text : {"sound", "turned", "short", "gone"}) {
      digests.push_back(put(store, text));
      EXPECT_TRUE(store.has_blob(digests.back()));
    }
  }
  std::ofstream(path_of(digests[1])) << "turneD";
  fs::resize_file(path_of(digests[2]), 3);
  fs::remove(path_of(digests[3]));
  SqliteJobStore store(home_);
  EXPECT_TRUE(store.has_blob(digests[0]));
  EXPECT_FALSE(store.has_blob(digests[1]));
  EXPECT_EQ(store.find_blob(digests[2]), nullptr);
  EXPECT_FALSE(store.has_blob(digests[3]));
  for (const size_t i : {1, 2, 3}) {
    EXPECT_FALSE(fs::exists(path_of(digests[i]))) << i;
    EXPECT_EQ(fs::exists(path_of(digests[i]).string() + ".damaged"), i != 3) << i;
  }
  store.keep_only_blobs({});
  EXPECT_TRUE(fs::exists(path_of(digests[1]).string() + ".damaged")) << "people remove it";
  put(store, "turned");
  EXPECT_TRUE(store.has_blob(digests[1]));
}

TEST_F(JobStoreTest, ABlobThatCannotBeOpenedNowIsNeitherMissingNorDamaged) {
  make_store();
  SqliteJobStore store(home_);
  {
    const NoDescriptors none;
    EXPECT_TRUE(refusal([&] { store.has_blob(blob_); }).starts_with("75 "));
    EXPECT_TRUE(refusal([&] { store.find_blob(blob_); }).starts_with("75 "));
    EXPECT_TRUE(refusal([&] { store.put_blob(blob_, make_blob({})); }).starts_with("75 "));
  }
  EXPECT_TRUE(fs::exists(path_of(blob_)));
  EXPECT_TRUE(store.has_blob(blob_));
  ASSERT_NE(store.find_blob(blob_), nullptr);
}

TEST_F(JobStoreTest, WhatIsNoFileInABlobsPlaceIsToldAndLeft) {
  make_store();
  fs::remove(path_of(blob_));
  fs::create_directory(path_of(blob_));
  {
    SqliteJobStore store(home_);
    for (const std::string& what :
         {refusal([&] { store.has_blob(blob_); }), refusal([&] { store.find_blob(blob_); })}) {
      EXPECT_TRUE(what.starts_with("75 '" + path_of(blob_).string() + "'")) << what;
      EXPECT_NE(what.find("it is a folder"), std::string::npos) << what;
    }
  }
  EXPECT_TRUE(fs::is_directory(path_of(blob_)));
  fs::remove(path_of(blob_));
  ASSERT_EQ(mkfifo(path_of(blob_).c_str(), 0600), 0);
  SqliteJobStore store(home_);
  const std::string what = refusal([&] { store.has_blob(blob_); });
  EXPECT_NE(what.find("no regular file"), std::string::npos) << what;
}

TEST_F(JobStoreTest, ADatabaseThatIsGoneOrEmptyBesideItsBlobsIsRefused) {
  make_store();
  const fs::path away = temporary_.path() / "away.db";
  fs::rename(database_, away);
  for (const bool state : {true, false}) {
    if (!state) fs::remove(home_ / "state");
    std::string what = refusal_of_opening();
    EXPECT_TRUE(what.starts_with("2 ")) << what;
    EXPECT_NE(what.find("farm.db' is missing; "), std::string::npos) << what;
    EXPECT_FALSE(fs::exists(database_));
    std::ofstream(database_).flush();
    what = refusal_of_opening();
    EXPECT_NE(what.find("farm.db' is empty; "), std::string::npos) << what;
    EXPECT_EQ(fs::file_size(database_), 0u);
    fs::remove(database_);
    change(database_, "PRAGMA user_version = 3");
    what = refusal_of_opening();
    EXPECT_NE(what.find("farm.db' is empty; "), std::string::npos) << what;
    fs::remove(database_);
  }
  EXPECT_TRUE(fs::exists(path_of(blob_)));
  fs::rename(away, database_);
  SqliteJobStore store(home_);
  EXPECT_EQ(numbers_of_jobs(store), (std::vector<uint64_t>{1, 2}));
  EXPECT_TRUE(store.has_blob(blob_));
}

TEST_F(JobStoreTest, ADatabaseOfAnEarlierTimeIsRefusedUntilThatIsMeant) {
  make_store();
  const fs::path earlier = temporary_.path() / "earlier.db";
  fs::copy_file(database_, earlier);
  {
    SqliteJobStore store(home_);
    store.save(job(3));
    store.remove(3, {}, {});
  }
  EXPECT_EQ(refusal_of_opening(), "") << "forgotten jobs are not missing";
  fs::copy_file(earlier, database_, fs::copy_options::overwrite_existing);
  const std::string what = refusal_of_opening();
  EXPECT_TRUE(what.starts_with("2 ")) << what;
  EXPECT_NE(what.find("has had jobs up to 2, its folder up to 3"), std::string::npos) << what;
  fs::remove(home_ / "state");
  {
    SqliteJobStore store(home_);
    EXPECT_EQ(numbers_of_jobs(store), (std::vector<uint64_t>{1, 2}));
  }
  change(database_, "UPDATE numbers SET value = 99 WHERE name = 'farm'");
  EXPECT_NE(refusal_of_opening().find("another store's"), std::string::npos);
}

TEST_F(JobStoreTest, BlobsWithoutUseAreKeptForAWeek) {
  make_store();
  const auto open_and_sweep = [this](bool used) {
    SqliteJobStore store(home_);
    std::ofstream(home_ / "blobs" / ".tessera-0123.part") << "half";
    std::ofstream(home_ / "blobs" / "notes") << "a person's";
    store.jobs();
    store.keep_only_blobs(used ? std::unordered_set<Digest>{blob_} : std::unordered_set<Digest>{});
    EXPECT_FALSE(fs::exists(home_ / "blobs" / ".tessera-0123.part"));
    EXPECT_TRUE(fs::exists(home_ / "blobs" / "notes"));
    return fs::exists(path_of(blob_));
  };
  const char* six_days = "UPDATE unused SET since = unixepoch() - 6 * 86400";
  const char* eight_days = "UPDATE unused SET since = unixepoch() - 8 * 86400";
  EXPECT_TRUE(open_and_sweep(false));
  change(database_, six_days);
  EXPECT_TRUE(open_and_sweep(false));
  change(database_, eight_days);
  EXPECT_TRUE(open_and_sweep(true)) << "a job needs it";
  EXPECT_TRUE(open_and_sweep(false)) << "the week begins again";
  change(database_, eight_days);
  fs::remove(home_ / "state");
  EXPECT_TRUE(open_and_sweep(false)) << "a restored database does not know since when";
  change(database_, eight_days);
  EXPECT_FALSE(open_and_sweep(false));
}

TEST_F(JobStoreTest, AJobThatIsDamagedIsLeftOutAndLosesNothing) {
  make_store();
  const auto damage = [](const std::function<void(v1::KeptJob&)>& change) {
    v1::KeptJob kept = job(2);
    change(kept);
    return kept;
  };
  const std::vector<v1::KeptJob> damaged = {
      damage([](auto& k) { k.mutable_request()->set_tile_size(0); }),
      damage([](auto& k) { k.mutable_request()->set_tile_size(4'000'000'000u); }),
      damage([](auto& k) {
        k.mutable_request()->mutable_crop()->set_x1(2147483647);
        k.mutable_request()->mutable_crop()->set_y1(2147483647);
        k.mutable_request()->set_tile_size(1);
      }),
      damage([](auto& k) { k.mutable_request()->clear_frames(); }),
      damage([](auto& k) { k.clear_tile_keys(); }),
      damage([](auto& k) { k.set_tile_keys(0, "no key"); }),
      damage([](auto& k) { k.mutable_request()->set_priority(1 << 30); })};
  for (size_t i = 0; i < damaged.size(); ++i) {
    SCOPED_TRACE(i);
    SqliteJobStore store(home_);
    store.save(damaged[i]);
    EXPECT_EQ(numbers_of_jobs(store), (std::vector<uint64_t>{1}));
    store.keep_only_blobs({});
  }
  for (const char* statement :
       {"UPDATE jobs SET job = 9223372036854775807 WHERE job = 2",
        "UPDATE jobs SET job = 77 WHERE job > 77", "UPDATE jobs SET kept = x'ff' WHERE job = 77"}) {
    SCOPED_TRACE(statement);
    change(database_, statement);
    SqliteJobStore store(home_);
    EXPECT_EQ(numbers_of_jobs(store), (std::vector<uint64_t>{1}));
    EXPECT_LT(store.last_job(), 100u);
    store.keep_only_blobs({});
  }
  change(database_, "UPDATE unused SET since = 0");
  {
    SqliteJobStore store(home_);
    store.jobs();
    store.keep_only_blobs({});
    EXPECT_TRUE(store.has_blob(blob_)) << "it may be of the job that cannot be read";
  }
  int rows = 0;
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(database_.c_str(), &database), SQLITE_OK);
  sqlite3_exec(
      database, "SELECT * FROM jobs",
      [](void* n, int, char**, char**) { return ++*static_cast<int*>(n), 0; }, &rows, nullptr);
  sqlite3_close(database);
  EXPECT_EQ(rows, 2) << "its row is kept";
}

TEST_F(JobStoreTest, TheLastJobIsNeverBehindTheJobs) {
  make_store();
  change(database_, "UPDATE numbers SET value = 0 WHERE name = 'last_job'");
  EXPECT_EQ(SqliteJobStore(home_).last_job(), 2u);
  change(database_, "UPDATE numbers SET value = -1 WHERE name = 'last_job'");
  EXPECT_EQ(SqliteJobStore(home_).last_job(), 2u);
  change(database_, "DELETE FROM numbers WHERE name = 'last_job'");
  EXPECT_EQ(SqliteJobStore(home_).last_job(), 2u);
}

TEST_F(JobStoreTest, AnEndIsTakenBackAndOneOfNoFrameIsNotTold) {
  SqliteJobStore store(home_);
  store.save(job(1));
  v1::KeptJob::End end;
  end.mutable_end()->set_exit_code(3);
  store.save_end(1, end);
  end.set_frame(7);
  store.save_end(1, end);
  ASSERT_EQ(store.jobs()[0].ends_size(), 1);
  EXPECT_EQ(store.jobs()[0].ends(0).frame(), 0u);
  store.remove_end(1, 0);
  EXPECT_EQ(store.jobs()[0].ends_size(), 0);
}

TEST_F(JobStoreTest, TilesAreFoundByTheKeysOfWhoTracedThem) {
  const std::string alice(40, 'a'), bob(40, 'b');
  const Digest one = Digest::of("1"), two = Digest::of("2");
  {
    SqliteJobStore store(home_);
    FinishedTile both = tile(0), his = tile(16), nobodys = tile(32);
    both.kept.add_tracers(alice);
    both.kept.add_tracers(bob);
    his.kept.add_tracers(bob);
    store.keep(one, both);
    store.keep(two, his);
    store.keep(two, nobodys);
  }
  SqliteJobStore store(home_);
  const auto hers = store.tiles_traced_by(alice);
  ASSERT_EQ(hers.size(), 1u);
  EXPECT_EQ(hers[0].key, one);
  EXPECT_EQ(hers[0].rect, tile(0).rect);
  EXPECT_EQ(store.tiles_traced_by(bob).size(), 2u);
  EXPECT_TRUE(store.tiles_traced_by(std::string(40, 'c')).empty());
  store.drop_all(two);
  EXPECT_TRUE(store.find(two).empty());
  EXPECT_EQ(store.find(one).size(), 1u);
  EXPECT_EQ(store.tiles_traced_by(bob).size(), 1u);
}

TEST_F(JobStoreTest, OneOfTheFormatBeforeIsUpgraded) {
  fs::create_directories(home_ / "blobs");
  std::ofstream(path_of(Digest::of("bytes"))) << "bytes";
  const auto hex = [](const std::string& bytes) {
    std::string text;
    for (const char c : bytes) {
      for (const int digit : {(c >> 4) & 15, c & 15}) text += "0123456789abcdef"[digit];
    }
    return "x'" + text + "'";
  };
  change(database_,
         "CREATE TABLE tiles (job TEXT, x0 INT, y0 INT, x1 INT, y1 INT, kept BLOB, "
         "PRIMARY KEY (job, x0, y0, x1, y1));"
         "CREATE TABLE jobs (job INTEGER PRIMARY KEY, kept BLOB);"
         "CREATE TABLE ends (job INT, frame INT, kept BLOB, PRIMARY KEY (job, frame));"
         "CREATE TABLE numbers (name TEXT PRIMARY KEY, value INT);"
         "INSERT INTO numbers VALUES ('farm', 12345), ('last_job', 9);"
         "PRAGMA application_id = 0x5445534a; PRAGMA user_version = 2;"
         "INSERT INTO jobs VALUES (1, " +
             hex(job(1).SerializeAsString()) + ");" + "INSERT INTO tiles VALUES ('" +
             job(1).tile_keys(0) + "', 0, 0, 16, 16, " + hex(tile(0).kept.SerializeAsString()) +
             ")");
  for (int i = 0; i < 2; ++i) {
    SqliteJobStore store(home_);
    EXPECT_EQ(store.farm(), 12345u);
    EXPECT_EQ(store.last_job(), 9u);
    EXPECT_EQ(numbers_of_jobs(store), (std::vector<uint64_t>{1}));
    EXPECT_TRUE(store.has_blob(Digest::of("bytes")));
    const Digest key = Digest::from_hex(job(1).tile_keys(0));
    store.keep(key, tile(16));
    const auto found = store.find(key);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].kept.SerializeAsString(), tile(0).kept.SerializeAsString());
  }
  change(database_, "PRAGMA user_version = 4");
  EXPECT_NE(refusal_of_opening().find("of a later version"), std::string::npos);
}

TEST_F(JobStoreTest, AProgramThatCopiesItIsWaitedFor) {
  make_store();
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open(database_.c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE; DELETE FROM ends", nullptr, nullptr, nullptr),
            SQLITE_OK);
  std::thread copies([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    sqlite3_close(other);
  });
  EXPECT_EQ(refusal_of_opening(), "");
  copies.join();
}

TEST_F(JobStoreTest, TheFileShrinksWhenAJobIsForgotten) {
  const Digest key = Digest::of("a frame"), other = Digest::of("another");
  SqliteJobStore store(home_);
  store.save(job(1));
  for (int i = 0; i < 200; ++i) {
    store.keep(key, tile(16 * i, 12'000));
    if (i % 10 == 0) store.keep(other, tile(16 * i, 12'000));
  }
  store.remove(1, {key}, {});
  for (int i = 0; i < 1000; ++i) store.tidy();
  EXPECT_LT(fs::file_size(database_), 20u * 16'384 + 100'000);
  EXPECT_EQ(fs::file_size(home_ / "farm.db-wal"), 0u);
  EXPECT_EQ(store.find(other).size(), 20u);
}

TEST_F(JobStoreTest, OnADiskFullToTheLastByteJobsAreCancelledAndForgotten) {
  fs::create_directory(home_);
  if (mount("none", home_.c_str(), "tmpfs", 0, "size=32m") != 0) {
    GTEST_SKIP() << "no small disk can be mounted here, by root alone: " << std::strerror(errno);
  }
  const auto fill = [this] {
    for (const size_t bytes : {size_t{1} << 20, size_t{1}}) {
      std::ofstream rest(home_ / "rest", std::ios::binary | std::ios::app);
      const std::string some(bytes, 'x');
      while (rest << some << std::flush) {
      }
    }
  };
  for (const bool opened_again : {false, true}) {
    SCOPED_TRACE(opened_again);
    std::optional<SqliteJobStore> store(std::in_place, home_);
    const Digest one = Digest::of("1"), two = Digest::of("2");
    store->save(job(1));
    store->save(job(2));
    size_t kept = 0;
    // By turns, so that pages of the two jobs lie beside each other.
    EXPECT_THROW(for (;; ++kept)
                     store->keep(kept % 2 ? one : two, tile(16 * static_cast<int>(kept), 12'000)),
                 Error);
    EXPECT_GT(kept, 500u);
    fill();
    if (opened_again) store.emplace(home_);
    fill();
    v1::KeptJob cancelled = job(1);
    cancelled.set_cancelled(true);
    EXPECT_EQ(refusal([&] { store->save(cancelled); }), "");
    EXPECT_EQ(refusal([&] { store->remove(1, {one}, {}); }), "");
    EXPECT_TRUE(store->find(one).empty());
    EXPECT_EQ(store->find(two).size(), (kept + 1) / 2);
    EXPECT_EQ(refusal([&] { store->keep(one, tile(0, 12'000)); }), "") << "there is room again";
    for (int i = 0; i < 1000; ++i) store->tidy();
    EXPECT_TRUE(fs::exists(home_ / "reserve")) << "for another time";
    EXPECT_EQ(refusal([&] { store->remove(2, {one, two}, {}); }), "");
    store.reset();
    fs::remove(home_ / "rest");
  }
  EXPECT_EQ(umount(home_.c_str()), 0);
}

}  // namespace
}  // namespace tessera
