#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/blob.h"
#include "base/digest.h"

namespace tessera {

/// What files of ResultSpool end in, which lie between the blobs of a cache.
inline constexpr char kResultsEnding[] = ".results";

/// Removes blobs, what was used longest ago first, until `bytes` more have room in a cache, beside
/// the results there; whether they have.
bool make_room_in_cache(const std::filesystem::path& folder, uint64_t budget_bytes, uint64_t bytes);

/// Blobs on disk, by the name of their digest, beyond the life of a worker and for all workers of
/// this user on this machine. What cannot be read or written is as if it were not there. Used by
/// one thread; other processes may use the same folder at the same time.
class BlobCache {
 public:
  /// Makes `folder`, for this user alone, where it is missing. Throws usage_error where that cannot
  /// be, or others may write into it.
  BlobCache(std::filesystem::path folder, uint64_t budget_bytes);

  /// The blob, in memory of this process, where nobody can change it any more, and verified there;
  /// null where it is not there or cannot be read now. A damaged file is removed.
  BlobData find(const Digest& digest, uint64_t size);
  /// Writes it whole or not at all, and removes what was used longest ago once all files together
  /// exceed the budget. Says so in the log, once, where it cannot.
  void keep(const Digest& digest, const Blob& blob);

 private:
  std::filesystem::path path_of(const Digest& digest) const;
  bool write(const std::filesystem::path& path, const Blob& blob);
  void remove_unfinished();
  void complain(const std::string& why);

  std::filesystem::path folder_;
  uint64_t budget_bytes_;
  bool complained_ = false;
};

}  // namespace tessera
