#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/error.h"
#include "base/monotonic.h"
#include "coordinator/jobs/job_store.h"
#include "coordinator/jobs/packed_scene.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/transport/transport.h"
#include "proto/wire/blob_transfer.h"

namespace tessera {

/// What a client has submitted, until the store has all of it: pulls the scenes, reads which blobs
/// they need, and pulls those that the store lacks. Of the coordinator's thread.
class Submission {
 public:
  /// Throws usage_error for a request that names its scenes wrongly.
  Submission(v1::SubmitJob request, JobStore& store, Time now);

  const v1::SubmitJob& request() const { return request_; }
  /// It ends so, and lets go of what it was sent.
  void fail(v1::JobStatus how);
  /// What it may come to take: its scenes, its blobs as far as they are known, and a film.
  uint64_t claimed_bytes() const { return claimed_bytes_; }
  uint64_t scene_bytes() const { return scene_bytes_; }

  void on_chunk(const v1::BlobChunk& chunk) { fetch_.on_chunk(chunk, pulled_); }
  void on_missing(const v1::BlobMissing& missing) { fetch_.on_missing(missing); }
  /// Puts what came into the store, and reads a few scenes of it. What to ask the client for now.
  /// Throws Error where that cannot go on.
  std::vector<v1::BlobRequest> advance(JobStore& store, Time now);
  bool finished() const { return unread_.empty() && fetch_.finished(); }
  /// Of all its frames, the scenes among them; once it is finished.
  std::vector<Digest> blobs() const;
  /// Its scenes, by digest; once it is finished.
  const SceneFactsMap& scenes() const { return scenes_; }

  // For whoever keeps it.
  PeerId peer;
  Time last_heard;
  v1::JobStatus status;  ///< FETCHING, or ENDED where it failed

 private:
  void want(const Digest& digest, uint64_t size, JobStore& store);
  /// Asks anew for what the store had and has no longer: a job that was forgotten meanwhile took
  /// it.
  void want_lost(JobStore& store);
  /// Returns how many bytes it has.
  uint64_t read_scene(const Digest& digest, JobStore& store);

  v1::SubmitJob request_;
  uint64_t claimed_bytes_ = 0, scene_bytes_ = 0;
  BlobFetch fetch_;
  BlobStore pulled_;
  std::deque<Digest> unread_;                    ///< scenes
  std::unordered_map<Digest, uint64_t> needed_;  ///< with their sizes
  SceneFactsMap scenes_;
};

}  // namespace tessera
