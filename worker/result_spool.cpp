#include "worker/result_spool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "base/folder.h"
#include "base/log.h"
#include "base/open_file.h"
#include "base/plural.h"
#include "proto/wire/frame.h"
#include "worker/blob_cache.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr auto kLongestLeft = std::chrono::hours(24);
constexpr uint64_t kMostBytes = uint64_t{1} << 30;
// How often one looks what else is in the folder.
constexpr uint64_t kStep = uint64_t{16} << 20;
// No process says hello so often: the sessions of each generation begin behind the last one's.
constexpr int kSessionBits = 20;

/// The message at `offset`, which then is that of the next.
std::optional<v1::Envelope> read_message(int file, uint64_t size, uint64_t& offset) {
  // A whole header, then as much as that says: decode() has the rest of the checks.
  std::vector<std::byte> frame(kFrameHeaderSize);
  if (offset + frame.size() > size || !read_all_at(file, offset, frame)) return std::nullopt;
  const auto length = frame_length(frame);
  if (!length || *length > size - offset) return std::nullopt;
  frame.resize(*length);
  if (!read_all_at(file, offset, frame)) return std::nullopt;
  offset += frame.size();
  return decode(frame, kMaxFrame);
}

bool is_result(const v1::Envelope& message) {
  return message.has_tile_band() || message.has_tile_failed();
}

std::string file_name(uint64_t worker_id, uint64_t generation) {
  return fmt::format("{:016x}.{}{}", worker_id, generation, kResultsEnding);
}

/// A file that an ended worker left.
struct LeftFile {
  int file = -1;  ///< locked
  uint64_t size = 0, worker_id = 0, generation = 0, farm = 0;
};

/// What a name of file_name() says.
bool parse_name(const fs::path& path, LeftFile& left) {
  unsigned long long id = 0, generation = 0;
  int length = 0;
  const std::string name = path.filename().string();
  if (std::sscanf(name.c_str(), "%16llx.%12llu%n", &id, &generation, &length) != 2) return false;
  left.worker_id = id;
  left.generation = generation;
  return name.substr(static_cast<size_t>(length)) == kResultsEnding;
}

bool is_of_use(LeftFile& left, const fs::path& path, const struct stat& status,
               const std::string& numerics_id) {
  const auto age =
      std::chrono::system_clock::now() - std::chrono::system_clock::from_time_t(status.st_mtime);
  if (!parse_name(path, left) || age > kLongestLeft) return false;
  uint64_t offset = 0;
  const auto first = read_message(left.file, left.size, offset);
  const auto second = read_message(left.file, left.size, offset);
  if (!first || !first->has_hello() || !second || !second->has_welcome()) return false;
  left.farm = second->welcome().farm();
  const v1::Hello& hello = first->hello();
  return hello.numerics_id() == numerics_id && hello.worker_id() == left.worker_id &&
         hello.worker_id() != 0;
}

/// Nothing if its worker lives, or another has taken it over, or it is of no use: then it is
/// removed.
std::optional<LeftFile> open_left(const fs::path& path, const std::string& numerics_id) {
  LeftFile left;
  left.file = open(path.c_str(), O_RDWR | O_APPEND | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (left.file < 0) return std::nullopt;
  struct stat status {};
  if (hold_alone(left.file, status) && S_ISREG(status.st_mode)) {
    left.size = static_cast<uint64_t>(status.st_size);
    if (is_of_use(left, path, status, numerics_id)) return left;
    spdlog::warn(
        "'{}', which an ended worker left, is removed: it is damaged, older than a day, or "
        "of a program that computes otherwise",
        path.string());
    unlink(path.c_str());
  }
  close(left.file);
  return std::nullopt;
}

}  // namespace

ResultSpool::ResultSpool(fs::path folder, uint64_t budget_bytes, std::string numerics_id)
    : folder_(std::move(folder)),
      budget_bytes_(budget_bytes),
      numerics_id_(std::move(numerics_id)) {
  take_over();
}

ResultSpool::~ResultSpool() { close_file(); }

void ResultSpool::close_file() {
  if (file_ >= 0) close(file_);
  file_ = -1;
  size_ = room_ = 0;
  full_ = false;
}

void ResultSpool::clear() {
  if (file_ >= 0) unlink(path_.c_str());
  close_file();
}

void ResultSpool::take_over() {
  std::vector<fs::path> found;
  for (const auto& entry : entries_in(folder_)) {
    if (entry.path().extension() == kResultsEnding) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  for (const fs::path& path : found) {
    const auto left = open_left(path, numerics_id_);
    if (!left) continue;
    // The name tells who comes next that the sessions of this generation are used.
    const fs::path next = folder_ / file_name(left->worker_id, left->generation + 1);
    if (rename(path.c_str(), next.c_str()) != 0) {
      close(left->file);
      continue;
    }
    path_ = next;
    file_ = left->file;
    size_ = left->size;
    farm_ = left->farm;
    origin_ = Origin{left->worker_id, (left->generation + 1) << kSessionBits, left->farm};
    // To look at the others would lock them, and another that starts now would pass them by.
    return;
  }
}

bool ResultSpool::create(const v1::Hello& hello, uint64_t farm) {
  path_ = folder_ / file_name(hello.worker_id(), hello.session() >> kSessionBits);
  file_ = open(path_.c_str(), O_RDWR | O_APPEND | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file_ < 0) return false;
  farm_ = farm;
  v1::Envelope first, second;
  *first.mutable_hello() = hello;
  second.mutable_welcome()->set_farm(farm);
  if (flock(file_, LOCK_EX | LOCK_NB) == 0 && append(first) && append(second)) return true;
  const int cause = errno;
  clear();
  errno = cause;
  return false;
}

bool ResultSpool::append(const v1::Envelope& message) {
  const Frame frame = encode(message);
  if (!write_all(file_, frame)) {
    const int cause = errno;
    // What is half there would hide what follows.
    if (ftruncate(file_, static_cast<off_t>(size_)) != 0) clear();
    errno = cause;
    return false;
  }
  size_ += frame.size();
  return true;
}

bool ResultSpool::has_room(uint64_t bytes) {
  if (full_) return false;
  if (size_ + bytes <= room_) return true;
  uint64_t others = 0;
  for (const auto& entry : entries_in(folder_)) {
    std::error_code gone;
    if (entry.path().extension() != kResultsEnding || entry.path() == path_) continue;
    const uint64_t size = entry.file_size(gone);
    if (!gone) others += size;
  }
  const uint64_t all = std::min(budget_bytes_, kMostBytes);
  const uint64_t most = all - std::min(all, others);
  full_ = size_ + bytes > most;
  if (full_) return false;
  room_ = std::min(size_ + std::max(bytes, kStep), most);
  make_room_in_cache(folder_, budget_bytes_, room_ - size_);
  return true;
}

bool ResultSpool::keep(const v1::Hello& hello, uint64_t farm, const v1::Envelope& result) {
  if (!is_result(result)) return false;
  if (file_ >= 0 && farm_ != farm) clear();
  if (!has_room(result.ByteSizeLong() + kFrameHeaderSize)) return false;
  if ((file_ >= 0 || create(hello, farm)) && append(result)) return true;
  const int cause = errno;
  if (!std::exchange(complained_, true)) {
    spdlog::warn("results cannot be kept in '{}': {}; their tiles will be traced again",
                 folder_.string(), std::strerror(cause));
  }
  return false;
}

size_t ResultSpool::hand_in(uint64_t farm, const std::function<void(v1::Envelope)>& take) {
  if (file_ < 0) {
    close_file();  // others may have made room meanwhile
    return 0;
  }
  std::vector<v1::Envelope> results;
  uint64_t offset = 0;
  while (farm == farm_ && offset < size_) {
    const uint64_t good = offset;
    auto message = read_message(file_, size_, offset);
    if (!message) {
      spdlog::warn("{} of results in '{}' are damaged; their tiles will be traced again",
                   counted(size_ - good, "byte"), path_.string());
      break;
    }
    if (is_result(*message)) results.push_back(std::move(*message));
  }
  clear();
  for (v1::Envelope& result : results) take(std::move(result));
  return results.size();
}

}  // namespace tessera
