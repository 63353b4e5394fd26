#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "proto/tessera/v1/farm.pb.h"
#include "renderer/film/tile.h"
#include "renderer/render/tile_renderer.h"

namespace tessera {

/// A tile that this worker holds: queued, being traced, or done. Shared by the session, which reads
/// its progress and may cancel it, and the thread that traces it.
struct TraceRun {
  uint64_t job = 0;
  std::string frame_id{}, opening{};  ///< as of JobStart, and of the Welcome before the assignment
  uint64_t lease = 0;
  uint32_t tile = 0;
  RenderTask task;
  std::shared_ptr<const TileRenderer> renderer;
  bool compress = false;
  TileProgress progress;
  std::atomic<bool> started{false};
  /// Set from outside: the job is not wanted, nor what its scene may still have to build. Null:
  /// that never happens. `progress.cancelled` is of this tile alone, which others may be tracing.
  std::shared_ptr<const std::atomic<bool>> job_dropped{};
  uint64_t waited = 0;  ///< of the session: heartbeats at which it may have waited for a tree
};

/// What became of a run: its bands, or why there are none.
struct TraceOutcome {
  std::shared_ptr<TraceRun> run;
  std::vector<v1::TileBand> bands;  ///< without session, job, lease and tile
  bool cancelled = false;
  bool out_of_memory =
      false;  ///< the failure is no fault of the tile's, as long as it was not alone
  std::string failure;
};

/// A scene with its blobs, to be made ready for tracing.
struct BuildRun {
  uint64_t job = 0;
  std::string frame_id{};  ///< as of JobStart
  BlobData scene_bytes;
  BlobStore blobs;
  v1::FrameSettings frame;
  std::shared_ptr<const std::atomic<bool>> dropped{};  ///< as TraceRun::job_dropped
  mutable std::atomic<bool> started{false};            ///< by the thread that builds it

  /// What the bytes are. May take seconds, of many nodes: for threads that build. Throws
  /// scene_error() where they are no scene.
  v1::Scene scene() const;
};

struct BuildOutcome {
  uint64_t job = 0;
  std::string frame_id{};                        ///< as of the run
  std::shared_ptr<const TileRenderer> renderer;  ///< null: it failed
  double seconds = 0;
  std::string failure;
  v1::SceneFailed::Cause cause = v1::SceneFailed::OTHER;  ///< where it failed
  bool dropped = false;                                   ///< it is no fault of the scene's
};

/// Traces a run to its outcome; used by any thread. Throws nothing.
TraceOutcome trace(std::shared_ptr<TraceRun> run);

}  // namespace tessera
