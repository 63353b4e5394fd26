#include "base/folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <random>

#include "base/descriptors.h"
#include "base/owned_descriptor.h"

namespace tessera {

namespace fs = std::filesystem;

std::vector<fs::directory_entry> entries_in(const fs::path& folder, size_t most) {
  std::vector<fs::directory_entry> entries;
  std::error_code failure;
  // Not by a loop over its range, whose steps throw.
  for (fs::directory_iterator it(folder, failure), end;
       !failure && it != end && entries.size() < most; it.increment(failure))
    entries.push_back(*it);
  return entries;
}

void sync_folder(const fs::path& folder) {
  const OwnedDescriptor open_folder = [&] {
    const SpareDescriptors spare;
    return OwnedDescriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  }();
  if (open_folder.get() >= 0) ::fsync(open_folder.get());
}

std::string unique_name() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

}  // namespace tessera
