#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/digest.h"
#include "base/monotonic.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/wire/blob_store.h"

namespace tessera {

inline constexpr uint32_t kBlobChunkBytes = 1u << 20;
inline constexpr uint64_t kMaxBlobBytes = uint64_t{16} << 30;

/// The answer to a request: that piece of the blob, or that there is none. `blob` may be null.
v1::Envelope answer_blob_request(const v1::BlobRequest& request, const BlobData& blob);

/// Pulls blobs in chunks from a side that keeps no state for it: asks for a few at a time, asks
/// again for what did not come, and verifies each blob before it counts.
class BlobFetch {
 public:
  /// Adds a blob to fetch. Once is enough; a size above kMaxBlobBytes is a failure.
  void want(const Digest& digest, uint64_t size);
  /// What to ask now. Call after each chunk and at next_deadline().
  std::vector<v1::BlobRequest> requests(Time now);
  /// Blobs that are complete and right go to `store`. Chunks that were not asked for are ignored.
  void on_chunk(const v1::BlobChunk& chunk, BlobStore& store);
  void on_missing(const v1::BlobMissing& missing);

  bool finished() const { return parts_.empty(); }
  /// Why it cannot succeed; empty as long as it can.
  const std::string& failure() const { return failure_; }
  uint64_t bytes_received() const { return bytes_received_; }
  std::optional<Time> next_deadline() const;

 private:
  struct Part {
    Digest digest;
    uint64_t size = 0;
    std::vector<std::byte> data;  ///< grows as chunks come, so that a size alone costs nothing
    std::vector<Time> asked;      ///< by chunk, as far as asked
    std::vector<bool> received;   ///< likewise
    int corrupt = 0;
  };
  Part* find(const std::string& hex);
  void complete(Part& part, BlobStore& store);
  void ask(Part& part, size_t chunk, Time now, std::vector<v1::BlobRequest>& requests);

  std::vector<Part> parts_;
  size_t in_flight_ = 0;
  uint64_t bytes_received_ = 0;
  std::string failure_;
};

}  // namespace tessera
