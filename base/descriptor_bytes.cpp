#include "base/descriptor_bytes.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <random>

namespace tessera {
namespace {

namespace fs = std::filesystem;

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

std::vector<fs::directory_entry> entries_in(const fs::path& folder) {
  std::vector<fs::directory_entry> entries;
  std::error_code failure;
  // Not by a loop over its range, whose steps throw.
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end;
       it.increment(failure))
    entries.push_back(*it);
  return entries;
}

std::string unique_name() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

}  // namespace tessera
