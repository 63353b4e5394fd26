#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/tessera/v1/farm.pb.h"
#include "proto/wire/blob_transfer.h"
#include "renderer/render/tile_renderer.h"
#include "worker/blob_loader.h"
#include "worker/trace_run.h"

namespace tessera {

/// Blobs that this process has for other reasons, verified; null for others.
using BlobsAtHand = std::function<BlobData(const Digest&)>;

/// What this worker has of scenes: verified blobs by digest and the last tracers that were built.
/// No blob that is here is asked for again. Not thread-safe.
class SceneCache {
 public:
  /// Where blobs may be had beside the coordinator's messages.
  struct Sources {
    bool disk = false;           ///< looked at first
    bool shared_memory = false;  ///< of a coordinator on this machine
    BlobsAtHand at_hand{};       ///< null: none; asked before all others
  };
  explicit SceneCache(Sources sources) : sources_(sources) {}

  /// What the job needs and is not here; nothing if `start` is malformed. What to look for on this
  /// machine is added to `lookups`; of each, the fetch waits to be told.
  std::optional<BlobFetch> want(const v1::JobStart& start, std::vector<BlobLookup>& lookups);
  /// Forgets the blobs that none of these jobs needs, once all exceed `budget_bytes`.
  void make_room(const std::vector<const v1::JobStart*>& jobs, uint64_t budget_bytes);
  /// The tracer for the job, if the same frame of the same scene was built before.
  std::shared_ptr<const TileRenderer> built(const v1::JobStart& start) const;
  void keep(const v1::JobStart& start, std::shared_ptr<const TileRenderer> renderer);

  BlobStore& blobs() { return blobs_; }
  /// What to build, once all blobs are here; null if the scene's are not.
  std::shared_ptr<BuildRun> input(const v1::JobStart& start) const;

 private:
  struct Built {
    std::string key;
    std::shared_ptr<const TileRenderer> renderer;
  };

  Sources sources_;
  BlobStore blobs_;
  std::deque<Built> built_;  ///< the latest first
};

}  // namespace tessera
