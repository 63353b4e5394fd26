#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace tessera {

/// Memory that the image codec fills with pixels and hands over instead of copying them.
class SharedPixels {
 public:
  /// Zeros; nothing where there is none to be had, as under a limit on the sizes of files.
  static std::optional<SharedPixels> create(uint64_t bytes);
  SharedPixels(SharedPixels&& other) noexcept;
  SharedPixels& operator=(SharedPixels&& other) noexcept;
  ~SharedPixels();

  std::span<char> bytes() const { return pixels_; }
  /// Says that `part` of bytes() is done with: unmapping it is work, which threads can share.
  static void finish(std::span<char> part);
  /// Takes away the right to write from everybody, this process too, which has no bytes() from now
  /// on. Returns what they are mapped by, as long as this object lives; -1: it cannot be.
  int seal();

 private:
  SharedPixels(int descriptor, std::span<char> pixels) : descriptor_(descriptor), pixels_(pixels) {}
  void unmap();

  int descriptor_;
  std::span<char> pixels_;
};

}  // namespace tessera
