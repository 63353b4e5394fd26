#include "coordinator/store/sqlite_job_store.h"

#include <fmt/format.h>

#include <bit>
#include <fstream>
#include <random>
#include <string>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/folder.h"
#include "base/monotonic.h"
#include "proto/wire/kept.h"

namespace tessera {

namespace fs = std::filesystem;
using Statement = SqliteDatabase::Statement;

namespace {

constexpr std::streamsize kReadBytes = std::streamsize{1} << 20;
/// Given up so that a job can be ended and forgotten on a full disk.
constexpr const char* kReserve = "reserve";
constexpr size_t kReserveBytes = size_t{128} << 10;
constexpr int kJobsApplicationId = 0x5445534a;  // "TESJ"

/// The folder, with all that must be in it before the database is opened.
const fs::path& made(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder / "blobs", error);
  if (error) {
    throw usage_error(fmt::format("--store: '{}': {}; expected a folder to write to",
                                  folder.string(), error.message()));
  }
  return folder;
}

/// Notes how long it lived, also where what it times throws.
class Timed {
 public:
  explicit Timed(SecondsHistogram& times) : times_(times) {}
  ~Timed() { times_.note(to_seconds(monotonic_now() - start_)); }
  Timed(const Timed&) = delete;
  Timed& operator=(const Timed&) = delete;

 private:
  SecondsHistogram& times_;
  Time start_ = monotonic_now();
};

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

SqliteJobStore::SqliteJobStore(const fs::path& folder)
    : folder_(made(folder)),
      database_(folder / "farm.db", {.application_id = kJobsApplicationId,
                                     .format = 2,
                                     .what = "a store",
                                     .fails = "cannot keep jobs and tiles"}),
      tiles_(database_) {
  database_.execute("CREATE TABLE IF NOT EXISTS jobs (job INTEGER PRIMARY KEY, kept BLOB)");
  database_.execute(
      "CREATE TABLE IF NOT EXISTS ends (job INT, frame INT, kept BLOB, PRIMARY KEY (job, frame))");
  database_.execute("CREATE TABLE IF NOT EXISTS numbers (name TEXT PRIMARY KEY, value INT)");
  const SqliteDatabase::Flushed flushed(database_);
  if (number("farm") == 0) {
    std::random_device random;
    set_number("farm", (uint64_t{random()} << 31 | random()) | 1);
  }
  farm_ = number("farm");
  epoch_ = number("epoch") + 1;
  try {
    // Before anybody is served: what an earlier coordinator said is told apart from now on.
    keep_epoch();
  } catch (const Error&) {
    // As a coordinator that runs does, this one waits for room, which it says.
  }
  make_reserve();
}

void SqliteJobStore::keep_epoch() {
  if (epoch_kept_) return;
  const SqliteDatabase::Flushed flushed(database_);
  set_number("epoch", epoch_);
  epoch_kept_ = true;
}

void SqliteJobStore::make_reserve() const {
  const fs::path path = folder_ / kReserve;
  std::error_code ignored;
  if (fs::exists(path, ignored)) return;
  try {
    write_output_file(path, std::string(kReserveBytes, '\0'));
  } catch (const Error&) {
    // There is no room to be set apart.
  }
}

template <typename Write>
void SqliteJobStore::write_at_last(const Write& write) {
  try {
    write();
  } catch (const Error&) {
    std::error_code ignored;
    if (!fs::remove(folder_ / kReserve, ignored)) throw;
    write();
  }
}

uint64_t SqliteJobStore::number(const char* name) {
  Statement row(database_, "SELECT value FROM numbers WHERE name = ?");
  return row.bind(std::string_view(name)).step() ? static_cast<uint64_t>(row.integer(0)) : 0;
}

void SqliteJobStore::set_number(const char* name, uint64_t value) {
  Statement(database_, "INSERT OR REPLACE INTO numbers VALUES (?, ?)")
      .bind(std::string_view(name))
      .bind(std::bit_cast<int64_t>(value))
      .step();
}

std::vector<v1::KeptJob> SqliteJobStore::jobs() {
  std::vector<v1::KeptJob> jobs;
  Statement rows(database_, "SELECT job, kept FROM jobs ORDER BY job");
  while (rows.step()) {
    auto kept = parse_kept_job(rows.blob(1));
    if (!kept || kept->job() != static_cast<uint64_t>(rows.integer(0))) {
      throw usage_error(
          fmt::format("'{}' is damaged: job {} cannot be read; expected a store as it was written: "
                      "move it away, or restore a copy",
                      (folder_ / "farm.db").string(), rows.integer(0)));
    }
    Statement ends(database_, "SELECT frame, kept FROM ends WHERE job = ? ORDER BY frame");
    ends.bind(rows.integer(0));
    while (ends.step()) {
      // A frame whose end cannot be read ends again, from its tiles.
      auto end = parse_job_end(ends.blob(1));
      if (!end) continue;
      v1::KeptJob::End& added = *kept->add_ends();
      added.set_frame(static_cast<uint32_t>(ends.integer(0)));
      *added.mutable_end() = std::move(*end);
    }
    jobs.push_back(std::move(*kept));
  }
  return jobs;
}

void SqliteJobStore::keep(const Digest& key, const FinishedTile& tile) {
  const Timed timed(commit_seconds_);
  tiles_.keep(key, tile);
}

uint64_t SqliteJobStore::last_job() { return number("last_job"); }

void SqliteJobStore::save(const v1::KeptJob& job) {
  v1::KeptJob without_ends = job;
  without_ends.clear_ends();
  const std::string kept = without_ends.SerializeAsString();
  const Timed timed(commit_seconds_);
  const SqliteDatabase::Flushed flushed(database_);
  const auto write = [&] {
    // The number first: one that is skipped does no harm, one that is given twice would.
    if (job.job() > last_job()) set_number("last_job", job.job());
    Statement(database_, "INSERT OR REPLACE INTO jobs VALUES (?, ?)")
        .bind(static_cast<int64_t>(job.job()))
        .bind_blob(kept)
        .step();
  };
  if (job.cancelled()) return write_at_last(write);
  write();
}

void SqliteJobStore::save_end(uint64_t job, const v1::KeptJob::End& end) {
  const std::string kept = end.end().SerializeAsString();
  const Timed timed(commit_seconds_);
  Statement(database_, "INSERT OR REPLACE INTO ends VALUES (?, ?, ?)")
      .bind(static_cast<int64_t>(job))
      .bind(int64_t{end.frame()})
      .bind_blob(kept)
      .step();
}

void SqliteJobStore::remove_end(uint64_t job, uint32_t frame) {
  const Timed timed(commit_seconds_);
  Statement(database_, "DELETE FROM ends WHERE job = ? AND frame = ?")
      .bind(static_cast<int64_t>(job))
      .bind(int64_t{frame})
      .step();
}

std::vector<StoredTile> SqliteJobStore::tiles_traced_by(const std::string& key) {
  return tiles_.traced_by(key);
}

void SqliteJobStore::remove(uint64_t job, const std::vector<Digest>& tile_keys,
                            const std::vector<Digest>& blobs) {
  // The job first: what else is left behind by a kill is found by keep_only_blobs(), or is tiles
  // that the same frame would take up again.
  for (const char* text : {"DELETE FROM jobs WHERE job = ?", "DELETE FROM ends WHERE job = ?"}) {
    write_at_last([&] { Statement(database_, text).bind(static_cast<int64_t>(job)).step(); });
  }
  for (const Digest& blob : blobs) {
    std::error_code ignored;
    fs::remove(blob_path(blob), ignored);
  }
  // Last, as deleting from the database takes room at first.
  for (const Digest& key : tile_keys) {
    write_at_last([&] { tiles_.drop_all(key); });
  }
  make_reserve();
}

fs::path SqliteJobStore::blob_path(const Digest& digest) const {
  return folder_ / "blobs" / digest.hex();
}

bool SqliteJobStore::has_blob(const Digest& digest) {
  std::error_code ignored;
  if (!fs::exists(blob_path(digest), ignored)) return false;
  if (verified_.contains(digest)) return true;
  std::ifstream file(blob_path(digest), std::ios::binary);
  DigestStream stream;
  std::vector<char> piece(kReadBytes);
  while (file.read(piece.data(), kReadBytes) || file.gcount() > 0) {
    stream.add(std::as_bytes(std::span(piece).first(static_cast<size_t>(file.gcount()))));
  }
  if (file.eof() && stream.finish() == digest) {
    verified_.insert(digest);
    return true;
  }
  // So that who submits it is asked for it with all else that is lacking.
  fs::remove(blob_path(digest), ignored);
  return false;
}

void SqliteJobStore::put_blob(const Digest& digest, const BlobData& data) {
  const Timed timed(commit_seconds_);
  if (!has_blob(digest)) write_output_file(blob_path(digest), text_of(*data));
  verified_.insert(digest);
}

BlobData SqliteJobStore::find_blob(const Digest& digest) {
  std::ifstream file(blob_path(digest), std::ios::binary | std::ios::ate);
  if (!file) return nullptr;
  std::vector<std::byte> bytes(static_cast<size_t>(std::max<std::streamoff>(0, file.tellg())));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file || Digest::of(bytes) != digest) {
    // So that whoever has it is asked for it again.
    std::error_code ignored;
    fs::remove(blob_path(digest), ignored);
    verified_.erase(digest);
    return nullptr;
  }
  verified_.insert(digest);
  return make_blob(std::move(bytes));
}

void SqliteJobStore::keep_only_blobs(const std::unordered_set<Digest>& digests) {
  std::error_code ignored;
  for (const auto& entry : entries_in(folder_ / "blobs")) {
    const auto digest = Digest::parse(entry.path().filename().string());
    // What has no such name was being written when its writer was killed.
    if (!digest || !digests.contains(*digest)) fs::remove(entry.path(), ignored);
  }
}

}  // namespace tessera
