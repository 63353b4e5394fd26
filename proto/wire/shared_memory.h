#pragma once

#include <cstdint>

#include "base/blob.h"
#include "proto/wire/blob_store.h"

namespace tessera {

/// Memory without a name that other processes of this user map by the place that they are told, and
/// that nobody can change. It ends with the last process that has it, however that ends.

/// Moves the larger blobs there, whose own memory is then free as soon as nobody else holds it.
/// Those for which there is no room stay as they are.
void share_large_blobs(BlobStore& blobs);

/// Where another process has such a blob.
struct BlobPlace {
  int process = 0;
  int descriptor = 0;
};
/// The blob there, or null where nothing is there that could not be changed afterwards. Its bytes
/// are not verified.
BlobData map_shared_blob(const BlobPlace& place, uint64_t size);

}  // namespace tessera
