#include "base/open_file.h"

#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

namespace tessera {
namespace {

/// Until `step(done)`, which tells how many more bytes were done, has done them all.
template <typename Step>
bool all(size_t size, const Step& step) {
  for (size_t done = 0; done < size;) {
    const ssize_t count = step(done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    done += static_cast<size_t>(count);
  }
  return true;
}

}  // namespace

bool write_all(int descriptor, std::span<const std::byte> bytes) {
  return all(bytes.size(), [&](size_t done) {
    return ::write(descriptor, bytes.data() + done, bytes.size() - done);
  });
}

bool write_all_at(int descriptor, uint64_t at, std::span<const std::byte> bytes) {
  return all(bytes.size(), [&](size_t done) {
    return ::pwrite(descriptor, bytes.data() + done, bytes.size() - done,
                    static_cast<off_t>(at + done));
  });
}

bool read_all_at(int descriptor, uint64_t at, std::span<std::byte> bytes) {
  return all(bytes.size(), [&](size_t done) {
    return ::pread(descriptor, bytes.data() + done, bytes.size() - done,
                   static_cast<off_t>(at + done));
  });
}

bool hold_alone(int descriptor, struct stat& status) {
  return flock(descriptor, LOCK_EX | LOCK_NB) == 0 && fstat(descriptor, &status) == 0 &&
         status.st_nlink > 0;
}

}  // namespace tessera
