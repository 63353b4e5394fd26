#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
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
/// again for what did not come, later the longer chunks take, and verifies each blob before it
/// counts.
class BlobFetch {
 public:
  /// `submission` goes into every request, for the other side to repeat in its answers. `by_place`:
  /// first asks whether the other side shares the blob on this machine.
  explicit BlobFetch(uint64_t submission = 0, bool by_place = false);

  /// Adds a blob to fetch. Once is enough; a size above kMaxBlobBytes is a failure.
  void want(const Digest& digest, uint64_t size);
  /// The same, but asks for nothing until on_loaded() says that it is not to be had otherwise.
  void hold(const Digest& digest, uint64_t size);
  /// The verified blob that was found on this machine, or null.
  void on_loaded(const Digest& digest, BlobData blob, BlobStore& store);
  /// What to ask now. Call after each chunk and at next_deadline().
  std::vector<v1::BlobRequest> requests(Time now);
  /// Blobs that are complete and right go to `store`. Chunks that were not asked for are ignored.
  /// True if one is complete by this chunk.
  bool on_chunk(const v1::BlobChunk& chunk, BlobStore& store);
  /// The size of the blob, which is held until on_loaded(); nothing if it was not asked for.
  std::optional<uint64_t> on_place(const v1::BlobPlace& place);
  void on_missing(const v1::BlobMissing& missing);

  bool finished() const { return parts_.empty(); }
  /// Of blobs that are not complete, so many bytes went into their digests already: what is left to
  /// do when the last chunk comes is little, however large the blob.
  uint64_t digested_bytes() const;
  /// Why it cannot succeed; empty as long as it can.
  const std::string& failure() const { return failure_; }
  std::optional<Time> next_deadline() const;

 private:
  struct Asked {
    Time first{}, last{};
  };
  struct Part {
    uint64_t size = 0;
    std::vector<std::byte> data;  ///< grows as chunks come, so that a size alone costs nothing
    size_t asked = 0;             ///< so many chunks from the first on
    size_t received = 0;
    std::vector<bool> came{};  ///< by chunk, so far
    size_t digested = 0;       ///< so many chunks from the first on
    DigestStream digest{};     ///< of these
    int corrupt = 0;
    bool held = false;      ///< until on_loaded()
    bool by_place = false;  ///< until that was answered, nothing but the first chunk is asked for
  };
  using Parts = std::map<Digest, Part>;
  Parts::iterator find(const std::string& hex);
  Part* add(const Digest& digest, uint64_t size);
  /// Adds what lies without a gap to the digest.
  static void digest_more(Part& part);
  bool complete(Parts::iterator part, BlobStore& store);
  void note_damage(Parts::iterator part);
  v1::BlobRequest request(const Digest& digest, size_t chunk) const;

  uint64_t submission_;
  bool by_place_;
  Parts parts_;
  std::deque<Digest> unasked_;  ///< of parts with chunks that were not asked for, in their order
  std::map<std::pair<Digest, size_t>, Asked> in_flight_;  ///< when each was asked for
  std::optional<Time> answered_;  ///< when what has come since requests() was first asked for
  Time ask_again_after_;          ///< longer where chunks take longer: else they would come twice
  std::string failure_;
};

}  // namespace tessera
