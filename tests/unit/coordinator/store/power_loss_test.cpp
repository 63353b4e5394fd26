// What a power cut leaves of a store: files as they were when they were last synced, and perhaps
// some of what was written since (farm test 14).
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "coordinator/store/sqlite_job_store.h"
#include "coordinator/store/sqlite_tile_store.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Files by name, as their last sync left them.
std::map<std::string, std::string>& synced() {
  static std::map<std::string, std::string> files;
  return files;
}

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// A VFS of SQLite that passes all on to the usual one, and takes note of syncs.
struct NotedFile {
  sqlite3_file base;
  sqlite3_file* real;
  char name[512];
};
sqlite3_file* real(sqlite3_file* file) { return reinterpret_cast<NotedFile*>(file)->real; }
sqlite3_vfs* usual_vfs = nullptr;

int note_sync(sqlite3_file* file, int flags) {
  const int code = real(file)->pMethods->xSync(real(file), flags);
  const auto* noted = reinterpret_cast<NotedFile*>(file);
  if (code == SQLITE_OK) synced()[noted->name] = content(noted->name);
  return code;
}

const sqlite3_io_methods kMethods = {
    .iVersion = 1,
    .xClose =
        [](sqlite3_file* file) {
          const int code = real(file)->pMethods->xClose(real(file));
          std::free(real(file));
          return code;
        },
    .xRead = [](sqlite3_file* f, void* to, int count,
                sqlite3_int64 at) { return real(f)->pMethods->xRead(real(f), to, count, at); },
    .xWrite = [](sqlite3_file* f, const void* from, int count,
                 sqlite3_int64 at) { return real(f)->pMethods->xWrite(real(f), from, count, at); },
    .xTruncate = [](sqlite3_file* f,
                    sqlite3_int64 size) { return real(f)->pMethods->xTruncate(real(f), size); },
    .xSync = note_sync,
    .xFileSize = [](sqlite3_file* f,
                    sqlite3_int64* size) { return real(f)->pMethods->xFileSize(real(f), size); },
    .xLock = [](sqlite3_file* f, int lock) { return real(f)->pMethods->xLock(real(f), lock); },
    .xUnlock = [](sqlite3_file* f, int lock) { return real(f)->pMethods->xUnlock(real(f), lock); },
    .xCheckReservedLock =
        [](sqlite3_file* f, int* out) {
          return real(f)->pMethods->xCheckReservedLock(real(f), out);
        },
    .xFileControl = [](sqlite3_file* f, int op,
                       void* arg) { return real(f)->pMethods->xFileControl(real(f), op, arg); },
    .xSectorSize = [](sqlite3_file* f) { return real(f)->pMethods->xSectorSize(real(f)); },
    .xDeviceCharacteristics =
        [](sqlite3_file* f) { return real(f)->pMethods->xDeviceCharacteristics(real(f)); },
    .xShmMap = nullptr,
    .xShmLock = nullptr,
    .xShmBarrier = nullptr,
    .xShmUnmap = nullptr,
    .xFetch = nullptr,
    .xUnfetch = nullptr,
};

int open_noted(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out) {
  auto* noted = reinterpret_cast<NotedFile*>(file);
  noted->real =
      static_cast<sqlite3_file*>(std::calloc(1, static_cast<size_t>(usual_vfs->szOsFile)));
  std::strncpy(noted->name, name ? name : "", sizeof noted->name - 1);
  const int code = usual_vfs->xOpen(usual_vfs, name, noted->real, flags, out);
  if (noted->real->pMethods == nullptr) {
    std::free(noted->real);
    file->pMethods = nullptr;
  } else {
    file->pMethods = &kMethods;
  }
  return code;
}

class PowerLoss : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "tessera-power-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    usual_vfs = sqlite3_vfs_find(nullptr);
    noted_ = *usual_vfs;
    noted_.szOsFile = sizeof(NotedFile);
    noted_.zName = "noted";
    noted_.xOpen = open_noted;
    synced().clear();
    ASSERT_EQ(sqlite3_vfs_register(&noted_, 1), SQLITE_OK);
  }
  void TearDown() override {
    sqlite3_vfs_unregister(&noted_);
    sqlite3_vfs_register(usual_vfs, 1);
    fs::remove_all(folder_);
  }

  /// The store in `from` as it is after a power cut now. Of what was not synced, `share` is there.
  fs::path cut(const fs::path& from, double share) {
    const fs::path to = folder_ / ("cut" + std::to_string(++cuts_));
    fs::create_directories(to / "blobs");
    for (const auto& [name, old] : std::map(synced())) {
      // SQLite syncs the folder where it matters that a file is gone.
      if (fs::path(name).parent_path() != from || !fs::exists(name)) continue;
      std::string bytes = content(name);
      const auto kept = static_cast<size_t>(share * static_cast<double>(bytes.size()));
      // The first part as it is now, the rest as it was.
      std::string after = old;
      if (after.size() < kept) after.resize(kept);
      std::copy_n(bytes.begin(), kept, after.begin());
      std::ofstream(to / fs::path(name).filename(), std::ios::binary) << after;
    }
    return to;
  }

  static v1::KeptJob job(uint64_t number) {
    v1::KeptJob kept;
    kept.set_job(number);
    kept.mutable_request()->set_name("job " + std::to_string(number));
    kept.mutable_request()->set_tile_size(16);
    kept.mutable_request()->mutable_crop()->set_x1(64);
    kept.mutable_request()->mutable_crop()->set_y1(48);
    v1::JobFrame& frame = *kept.mutable_request()->add_frames();
    frame.set_scene_digest(Digest::of("a scene").hex());
    frame.mutable_settings()->set_width(64);
    frame.mutable_settings()->set_height(48);
    frame.mutable_settings()->set_samples_per_pixel(1);
    kept.add_tile_keys(Digest::of("a frame").hex());
    return kept;
  }
  static FinishedTile tile(int x) {
    FinishedTile tile{{x, 0, x + 16, 16}, {}};
    tile.kept.set_tile_size(16);
    tile.kept.add_bands()->set_pixels(std::string(3000, static_cast<char>('a' + x / 16 % 26)));
    return tile;
  }

  /// As cut() with nothing of what was not synced, of one file and its log.
  fs::path cut_file(const fs::path& from) {
    const fs::path to = folder_ / ("cut" + std::to_string(++cuts_));
    for (const auto& [name, bytes] : synced()) {
      if (!name.starts_with(from.string()) || !fs::exists(name)) continue;
      std::ofstream(to.string() + name.substr(from.string().size()), std::ios::binary) << bytes;
    }
    return to;
  }

  fs::path folder_;
  sqlite3_vfs noted_{};
  int cuts_ = 0;
};

TEST_F(PowerLoss, JobsAreThereAndTilesAreWholeOrGone) {
  const fs::path home = folder_ / "farm";
  const Digest key = Digest::of("a frame");
  SqliteJobStore store(home);
  int tiles = 0;
  size_t lost = 0;
  for (uint64_t number = 1; number <= 3; ++number) {
    store.save(job(number));
    for (const double share : {0.0, 0.4, 0.9, 1.0}) {
      // More than SQLite moves from its log to the database at a time.
      for (int i = 0; i < 150; ++i) store.keep(key, tile(16 * tiles++));
      const fs::path after = cut(home, share);
      SqliteJobStore again(after);
      ASSERT_EQ(again.jobs().size(), number) << share;
      EXPECT_EQ(again.jobs().back().request().name(), job(number).request().name());
      EXPECT_EQ(again.last_job(), number);
      EXPECT_EQ(again.farm(), store.farm());
      const auto found = again.find(key);
      EXPECT_LE(found.size(), static_cast<size_t>(tiles));
      for (const FinishedTile& kept : found) {
        EXPECT_EQ(kept.kept.SerializeAsString(), tile(kept.rect.x0).kept.SerializeAsString());
      }
      lost += static_cast<size_t>(tiles) - found.size();
      again.save(job(number + 100));
      EXPECT_EQ(again.jobs().size(), number + 1) << "and it goes on";
    }
  }
  EXPECT_GT(lost, 0u) << "or no power was cut";
  EXPECT_EQ(store.find(key).size(), static_cast<size_t>(tiles))
      << "the end of a process loses none";
}

TEST_F(PowerLoss, TilesOfOneRenderAreLostOnlyAsFarAsTheLogReaches) {
  const fs::path home = folder_ / "picture.tiles";
  const Digest key = Digest::of("a frame");
  // What SQLite moves to the database at a time, and is synced then: 1,000 pages of 4 KiB.
  constexpr int kTilesOfLog = 1000;
  SqliteTileStore store(home);
  int tiles = 0;
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < kTilesOfLog; ++i) store.keep(key, tile(16 * tiles++));
    SqliteTileStore again(cut_file(home));
    const auto found = again.find(key);
    EXPECT_GT(found.size(), static_cast<size_t>(tiles - kTilesOfLog)) << round;
    for (const FinishedTile& kept : found) {
      EXPECT_EQ(kept.kept.SerializeAsString(), tile(kept.rect.x0).kept.SerializeAsString());
    }
  }
}

}  // namespace
}  // namespace tessera
