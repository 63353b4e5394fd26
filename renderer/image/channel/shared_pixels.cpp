#include "renderer/image/channel/shared_pixels.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <utility>

namespace tessera {

std::optional<SharedPixels> SharedPixels::create(uint64_t bytes) {
  const int descriptor = memfd_create("tessera-pixels", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (descriptor < 0) return std::nullopt;
  void* const data = ftruncate(descriptor, static_cast<off_t>(bytes)) == 0
                         ? mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0)
                         : MAP_FAILED;
  if (data != MAP_FAILED) return SharedPixels(descriptor, {static_cast<char*>(data), bytes});
  close(descriptor);
  return std::nullopt;
}

SharedPixels::SharedPixels(SharedPixels&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      pixels_(std::exchange(other.pixels_, {})) {}

SharedPixels& SharedPixels::operator=(SharedPixels&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(pixels_, other.pixels_);
  return *this;
}

SharedPixels::~SharedPixels() {
  unmap();
  if (descriptor_ >= 0) close(descriptor_);
}

void SharedPixels::finish(std::span<char> part) {
  const auto page = static_cast<uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto begin = reinterpret_cast<uintptr_t>(part.data());
  const uintptr_t first = (begin + page - 1) / page * page,
                  end = (begin + part.size()) / page * page;
  // Only of this process: the pages stay, and so does what is in them.
  if (first < end) madvise(reinterpret_cast<void*>(first), end - first, MADV_DONTNEED);
}

int SharedPixels::seal() {
  unmap();
  constexpr int kSeals = F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
  return fcntl(descriptor_, F_ADD_SEALS, kSeals) == 0 ? descriptor_ : -1;
}

void SharedPixels::unmap() {
  if (!pixels_.empty()) munmap(pixels_.data(), pixels_.size());
  pixels_ = {};
}

}  // namespace tessera
