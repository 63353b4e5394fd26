#include "worker/result_spool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "base/log.h"
#include "proto/wire/frame.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".results";
constexpr auto kLongestLeft = std::chrono::hours(24);
// No process says hello so often: sessions of the next begin behind those of the last.
constexpr uint64_t kSessionsOfAProcess = uint64_t{1} << 20;

bool write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = write(file, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(count));
  }
  return true;
}

bool read_at(int file, std::span<std::byte> bytes, uint64_t offset) {
  return pread(file, bytes.data(), bytes.size(), static_cast<off_t>(offset)) ==
         static_cast<ssize_t>(bytes.size());
}

bool is_result(const v1::Envelope& message) {
  return message.has_tile_band() || message.has_tile_failed();
}

}  // namespace

ResultSpool::ResultSpool(fs::path folder, uint64_t budget_bytes, std::string numerics_id)
    : folder_(std::move(folder)),
      budget_bytes_(budget_bytes),
      numerics_id_(std::move(numerics_id)) {
  std::error_code failure;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder_, failure)) {
    if (entry.path().extension() == kEnding) found.push_back(entry.path());
  }
  for (const fs::path& path : found) {
    if (take_over(path)) return;
  }
}

ResultSpool::~ResultSpool() { close_file(); }

void ResultSpool::close_file() {
  if (file_ >= 0) close(file_);
  file_ = -1;
  size_ = 0;
}

void ResultSpool::clear() {
  if (file_ >= 0) unlink(path_.c_str());
  close_file();
}

bool ResultSpool::take_over(const fs::path& path) {
  file_ = open(path.c_str(), O_RDWR | O_APPEND | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file_ < 0) return false;
  path_ = path;
  struct stat status {};
  // Its worker lives, or another has taken it over.
  if (flock(file_, LOCK_EX | LOCK_NB) != 0 || fstat(file_, &status) != 0 ||
      !S_ISREG(status.st_mode) || status.st_nlink == 0) {
    close_file();
    return false;
  }
  size_ = static_cast<uint64_t>(status.st_size);
  uint64_t offset = 0;
  const auto hello = read(offset), welcome = read(offset);
  const auto age =
      std::chrono::system_clock::now() - std::chrono::system_clock::from_time_t(status.st_mtime);
  if (!hello || !hello->has_hello() || hello->hello().numerics_id() != numerics_id_ ||
      hello->hello().worker_id() == 0 || !welcome || !welcome->has_welcome() ||
      age > kLongestLeft || size_ > budget_bytes_) {
    clear();
    return false;
  }
  farm_ = welcome->welcome().farm();
  origin_ =
      Origin{hello->hello().worker_id(), hello->hello().session() + kSessionsOfAProcess, farm_};
  return true;
}

std::optional<v1::Envelope> ResultSpool::read(uint64_t& offset) const {
  // A whole header, then as much as that says: decode() has the rest of the checks.
  std::vector<std::byte> frame(kFrameHeaderSize);
  if (offset + frame.size() > size_ || !read_at(file_, frame, offset)) return std::nullopt;
  const auto length = frame_length(frame);
  if (!length || *length > size_ - offset) return std::nullopt;
  frame.resize(*length);
  if (!read_at(file_, frame, offset)) return std::nullopt;
  offset += frame.size();
  return decode(frame, kMaxFrame);
}

bool ResultSpool::create(const v1::Hello& hello, uint64_t farm) {
  path_ = folder_ / fmt::format("{:016x}{}", hello.worker_id(), kEnding);
  file_ = open(path_.c_str(), O_RDWR | O_APPEND | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file_ < 0) return false;
  farm_ = farm;
  v1::Envelope first, second;
  *first.mutable_hello() = hello;
  second.mutable_welcome()->set_farm(farm);
  return flock(file_, LOCK_EX | LOCK_NB) == 0 && append(first) && append(second);
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

void ResultSpool::keep(const v1::Hello& hello, uint64_t farm, const v1::Envelope& result) {
  if (!is_result(result)) return;
  if (file_ >= 0 && farm_ != farm) clear();
  if (size_ + result.ByteSizeLong() + kFrameHeaderSize > budget_bytes_) return;
  if ((file_ >= 0 || create(hello, farm)) && append(result)) return;
  const int cause = errno;
  if (!std::exchange(complained_, true)) {
    spdlog::warn("results cannot be kept in '{}': {}; their tiles will be traced again",
                 folder_.string(), std::strerror(cause));
  }
}

size_t ResultSpool::hand_in(uint64_t farm, const std::function<void(v1::Envelope)>& take) {
  if (file_ < 0) return 0;
  std::vector<v1::Envelope> results;
  uint64_t offset = 0;
  while (farm == farm_) {
    auto message = read(offset);
    if (!message) break;
    if (is_result(*message)) results.push_back(std::move(*message));
  }
  clear();
  for (v1::Envelope& result : results) take(std::move(result));
  return results.size();
}

}  // namespace tessera
