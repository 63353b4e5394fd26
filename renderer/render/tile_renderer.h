#pragma once

#include <atomic>
#include <memory>
#include <optional>

#include "base/weak_cache.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/film/tile.h"

namespace tessera {

/// How far a tile is, written by the tracing thread and read by any other.
struct TileProgress {
  std::atomic<uint64_t> work_done{0};  ///< grows with every pixel, and every thousand rays of one
  std::atomic<bool> cancelled{false};  ///< set from outside: stop within so many rays

  /// Called by the tracing thread: adds to the pixels that are done. Returns false when the tile
  /// should stop.
  bool go_on(uint64_t done = 1) {
    work_done.store(work_done.load(std::memory_order_relaxed) + done, std::memory_order_relaxed);
    return !cancelled.load(std::memory_order_relaxed);
  }
};

/// Traces tiles of one frame. Its pixels are a pure function of (scene, frame settings, task).
/// Immutable after construction; render() may run on many threads at once.
class TileRenderer {
 public:
  virtual ~TileRenderer() = default;
  /// Returns nothing when the tile was cancelled before it was finished.
  virtual std::optional<TilePixels> render(const RenderTask& task,
                                           TileProgress& progress) const = 0;
  /// Whether something of the scene is being built that render() may wait for, and with it does not
  /// get on.
  virtual bool builds() const { return false; }
  /// The region of the frame that sees only a background of one colour, and what its pixels are.
  struct Unseen {
    PixelRect seen;        ///< outside of it, no sample of any pixel can hit
    TilePixels one_pixel;  ///< of those there, as render() would give it
  };
  virtual std::optional<Unseen> unseen(uint32_t /*sample_count*/) const { return std::nullopt; }
  /// Counts of what building found and left out, by the names of --stats.
  virtual CounterMap build_counters() const = 0;
};

/// Builds what tracing this frame needs. Throws Error where the scene is wrong. `threads` is how
/// many it may use to build. Neither that nor where trees are shared changes the result.
std::shared_ptr<const TileRenderer> make_tile_renderer(const v1::Scene& scene,
                                                       const BlobStore& blobs,
                                                       const v1::FrameSettings& frame, int threads,
                                                       const Sharing& sharing = {});

}  // namespace tessera
