#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "base/owned_descriptor.h"

namespace tessera {

class Blob;
/// Immutable bytes, shared by whoever holds them; the bytes never move.
using BlobData = std::shared_ptr<const Blob>;

/// Bytes in memory of this process alone, or of a mapped file, whose pages all processes that map
/// it share.
class Blob {
 public:
  explicit Blob(std::vector<std::byte> bytes);
  ~Blob();
  Blob(const Blob&) = delete;
  Blob& operator=(const Blob&) = delete;

  /// The whole file, which is closed when the blob ends; null where there is none, it is not `size`
  /// bytes long or cannot be mapped. Nobody may change or cut it.
  static BlobData map(OwnedDescriptor file, uint64_t size);
  /// The same of memory that another process made; null too where it could still be changed.
  static BlobData map_sealed(OwnedDescriptor file, uint64_t size);

  /// Memory of somebody else's, who leaves it as it is; `owner` is let go of with the blob.
  static BlobData share(std::shared_ptr<const void> owner, std::span<const std::byte> bytes);

  const std::byte* data() const { return data_; }
  size_t size() const { return size_; }
  const std::byte* begin() const { return data_; }
  const std::byte* end() const { return data_ + size_; }
  /// Of the mapped file; -1: there is none.
  int descriptor() const { return file_.get(); }

  friend bool operator==(const Blob& a, const Blob& b);

 private:
  std::vector<std::byte> owned_;
  const std::byte* data_;
  size_t size_;
  OwnedDescriptor file_;
  std::shared_ptr<const void> owner_;  ///< of memory that is not the blob's own
};

inline BlobData make_blob(std::vector<std::byte> bytes) {
  return std::make_shared<const Blob>(std::move(bytes));
}
inline BlobData copy_to_blob(std::span<const std::byte> bytes) {
  return make_blob({bytes.begin(), bytes.end()});
}

}  // namespace tessera
