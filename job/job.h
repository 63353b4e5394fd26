#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "job/frame_trace.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/film/film.h"
#include "renderer/film/tile.h"

namespace tessera {

/// Priorities are numbers from -kMostPriority to kMostPriority.
inline constexpr int32_t kMostPriority = 1000;

/// One frame to render. A value; the blobs are shared.
struct JobSpec {
  v1::Scene scene;  ///< without blobs in it
  BlobStore blobs;
  v1::FrameSettings frame;
  PixelRect crop;     ///< in frame coordinates; the film covers exactly this
  int tile_size = 0;  ///< pixels a side; 0: as kept, or chosen from the frame and the workers
  std::filesystem::path kept_tiles{};  ///< file of finished tiles on this machine; empty: none
  /// Of jobs of one process: workers serve the highest first. A client's has that of its request.
  int32_t priority = 0;
};

/// What became of a job; every number is a total over its life.
struct JobReport {
  enum class End { done, failed, interrupted };
  End end = End::done;
  std::string failure;                  ///< why, where end is failed
  ExitCode exit_code = ExitCode::done;  ///< bad_scene where the scene could not be built
  std::vector<PixelRect> holes;         ///< tiles that were given up, already marked in the film

  CounterMap counters;        ///< sums over accepted tiles: rays_primary ...
  CounterMap build_counters;  ///< of the scene that was built: textures_used ...
  uint64_t tiles_total = 0;
  uint64_t tiles_done = 0;      ///< of those in the film; 0: the film is one hole, not a picture
  uint64_t tiles_restored = 0;  ///< of those, kept from before
  uint64_t retries = 0;         ///< assignments beyond the first that replaced a lost one
  uint64_t speculative = 0;     ///< second copies issued at the end of the queue
  uint64_t filled = 0;          ///< tiles that look past everything, completed without tracing
  uint64_t split = 0;           ///< tiles given out in parts at the end of the queue
  uint64_t moved = 0;           ///< tiles, or parts, given to an idle worker before another began
  uint64_t duplicates = 0;      ///< results that came for a tile already done
  uint64_t mismatches = 0;      ///< of those, not equal bit for bit
  uint64_t verified = 0;        ///< chosen tiles that a second worker traced to the same bits
  uint64_t unverified = 0;      ///< chosen ones for which there was no second worker
  uint64_t liars = 0;           ///< workers set aside since two others contradicted them
  uint64_t retraced = 0;        ///< tiles of theirs that were traced again
  uint64_t workers_seen = 0;    ///< different ones that were there at any time of the job
  uint64_t workers_lost = 0;    ///< how often one of them was lost
  uint64_t bytes_scene = 0, bytes_results = 0;  ///< shipped to and from workers
  double build_seconds = 0;                     ///< longest of any worker
  double trace_seconds = 0;                     ///< from the first assignment to the last result
  double assemble_seconds = 0;
  std::shared_ptr<const FrameTrace> trace;  ///< null: of a client's end, which has none
};

struct JobResult {
  JobReport report;
  Film film;  ///< of the crop; holes are marked
};

/// Of a job's name, in bytes; those of files fit in however they are written.
inline constexpr size_t kMostName = 1000;

/// Told to whoever watches; called on the thread that runs the job.
struct JobProgress {
  uint64_t tiles_done = 0, tiles_total = 0;
  int workers = 0;                ///< now connected
  double elapsed_seconds = 0;     ///< of a farm's job: those in which it was worked on
  double remaining_seconds = -1;  ///< below 0: not known
  std::string waiting_for{};      ///< "workers" ...; empty: tiles are traced
};
using ProgressCallback = std::function<void(const JobProgress&)>;

/// Tiles that were done since the last call, and the film that has them: `channels` values a pixel
/// of `film`, rows from the top, valid during the call.
struct NewTiles {
  PixelRect film;
  int channels = 0;
  std::span<const float> values;
  std::vector<PixelRect> tiles;
};
using TileCallback = std::function<void(const NewTiles&)>;

}  // namespace tessera
