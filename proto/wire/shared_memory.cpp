#include "proto/wire/shared_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "base/open_file.h"

namespace tessera {
namespace {

// Each takes a descriptor of ours: only those whose copies would hurt.
constexpr size_t kLeastBytes = size_t{256} << 10;
constexpr size_t kMostBlobs = 64;

BlobData shared_copy(const Blob& blob) {
  constexpr int kSeals = F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
  OwnedDescriptor memory(memfd_create("tessera-blob", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  const bool is_done = memory.get() >= 0 && write_all(memory.get(), {blob.data(), blob.size()}) &&
                       fcntl(memory.get(), F_ADD_SEALS, kSeals) == 0;
  return is_done ? Blob::map(std::move(memory), blob.size()) : nullptr;
}

}  // namespace

void share_large_blobs(BlobStore& blobs) {
  std::vector<std::pair<size_t, Digest>> large;
  for (const auto& [digest, data] : blobs.all()) {
    if (data->size() >= kLeastBytes) large.emplace_back(data->size(), digest);
  }
  std::sort(large.rbegin(), large.rend());
  if (large.size() > kMostBlobs) large.resize(kMostBlobs);
  for (const auto& [size, digest] : large) {
    const BlobData blob = blobs.find(digest);
    if (blob->descriptor() >= 0) continue;
    if (BlobData shared = shared_copy(*blob)) blobs.replace(digest, std::move(shared));
  }
}

BlobData map_shared_blob(const BlobPlace& place, uint64_t size) {
  const std::string path = fmt::format("/proc/{}/fd/{}", place.process, place.descriptor);
  return Blob::map_sealed(
      OwnedDescriptor(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)), size);
}

}  // namespace tessera
