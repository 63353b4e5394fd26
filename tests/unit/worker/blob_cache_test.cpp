#include "worker/blob_cache.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "base/error.h"
#include "tests/temporary_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

class BlobCacheTest : public ::testing::Test {
 protected:
  void SetUp() override { spdlog::set_level(spdlog::level::off); }
  void TearDown() override { spdlog::set_level(spdlog::level::info); }

  static Blob blob(size_t size, int value) {
    return Blob(std::vector<std::byte>(size, static_cast<std::byte>(value)));
  }
  static Digest keep(BlobCache& cache, const Blob& blob) {
    const Digest digest = Digest::of(blob);
    cache.keep(digest, blob);
    return digest;
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_))
      names.push_back(entry.path().filename());
    return names;
  }
  /// As if it was used so long ago.
  void age(const Digest& digest, int age_in_seconds) const {
    const fs::path path = folder_ / digest.hex();
    fs::last_write_time(path, fs::last_write_time(path) - std::chrono::seconds(age_in_seconds));
  }

  const TemporaryFolder parent_;
  const fs::path folder_ = parent_ / "a/cache";
};

TEST_F(BlobCacheTest, KeepsBeyondItsOwnLifeForThisUserAlone) {
  Digest digest;
  {
    BlobCache cache(folder_, 1 << 20);
    digest = keep(cache, blob(5000, 7));
    EXPECT_FALSE(cache.find(Digest::of("another"), 7));
  }
  BlobCache cache(folder_, 1 << 20);
  const BlobData found = cache.find(digest, 5000);
  ASSERT_TRUE(found);
  EXPECT_EQ(*found, blob(5000, 7));
  struct stat status {};
  ASSERT_EQ(stat(folder_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0700u);
  ASSERT_EQ(stat((folder_ / digest.hex()).c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
}

TEST_F(BlobCacheTest, WhatWasFoundStaysWhateverBecomesOfItsFile) {
  BlobCache cache(folder_, 1 << 20);
  const Digest digest = keep(cache, blob(5000, 7));
  const fs::path path = folder_ / digest.hex();
  const BlobData found = cache.find(digest, 5000);
  ASSERT_TRUE(found);
  std::fstream(path, std::ios::in | std::ios::out | std::ios::binary).seekp(2500).put('x');
  EXPECT_EQ(*found, blob(5000, 7));
  fs::resize_file(path, 100);
  EXPECT_EQ(*found, blob(5000, 7)) << "and reading it ends no process";
}

TEST_F(BlobCacheTest, WhatIsDamagedIsRemovedAndNotFound) {
  BlobCache cache(folder_, 1 << 20);
  for (const auto& damage : {+[](std::fstream& file) { file.seekp(4999).put('x'); },
                             +[](std::fstream& file) { file.seekp(0, std::ios::end).put('x'); }}) {
    const Digest digest = keep(cache, blob(5000, 7));
    const fs::path path = folder_ / digest.hex();
    {
      std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
      damage(file);
    }
    EXPECT_FALSE(cache.find(digest, 5000));
    EXPECT_FALSE(fs::exists(path));
  }
  const Digest digest = keep(cache, blob(5000, 7));
  fs::resize_file(folder_ / digest.hex(), 4000);
  EXPECT_FALSE(cache.find(digest, 5000));
  // A name that leads elsewhere is not followed.
  fs::create_symlink("/dev/zero", folder_ / digest.hex());
  EXPECT_FALSE(cache.find(digest, 5000));
}

TEST_F(BlobCacheTest, WhatWasUsedLongestAgoGoesFirst) {
  BlobCache cache(folder_, 3000);
  const Digest a = keep(cache, blob(1000, 1)), b = keep(cache, blob(1000, 2)),
               c = keep(cache, blob(1000, 3));
  age(a, 300), age(b, 200), age(c, 100);
  const BlobData held = cache.find(a, 1000);  // used now
  ASSERT_TRUE(held);
  const Digest d = keep(cache, blob(1500, 4));
  EXPECT_FALSE(cache.find(b, 1000));
  EXPECT_FALSE(cache.find(c, 1000));
  EXPECT_TRUE(cache.find(d, 1500));
  // One that is gone from the disk stays with who has it.
  keep(cache, blob(3000, 5));
  EXPECT_EQ(files().size(), 1u);
  EXPECT_EQ(*held, blob(1000, 1));
  // What exceeds the budget alone is not kept.
  keep(cache, blob(3001, 6));
  EXPECT_TRUE(cache.find(Digest::of(blob(3000, 5)), 3000));
}

TEST_F(BlobCacheTest, AFullDiskLeavesNothingHalf) {
  // A child with a limit on the size of files stands for the disk.
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{2000, 2000};
    setrlimit(RLIMIT_FSIZE, &limit);
    BlobCache cache(folder_, 1 << 20);
    const Digest large = keep(cache, blob(5000, 1)), small = keep(cache, blob(1000, 2));
    _exit(cache.find(large, 5000) ? 1 : cache.find(small, 1000) ? 0 : 2);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(files().size(), 1u);
}

TEST_F(BlobCacheTest, AFolderThatVanishesIsGoneOnWithout) {
  BlobCache cache(folder_, 1 << 20);
  fs::remove_all(folder_);
  const Digest digest = keep(cache, blob(1000, 1));
  EXPECT_FALSE(cache.find(digest, 1000));
}

TEST_F(BlobCacheTest, WhatAKilledWorkerLeftIsRemoved) {
  fs::create_directories(folder_);
  fs::permissions(folder_, fs::perms::owner_all);
  const std::string hex = Digest::of("x").hex();
  // In containers that share a cache every worker is process 1.
  std::ofstream(folder_ / (hex + ".1.tmp")) << "half";
  const int under_way = open((folder_ / (hex + ".2.tmp")).c_str(), O_WRONLY | O_CREAT, 0600);
  ASSERT_EQ(flock(under_way, LOCK_EX), 0);
  std::ofstream(folder_ / "notes.1.tmp") << "not ours";
  const BlobCache cache(folder_, 1 << 20);
  EXPECT_THAT(files(), ::testing::UnorderedElementsAre(hex + ".2.tmp", "notes.1.tmp"));
  close(under_way);
}

TEST_F(BlobCacheTest, AFolderThatOthersCanWriteToIsRefused) {
  fs::create_directories(folder_);
  fs::permissions(folder_, fs::perms::all);
  EXPECT_THROW(BlobCache(folder_, 1), Error);
  std::ofstream(parent_ / "file") << "x";
  EXPECT_THROW(BlobCache(parent_ / "file", 1), Error);
  EXPECT_THROW(BlobCache("/proc/nowhere/cache", 1), Error);
}

}  // namespace
}  // namespace tessera
