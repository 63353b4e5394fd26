#pragma once

#include <cstdint>
#include <string>
#include <unordered_set>
#include <vector>

#include "base/digest.h"
#include "coordinator/jobs/seconds_histogram.h"
#include "coordinator/tiles/tile_store.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/wire/blob_store.h"

namespace tessera {

/// Keeps jobs, the blobs of their scenes and their finished tiles. Used by one thread, and by one
/// coordinator at a time. What cannot be written throws an Error, and may be tried again; what
/// cannot be read now throws temporary_error, which says nothing about what is there.
class JobStore : public TileStore {
 public:
  /// Another for each store; 0: this one does not outlive its process.
  virtual uint64_t farm() const = 0;

  /// How long writing took, each time since it was opened.
  virtual SecondsHistogram commit_seconds() const { return {}; }

  /// All of them, by number. Each may be taken up: check_kept_job() has been asked.
  virtual std::vector<v1::KeptJob> jobs() = 0;
  /// The largest number that a job ever had.
  virtual uint64_t last_job() = 0;
  /// Keeps it, or what it has become, without its ends: from when this returns it outlives a power
  /// cut.
  virtual void save(const v1::KeptJob& job) = 0;
  virtual void save_end(uint64_t job, const v1::KeptJob::End& end) = 0;
  /// Takes the end of a frame back, if it is there: the frame is to be rendered again.
  virtual void remove_end(uint64_t job, uint32_t frame) = 0;
  /// Forgets the job, and tiles and blobs that no other job needs.
  virtual void remove(uint64_t job, const std::vector<Digest>& tile_keys,
                      const std::vector<Digest>& blobs) = 0;

  /// How many tiles are kept under the key; find() may find fewer to be sound. Throws
  /// temporary_error where that cannot be read now.
  virtual uint64_t tile_count(const Digest& key) = 0;

  /// Tiles of all jobs with pixels made under the public key `key`, written as by key_text().
  virtual std::vector<StoredTile> tiles_traced_by(const std::string& key) = 0;

  /// Whether the blob is there, sound: its bytes are held against its digest the first time that
  /// they are asked for. False only where there is no such blob, or a damaged one, which is moved
  /// aside to DIGEST.damaged, never deleted. Throws temporary_error where it cannot be read now.
  virtual bool has_blob(const Digest& digest) = 0;
  /// Keeps verified bytes; they are there whole or not at all.
  virtual void put_blob(const Digest& digest, const BlobData& data) = 0;
  /// The blob; null, or temporary_error, where has_blob() returns false or throws.
  virtual BlobData find_blob(const Digest& digest) = 0;
  /// To be called once, after jobs(), with the blobs that they need: forgets blobs that no job has
  /// needed for long, such as those of submissions that never became jobs.
  virtual void keep_only_blobs(const std::unordered_set<Digest>& digests) = 0;

  /// Does a little of what may wait, for about 10 ms: gives room that forgotten jobs took back to
  /// the disk. To be called now and then, while nobody waits. Throws nothing.
  virtual void tidy() {}
};

}  // namespace tessera
