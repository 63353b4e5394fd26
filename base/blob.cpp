#include "base/blob.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

namespace tessera {

Blob::Blob(std::vector<std::byte> bytes)
    : owned_(std::move(bytes)), data_(owned_.data()), size_(owned_.size()) {}

Blob::~Blob() {
  if (descriptor_ < 0) return;
  // While a piece goes, other threads wait where they begin, end or take memory.
  constexpr size_t kPiece = size_t{4} << 20;
  for (size_t at = 0; at < size_; at += kPiece) {
    munmap(const_cast<std::byte*>(data_) + at, std::min(kPiece, size_ - at));
  }
  close(descriptor_);
}

BlobData Blob::map(int descriptor, uint64_t size) {
  struct stat status {};
  const bool right = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && size > 0 &&
                     static_cast<uint64_t>(status.st_size) == size;
  void* const data = right ? mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor, 0) : MAP_FAILED;
  if (data == MAP_FAILED) {
    close(descriptor);
    return nullptr;
  }
  return BlobData(new Blob(descriptor, static_cast<const std::byte*>(data), size));
}

BlobData Blob::map_sealed(int descriptor, uint64_t size) {
  constexpr int kSeals = F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW;
  if ((fcntl(descriptor, F_GET_SEALS) & kSeals) == kSeals) return map(descriptor, size);
  close(descriptor);
  return nullptr;
}

bool operator==(const Blob& a, const Blob& b) { return std::ranges::equal(a, b); }

}  // namespace tessera
