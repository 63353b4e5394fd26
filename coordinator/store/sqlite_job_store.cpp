#include "coordinator/store/sqlite_job_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <system_error>
#include <utility>

#include "base/descriptors.h"
#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "base/owned_descriptor.h"
#include "coordinator/jobs/check_kept_job.h"
#include "proto/wire/kept.h"

namespace tessera {

namespace fs = std::filesystem;
using Statement = SqliteDatabase::Statement;

namespace {

/// Given up so that jobs can be ended and forgotten on a full disk. What the log has, SQLite's
/// 1,000 pages and a large tile, must fit into the database with it; the log is then written anew.
constexpr const char* kReserve = "reserve";
constexpr off_t kReserveBytes = off_t{8} << 20;
constexpr const char* kState = "state";
constexpr int kJobsApplicationId = 0x5445534a;  // "TESJ"
/// How long a blob that no job needs is kept: time to notice that the database is not the latest.
constexpr int64_t kUnusedSeconds = 7 * 24 * 3600;
/// Pages that are given back to the disk in one transaction.
constexpr int kPagesAtATime = 128;

/// The folder, with all that must be in it before the database is opened.
const fs::path& made(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder / "blobs", error);
  if (!error) return folder;
  const std::string what = fmt::format("--store: '{}': {}; expected a folder to write to",
                                       folder.string(), error.message());
  const bool forbidden = error == std::errc::permission_denied ||
                         error == std::errc::operation_not_permitted ||
                         error == std::errc::read_only_file_system;
  throw is_temporary(error.value()) && !forbidden ? temporary_error(what) : usage_error(what);
}

/// What the file `state` says: which store it belongs to, and the largest number of a job there.
struct State {
  uint64_t farm = 0, last_job = 0;
  friend bool operator==(const State&, const State&) = default;
};

/// Nothing where there is no such file.
std::optional<State> read_state(const fs::path& file) {
  const OwnedDescriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (descriptor.get() < 0 && errno == ENOENT) return std::nullopt;
  char text[128] = {};
  if (descriptor.get() < 0 || ::read(descriptor.get(), text, sizeof text - 1) < 0) {
    throw temporary_error(fmt::format("'{}' cannot be read: {}; expected what a store has had",
                                      file.string(), std::strerror(errno)));
  }
  State state;
  if (std::sscanf(text, "farm %" SCNu64 "\nlast_job %" SCNu64, &state.farm, &state.last_job) != 2) {
    throw usage_error(fmt::format(
        "'{}' is damaged; expected what a store has had: delete it if farm.db is the latest",
        file.string()));
  }
  return state;
}

SqliteDatabase::Kind kind_in(const fs::path& folder, bool has_blobs) {
  const auto state = read_state(folder / kState);
  return {.application_id = kJobsApplicationId,
          .format = 3,
          .upgrade = TileTable::upgrade(),
          .must_exist = has_blobs || (state && state->last_job > 0),
          .what = "a store",
          .fails = "cannot keep jobs and tiles",
          .remedy =
              "restore a copy with the farm.db-wal that was beside it (without any, if there was "
              "none) and leave the rest of the folder as it is, or serve another folder"};
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

int64_t seconds_since_1970() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

SqliteJobStore::SqliteJobStore(const fs::path& folder)
    : folder_(made(folder)),
      blobs_(folder / "blobs"),
      database_(folder / "farm.db", kind_in(folder, !blobs_.list().empty())),
      tiles_(database_) {
  database_.execute("CREATE TABLE IF NOT EXISTS jobs (job INTEGER PRIMARY KEY, kept BLOB)");
  database_.execute(
      "CREATE TABLE IF NOT EXISTS ends (job INT, frame INT, kept BLOB, PRIMARY KEY (job, frame))");
  database_.execute("CREATE TABLE IF NOT EXISTS numbers (name TEXT PRIMARY KEY, value INT)");
  database_.execute("CREATE TABLE IF NOT EXISTS unused (blob TEXT PRIMARY KEY, since INT)");
  const SqliteDatabase::Flushed flushed(database_);
  if (number("farm") == 0) {
    std::random_device random;
    set_number("farm", (uint64_t{random()} << 31 | random()) | 1);
  }
  farm_ = number("farm");
  check_state();
  make_reserve();
  give_back(std::chrono::seconds(1));
}

void SqliteJobStore::check_state() {
  const State known{farm_, last_job()};
  const auto state = read_state(folder_ / kState);
  if (state == known) return;
  if (state && state->last_job > 0) {
    const std::string what = state->farm != farm_ ? "is another store's"
                             : state->last_job > known.last_job
                                 ? fmt::format("has had jobs up to {}, its folder up to {}",
                                               known.last_job, state->last_job)
                                 : "";
    if (!what.empty()) {
      throw usage_error(fmt::format(
          "'{}' {}; expected the latest, with the farm.db-wal that was beside it: restore both, or "
          "delete '{}' to go on without the jobs that are missing",
          (folder_ / "farm.db").string(), what, (folder_ / kState).string()));
    }
  }
  // Of a copy from another time, it is not known since when it has no use for blobs.
  if (!state) database_.execute("DELETE FROM unused");
  write_state(known.last_job);
}

void SqliteJobStore::write_state(uint64_t last_job) const {
  const SpareDescriptors spare;
  try {
    write_output_file(folder_ / kState, fmt::format("farm {}\nlast_job {}\n", farm_, last_job));
  } catch (const Error&) {
    // On a full disk it says less than it could: fewer losses are noticed, none is made up.
  }
}

void SqliteJobStore::make_reserve() const {
  const SpareDescriptors spare;
  const fs::path path = folder_ / kReserve;
  const OwnedDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
  if (file.get() < 0) return;
  // Where there is no room to be set apart, none is taken.
  if (::posix_fallocate(file.get(), 0, kReserveBytes) != 0) ::unlink(path.c_str());
}

template <typename Write>
void SqliteJobStore::write_at_last(const Write& write) {
  try {
    write();
  } catch (const Error&) {
    std::error_code ignored;
    if (!fs::remove(folder_ / kReserve, ignored)) throw;
    // The log has taken all the room that there was: from now on it is written anew in it.
    database_.checkpoint(false);
    write();
  }
}

void SqliteJobStore::give_back(Time most) {
  if (!may_give_back_) return;
  const Time until = monotonic_now() + most;
  try {
    while (may_give_back_ && monotonic_now() < until) {
      may_give_back_ = database_.give_back(kPagesAtATime);
    }
    if (may_give_back_) return;
    database_.checkpoint(true);
    make_reserve();
  } catch (const Error&) {
    // There is no room to make room with: when a job is forgotten the next time.
    may_give_back_ = false;
  }
}

void SqliteJobStore::tidy() {
  give_back(std::chrono::milliseconds(10));
  make_reserve();
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
    try {
      if (!kept) throw usage_error("its row is no job");
      if (kept->job() != static_cast<uint64_t>(rows.integer(0))) {
        throw usage_error(fmt::format("its row is of job {}", kept->job()));
      }
      check_kept_job(*kept);
    } catch (const Error& error) {
      leaves_out_jobs_ = true;
      spdlog::error("job {} of the store is damaged, and left out: {}; its row is kept",
                    rows.integer(0), error.what());
      continue;
    }
    Statement ends(database_, "SELECT frame, kept FROM ends WHERE job = ? ORDER BY frame");
    ends.bind(rows.integer(0));
    while (ends.step()) {
      // A frame whose end cannot be read ends again, from its tiles.
      auto end = parse_job_end(ends.blob(1));
      if (!end || ends.integer(0) < 0 || ends.integer(0) >= kept->request().frames_size()) continue;
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

uint64_t SqliteJobStore::last_job() {
  // Of rows, too: a number that was given twice would be the end of one of the two jobs.
  Statement rows(database_, "SELECT max(job) FROM jobs WHERE job <= ?");
  rows.bind(static_cast<int64_t>(kMaxJobNumber)).step();
  const uint64_t kept = number("last_job");
  return std::max(kept <= kMaxJobNumber ? kept : 0,
                  static_cast<uint64_t>(std::max<int64_t>(0, rows.integer(0))));
}

void SqliteJobStore::save(const v1::KeptJob& job) {
  v1::KeptJob without_ends = job;
  without_ends.clear_ends();
  const std::string kept = without_ends.SerializeAsString();
  const Timed timed(commit_seconds_);
  const SqliteDatabase::Flushed flushed(database_);
  const bool is_new = job.job() > last_job();
  const auto write = [&] {
    // The number first: one that is skipped does no harm, one that is given twice would.
    if (is_new) set_number("last_job", job.job());
    Statement(database_, "INSERT OR REPLACE INTO jobs VALUES (?, ?)")
        .bind(static_cast<int64_t>(job.job()))
        .bind_blob(kept)
        .step();
  };
  if (job.cancelled()) return write_at_last(write);
  write();
  // Afterwards, so that it never tells of a job that the database does not know.
  if (is_new) write_state(job.job());
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

void SqliteJobStore::remove(uint64_t job, const std::vector<Digest>& tile_keys,
                            const std::vector<Digest>& blobs) {
  // The job first: what else is left behind by a kill is found by keep_only_blobs(), or is tiles
  // that the same frame would take up again.
  for (const char* text : {"DELETE FROM jobs WHERE job = ?", "DELETE FROM ends WHERE job = ?"}) {
    write_at_last([&] { Statement(database_, text).bind(static_cast<int64_t>(job)).step(); });
  }
  // A job that is left out since its row is damaged may need them too.
  if (!leaves_out_jobs_) {
    for (const Digest& blob : blobs) blobs_.remove(blob);
    // Last, as deleting from the database takes room at first.
    for (const Digest& key : tile_keys) drop_all(key);
  }
  give_back(std::chrono::milliseconds(100));
  make_reserve();
}

void SqliteJobStore::drop_all(const Digest& key) {
  write_at_last([&] { tiles_.drop_all(key); });
  may_give_back_ = true;
}

void SqliteJobStore::put_blob(const Digest& digest, const BlobData& data) {
  const Timed timed(commit_seconds_);
  blobs_.put(digest, data);
}

void SqliteJobStore::keep_only_blobs(const std::unordered_set<Digest>& digests) {
  blobs_.remove_unfinished();
  // Nobody knows which blobs a job needs that cannot be read.
  if (leaves_out_jobs_) return;
  const int64_t now = seconds_since_1970();
  // When each was first found without use; of one that was needed meanwhile, found so again.
  std::map<Digest, int64_t> since;
  for (const Digest& blob : blobs_.list()) {
    if (!digests.contains(blob)) since.emplace(blob, now);
  }
  try {
    SqliteDatabase::Transaction transaction(database_);
    {
      Statement rows(database_, "SELECT blob, since FROM unused");
      while (rows.step()) {
        const auto it = since.find(Digest::from_hex(std::string(rows.blob(0))));
        if (it != since.end()) it->second = std::min(now, rows.integer(1));
      }
    }
    std::vector<Digest> old;
    database_.execute("DELETE FROM unused");
    for (const auto& [blob, first] : since) {
      if (now - first >= kUnusedSeconds) {
        old.push_back(blob);
        continue;
      }
      const std::string hex = blob.hex();
      Statement(database_, "INSERT INTO unused VALUES (?, ?)").bind(hex).bind(first).step();
    }
    transaction.commit();
    for (const Digest& blob : old) blobs_.remove(blob);
  } catch (const Error&) {
    // On a full disk: then none is deleted.
  }
}

}  // namespace tessera
