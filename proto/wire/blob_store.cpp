#include "proto/wire/blob_store.h"

#include <utility>

namespace tessera {

Digest BlobStore::put(BlobData bytes) {
  const Digest digest = Digest::of(*bytes);
  blobs_.try_emplace(digest, std::move(bytes));
  return digest;
}

void BlobStore::put(const Digest& digest, BlobData bytes) {
  blobs_.try_emplace(digest, std::move(bytes));
}

BlobData BlobStore::find(const Digest& digest) const {
  const auto it = blobs_.find(digest);
  return it == blobs_.end() ? nullptr : it->second;
}

}  // namespace tessera
