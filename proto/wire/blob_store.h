#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/blob.h"
#include "base/digest.h"

namespace tessera {

/// The blobs of a scene in memory, by digest. Not thread-safe while it is being filled.
class BlobStore {
 public:
  /// Keeps `bytes` and returns their name.
  Digest put(BlobData bytes);
  Digest put(std::vector<std::byte> bytes) { return put(make_blob(std::move(bytes))); }
  /// Keeps `bytes` under a name that the caller has verified.
  void put(const Digest& digest, BlobData bytes);
  /// Holds the same bytes elsewhere from now on.
  void replace(const Digest& digest, BlobData bytes) { blobs_[digest] = std::move(bytes); }
  /// The blob of that name, or null.
  BlobData find(const Digest& digest) const;
  size_t size() const { return blobs_.size(); }
  const std::unordered_map<Digest, BlobData>& all() const { return blobs_; }

 private:
  std::unordered_map<Digest, BlobData> blobs_;
};

}  // namespace tessera
