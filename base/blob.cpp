#include "base/blob.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <utility>

namespace tessera {

Blob::Blob(std::vector<std::byte> bytes)
    : owned_(std::move(bytes)), data_(owned_.data()), size_(owned_.size()) {}

Blob::~Blob() {
  if (file_.get() < 0) return;
  // While a piece goes, other threads wait where they begin, end or take memory.
  constexpr size_t kPiece = size_t{4} << 20;
  for (size_t at = 0; at < size_; at += kPiece) {
    munmap(const_cast<std::byte*>(data_) + at, std::min(kPiece, size_ - at));
  }
}

BlobData Blob::map(OwnedDescriptor file, uint64_t size) {
  struct stat status {};
  const bool right = fstat(file.get(), &status) == 0 && S_ISREG(status.st_mode) && size > 0 &&
                     static_cast<uint64_t>(status.st_size) == size;
  if (!right) return nullptr;
  const auto blob = std::make_shared<Blob>(std::vector<std::byte>{});
  void* const data = mmap(nullptr, size, PROT_READ, MAP_SHARED, file.get(), 0);
  if (data == MAP_FAILED) return nullptr;
  blob->data_ = static_cast<const std::byte*>(data);
  blob->size_ = size;
  blob->file_ = std::move(file);
  return blob;
}

BlobData Blob::map_sealed(OwnedDescriptor file, uint64_t size) {
  constexpr int kSeals = F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW;
  const int seals = fcntl(file.get(), F_GET_SEALS);  // -1: of what can have none
  return seals >= 0 && (seals & kSeals) == kSeals ? map(std::move(file), size) : nullptr;
}

BlobData Blob::share(std::shared_ptr<const void> owner, std::span<const std::byte> bytes) {
  const auto blob = std::make_shared<Blob>(std::vector<std::byte>{});
  blob->data_ = bytes.data();
  blob->size_ = bytes.size();
  blob->owner_ = std::move(owner);
  return blob;
}

bool operator==(const Blob& a, const Blob& b) { return std::ranges::equal(a, b); }

}  // namespace tessera
