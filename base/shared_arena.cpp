#include "base/shared_arena.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/open_file.h"

namespace tessera {
namespace {

using std::chrono::microseconds;

constexpr microseconds kLongestWait = std::chrono::seconds(30);
constexpr uint64_t kMaxThings = 4096;
constexpr uint64_t kMaxBytes = uint64_t{4} << 30;

// The file: how many things, then where each is, then the things.
struct Entry {
  Digest key;
  uint64_t begin = 0;
  uint64_t size = 0;
};
constexpr uint64_t kThings = sizeof(uint64_t) + kMaxThings * sizeof(Entry);

// Locks are of bytes far behind the file's end: one for the table, one for each key.
constexpr off_t kTableLock = off_t{1} << 60;
off_t lock_of(const Digest& key) {
  uint64_t number = 0;
  std::memcpy(&number, key.bytes.data(), sizeof number);
  return kTableLock + 1 + static_cast<off_t>(number >> 5);
}

/// Those of an open file description, which end with it, however its process ends.
bool set_lock(int file, short type, off_t place) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = place;
  lock.l_len = 1;
  return fcntl(file, F_OFD_SETLK, &lock) == 0;
}

bool wait_for_lock(int file, off_t place) {
  microseconds waited{0}, pause{50};
  while (!set_lock(file, F_WRLCK, place)) {
    if ((errno != EAGAIN && errno != EACCES && errno != EINTR) || waited >= kLongestWait) {
      return false;
    }
    std::this_thread::sleep_for(pause);
    waited += pause;
    pause = std::min(pause * 2, microseconds{2000});
  }
  return true;
}

template <typename T>
std::span<std::byte> bytes_of(T& value) {
  return std::as_writable_bytes(std::span(&value, 1));
}

/// Empty where nothing was published yet.
std::vector<Entry> read_table(int file) {
  uint64_t count = 0;
  if (!read_all_at(file, 0, bytes_of(count))) return {};
  std::vector<Entry> entries(std::min(count, kMaxThings));
  if (!read_all_at(file, sizeof count, std::as_writable_bytes(std::span(entries)))) return {};
  return entries;
}

}  // namespace

OwnedDescriptor SharedArena::create() {
  OwnedDescriptor made(memfd_create("tessera", MFD_CLOEXEC));
  if (made.get() < 0) {
    throw render_error(fmt::format("no memory can be shared: {}", std::strerror(errno)));
  }
  return made;
}

SharedArena::Claim SharedArena::claim(const Digest& key) const {
  Claim claim;
  claim.key_ = key;
  // Opened anew, or its locks would be those of all who inherited the descriptor.
  const std::string path = fmt::format("/proc/self/fd/{}", descriptor_);
  OwnedDescriptor file(open(path.c_str(), O_RDWR | O_CLOEXEC));
  if (file.get() < 0 || !wait_for_lock(file.get(), lock_of(key))) return claim;
  for (const Entry& entry : read_table(file.get())) {
    if (entry.key != key) continue;
    claim.begin_ = entry.begin;
    claim.size_ = entry.size;
    // It is there: others need not wait while it is read.
    set_lock(file.get(), F_UNLCK, lock_of(key));
    break;
  }
  claim.file_ = std::move(file);
  return claim;
}

bool SharedArena::Claim::read(uint64_t from, std::span<std::byte> to) const {
  return size_ && from <= *size_ && to.size() <= *size_ - from &&
         read_all_at(file_.get(), begin_ + from, to);
}

void SharedArena::Claim::publish(std::span<const std::span<const std::byte>> parts) {
  if (size_ || file_.get() < 0 || !wait_for_lock(file_.get(), kTableLock)) return;
  const std::vector<Entry> entries = read_table(file_.get());
  Entry entry{key_, kThings, 0};
  if (!entries.empty()) entry.begin = entries.back().begin + entries.back().size;
  for (const auto part : parts) entry.size += part.size();
  if (entries.size() < kMaxThings && entry.begin + entry.size <= kMaxBytes) {
    uint64_t at = entry.begin;
    bool written = true;
    for (const auto part : parts) {
      written = written && write_all_at(file_.get(), at, part);
      at += part.size();
    }
    // The count last: what is half written is not there.
    uint64_t count = entries.size() + 1;
    if (written &&
        write_all_at(file_.get(), sizeof count + entries.size() * sizeof entry, bytes_of(entry))) {
      write_all_at(file_.get(), 0, bytes_of(count));
    }
  }
  set_lock(file_.get(), F_UNLCK, kTableLock);
  set_lock(file_.get(), F_UNLCK, lock_of(key_));
}

}  // namespace tessera
