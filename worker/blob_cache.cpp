#include "worker/blob_cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/folder.h"
#include "base/log.h"
#include "base/open_file.h"
#include "base/owned_descriptor.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kUnfinished = ".tmp";

/// Whether it is one of "DIGEST.ANYTHING.tmp", which write() makes.
bool is_unfinished(std::string_view name) {
  constexpr size_t kDigits = 64;
  return name.ends_with(kUnfinished) && name.size() > kDigits && name[kDigits] == '.' &&
         Digest::parse(name.substr(0, kDigits));
}

/// Whoever writes a file holds it, so that others know a killed writer's from one under way.
bool hold(const OwnedDescriptor& file) {
  struct stat status {};
  return file.get() >= 0 && hold_alone(file.get(), status);
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
  for (const auto& entry : entries_in(folder)) {
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
  for (const auto& entry : entries_in(folder_)) {
    if (!is_unfinished(entry.path().filename().string())) continue;
    const OwnedDescriptor file(
        open(entry.path().c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
    if (hold(file)) unlink(entry.path().c_str());
  }
}

fs::path BlobCache::path_of(const Digest& digest) const { return folder_ / digest.hex(); }

BlobData BlobCache::find(const Digest& digest, uint64_t size) {
  const fs::path path = path_of(digest);
  OwnedDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (file.get() < 0) return nullptr;
  futimens(file.get(), nullptr);  // used now
  struct stat status {};
  if (fstat(file.get(), &status) != 0) return nullptr;
  if (S_ISREG(status.st_mode) && static_cast<uint64_t>(status.st_size) == size) {
    // A copy is what is verified: a mapped file could still be changed, or cut, afterwards.
    try {
      std::vector<std::byte> bytes(size);
      if (!read_all_at(file.get(), 0, bytes)) return nullptr;
      if (Digest::of(bytes) == digest) return make_blob(std::move(bytes));
    } catch (const std::bad_alloc&) {
      return nullptr;
    }
  }
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
  const std::string unfinished = fmt::format("{}.{}{}", path.string(), unique_name(), kUnfinished);
  const OwnedDescriptor file(
      open(unfinished.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (file.get() < 0) {
    complain(std::strerror(errno));
    return false;
  }
  if (!hold(file)) return false;  // another has just removed it
  if (write_all(file.get(), {blob.data(), blob.size()}) && fsync(file.get()) == 0 &&
      rename(unfinished.c_str(), path.c_str()) == 0) {
    sync_folder(folder_);
    return true;
  }
  const int cause = errno;
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
