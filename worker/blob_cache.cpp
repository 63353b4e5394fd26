#include "worker/blob_cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/log.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kUnfinished = ".tmp";

/// The process that writes "DIGEST.PROCESS.tmp"; nothing for another name.
std::optional<pid_t> writer_of(std::string_view name) {
  if (!name.ends_with(kUnfinished)) return std::nullopt;
  name.remove_suffix(kUnfinished.size());
  const size_t dot = name.rfind('.');
  if (dot == std::string_view::npos || !Digest::parse(name.substr(0, dot))) return std::nullopt;
  pid_t process = 0;
  const auto [end, error] =
      std::from_chars(name.data() + dot + 1, name.data() + name.size(), process);
  return error == std::errc() && process > 0 ? std::optional(process) : std::nullopt;
}

void sync_folder(const fs::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

}  // namespace

bool make_room_in_cache(const fs::path& folder, uint64_t budget_bytes, uint64_t bytes) {
  struct File {
    fs::file_time_type used;
    uint64_t size = 0;
    fs::path path;
  };
  std::vector<File> files;
  uint64_t sum = bytes, kept = bytes;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder, failure)) {
    std::error_code gone;
    File file{entry.last_write_time(gone), 0, entry.path()};
    if (!gone) file.size = entry.file_size(gone);
    const bool is_blob = Digest::parse(entry.path().filename().string()).has_value();
    if (gone || (!is_blob && entry.path().extension() != kResultsEnding)) continue;
    sum += file.size;
    if (!is_blob) {
      kept += file.size;
      continue;
    }
    files.push_back(std::move(file));
  }
  if (kept > budget_bytes) return false;
  std::sort(files.begin(), files.end(),
            [](const File& a, const File& b) { return a.used < b.used; });
  // Who has one of them mapped keeps its pages.
  for (size_t i = 0; i < files.size() && sum > budget_bytes; ++i) {
    std::error_code ignored;
    if (fs::remove(files[i].path, ignored)) sum -= files[i].size;
  }
  return sum <= budget_bytes;
}

BlobCache::BlobCache(fs::path folder, uint64_t budget_bytes)
    : folder_(std::move(folder)), budget_bytes_(budget_bytes) {
  std::error_code failure;
  fs::create_directories(folder_.parent_path(), failure);
  if (mkdir(folder_.c_str(), 0700) != 0 && errno != EEXIST) {
    throw usage_error(
        fmt::format("--cache: cannot make '{}': {}", folder_.string(), std::strerror(errno)));
  }
  struct stat status {};
  if (stat(folder_.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) {
    throw usage_error(fmt::format("--cache: '{}' is no folder", folder_.string()));
  }
  if (status.st_uid != geteuid() || (status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    throw usage_error(
        fmt::format("--cache: others can write into '{}'; expected a folder of this user alone",
                    folder_.string()));
  }
  remove_unfinished();
}

void BlobCache::remove_unfinished() {
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder_, failure)) {
    const auto writer = writer_of(entry.path().filename().string());
    std::error_code ignored;
    if (writer && kill(*writer, 0) != 0 && errno == ESRCH) fs::remove(entry.path(), ignored);
  }
}

fs::path BlobCache::path_of(const Digest& digest) const { return folder_ / digest.hex(); }

BlobData BlobCache::find(const Digest& digest, uint64_t size) {
  const fs::path path = path_of(digest);
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0) return nullptr;
  futimens(descriptor, nullptr);  // used now
  const BlobData blob = Blob::map(descriptor, size);
  if (blob && Digest::of(*blob) == digest) return blob;
  spdlog::warn("'{}' in the cache is damaged; it is fetched again", path.string());
  unlink(path.c_str());
  return nullptr;
}

void BlobCache::keep(const Digest& digest, const Blob& blob) {
  if (blob.size() == 0 || blob.size() > budget_bytes_) return;
  const fs::path path = path_of(digest);
  if (access(path.c_str(), F_OK) == 0) return;
  if (make_room_in_cache(folder_, budget_bytes_, blob.size())) write(path, blob);
}

bool BlobCache::write(const fs::path& path, const Blob& blob) {
  const std::string unfinished = fmt::format("{}.{}{}", path.string(), getpid(), kUnfinished);
  const int descriptor = open(unfinished.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0) {
    complain(std::strerror(errno));
    return false;
  }
  size_t written = 0;
  while (written < blob.size()) {
    const ssize_t count = ::write(descriptor, blob.data() + written, blob.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    written += static_cast<size_t>(count);
  }
  const bool good = written == blob.size() && fsync(descriptor) == 0 &&
                    rename(unfinished.c_str(), path.c_str()) == 0;
  const int cause = errno;
  close(descriptor);
  if (good) {
    sync_folder(folder_);
    return true;
  }
  unlink(unfinished.c_str());
  complain(std::strerror(cause));
  return false;
}

void BlobCache::complain(const std::string& why) {
  if (std::exchange(complained_, true)) return;
  spdlog::warn("the cache in '{}' keeps nothing new: {}; the worker goes on without",
               folder_.string(), why);
}

}  // namespace tessera
