#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/monotonic.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/wire/blob_transfer.h"
#include "renderer/render/tile_renderer.h"
#include "worker/blob_loader.h"
#include "worker/trace_run.h"

namespace tessera {

/// What this worker has of scenes: verified blobs by digest and the last tracers that were built.
/// No blob that is here is asked for again. Not thread-safe.
class SceneCache {
 public:
  /// Where blobs may be had beside the coordinator's messages.
  struct Sources {
    bool disk = false;           ///< looked at first: see take_lookups()
    bool shared_memory = false;  ///< of a coordinator on this machine
  };
  explicit SceneCache(Sources sources) : sources_(sources) {}

  /// Starts to gather what the job needs, and forgets what none of the kept tracers and jobs may
  /// need once the blobs exceed `budget_bytes`. False if `start` is malformed.
  bool begin(const v1::JobStart& start, uint64_t budget_bytes);
  /// Blobs to look for on this machine; each is told to on_loaded().
  std::vector<BlobLookup> take_lookups() { return std::exchange(lookups_, {}); }
  void on_loaded(const BlobFound& found) { fetch_.on_loaded(found.digest, found.blob, blobs_); }
  void on_place(const v1::BlobPlace& place);
  /// The tracer for the job of begin(), if the same frame of the same scene was built before.
  std::shared_ptr<const TileRenderer> built() const;
  void keep(std::shared_ptr<const TileRenderer> renderer);

  BlobFetch& fetch() { return fetch_; }
  const BlobFetch& fetch() const { return fetch_; }
  BlobStore& blobs() { return blobs_; }
  /// What to build, once fetch() has finished; nothing if the scene's bytes are none.
  std::optional<BuildRun> input() const;

 private:
  struct Built {
    std::string key;
    std::shared_ptr<const TileRenderer> renderer;
  };
  void make_room(uint64_t budget_bytes);

  Sources sources_;
  std::vector<BlobLookup> lookups_;
  v1::JobStart start_;
  std::string key_;
  BlobStore blobs_;
  BlobFetch fetch_;
  std::deque<Built> built_;  ///< the latest first
};

}  // namespace tessera
