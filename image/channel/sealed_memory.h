#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace tessera {

/// Memory that a program fills with a file, or its image codec with pixels, and that is handed to
/// the other instead of being copied.
class SealedMemory {
 public:
  /// Zeros; nothing where there is none to be had, as under a limit on the sizes of files.
  static std::optional<SealedMemory> create(uint64_t bytes);
  SealedMemory(SealedMemory&& other) noexcept;
  SealedMemory& operator=(SealedMemory&& other) noexcept;
  ~SealedMemory();

  std::span<char> bytes() const { return bytes_; }
  /// Says that `part` of bytes() is done with: unmapping it is work, which threads can share.
  static void finish(std::span<char> part);
  /// Takes away the right to write from everybody, this process too, which has no bytes() from now
  /// on. Returns what they are mapped by, as long as this object lives; -1: it cannot be.
  int seal();

 private:
  SealedMemory(int descriptor, std::span<char> bytes) : descriptor_(descriptor), bytes_(bytes) {}
  void unmap();

  int descriptor_;
  std::span<char> bytes_;
};

}  // namespace tessera
