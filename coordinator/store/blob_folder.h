#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <unordered_set>
#include <vector>

#include "base/digest.h"
#include "base/owned_descriptor.h"
#include "proto/wire/blob_store.h"

namespace tessera {

/// Blobs as files of a folder, each named by its digest. A file whose bytes have another digest is
/// renamed to DIGEST.damaged, in place of an earlier one of that name, and never deleted. One that
/// cannot be read now stays as it is, and temporary_error says why. Used by one thread.
class BlobFolder {
 public:
  explicit BlobFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Whether it is there, sound: its bytes are read the first time that this is asked.
  bool has(const Digest& digest);
  /// Null where has() returns false.
  BlobData find(const Digest& digest);
  /// Keeps verified bytes: they are there whole or not at all. Throws temporary_error.
  void put(const Digest& digest, const BlobData& data);
  void remove(const Digest& digest);
  /// What is there by name, sound or not.
  std::vector<Digest> list() const;
  /// Removes what a killed process left of a blob that it was writing.
  void remove_unfinished();

 private:
  std::filesystem::path path_of(const Digest& digest) const { return folder_ / digest.hex(); }
  /// A descriptor of -1 where there is no such file. `size` is filled in otherwise.
  OwnedDescriptor open(const Digest& digest, uint64_t& size) const;
  [[noreturn]] void fail(const Digest& digest, const std::string& why) const;
  void put_aside(const Digest& digest);

  std::filesystem::path folder_;
  std::unordered_set<Digest> verified_;  ///< by this process
};

}  // namespace tessera
