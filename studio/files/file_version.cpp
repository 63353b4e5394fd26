#include "studio/files/file_version.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <vector>

#include "base/error.h"

namespace tessera {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

int64_t nanoseconds(const timespec& time) { return time.tv_sec * kSecond + time.tv_nsec; }

Digest hash_of(int file, std::string_view shown) {
  DigestStream stream;
  std::vector<std::byte> piece(Digest::kChunkBytes);
  for (off_t at = 0;;) {
    const ssize_t count = ::pread(file, piece.data(), piece.size(), at);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0)
      throw scene_error(fmt::format("'{}' cannot be read: {}", shown, std::strerror(errno)));
    if (count == 0) return stream.finish();
    stream.add(std::span(piece).first(static_cast<size_t>(count)));
    at += count;
  }
}

}  // namespace

FileStamp FileStamp::of(const struct stat& status) {
  const int64_t now = std::chrono::duration_cast<std::chrono::nanoseconds>(
                          std::chrono::system_clock::now().time_since_epoch())
                          .count();
  const int64_t changed = nanoseconds(status.st_ctim);
  return {.device = status.st_dev,
          .inode = status.st_ino,
          .size = static_cast<uint64_t>(status.st_size),
          .modified = nanoseconds(status.st_mtim),
          .changed = changed,
          // Within the clock of its file system it may be changed again and keep its times.
          .is_proof = changed + kSecond < now};
}

bool FileStamp::proves_same_as(const FileStamp& other) const {
  return is_proof && other.is_proof && device == other.device && inode == other.inode &&
         size == other.size && modified == other.modified && changed == other.changed;
}

std::string_view name_of(FileState state) {
  switch (state) {
    case FileState::same:
      return "same";
    case FileState::changed:
      return "changed";
    case FileState::deleted:
      break;
  }
  return "deleted";
}

FileState state_of(int file, const struct stat& status, FileVersion& known,
                   std::string_view shown) {
  const FileStamp stamp = FileStamp::of(status);
  if (stamp.proves_same_as(known.stamp)) return FileState::same;
  const bool has_stamp = known.stamp.inode != 0;
  if (has_stamp && stamp.size != known.stamp.size) return FileState::changed;
  if (known.hash == Digest{}) {
    const bool is_same =
        has_stamp && stamp.inode == known.stamp.inode && stamp.modified == known.stamp.modified;
    return is_same ? FileState::same : FileState::changed;
  }
  if (hash_of(file, shown) != known.hash) return FileState::changed;
  known.stamp = stamp;
  return FileState::same;
}

}  // namespace tessera
