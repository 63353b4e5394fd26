#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/monotonic.h"
#include "front/free_camera.h"
#include "front/render_options.h"
#include "job/job.h"
#include "studio/ladder.h"
#include "studio/scene_reading.h"

namespace tessera {

class Coordinator;
struct FullFrame;

/// A pass that workers are to trace.
struct PassOrder {
  uint32_t serial = 0;
  std::shared_ptr<const SceneReading> reading;
  std::shared_ptr<const RenderOptions> options;  ///< the view's, with its full size and samples
  std::optional<FreeCamera> camera{};            ///< in place of the scene's
  ViewPass pass;
  int priority = 0;
};

/// Finished tiles of a pass.
struct PassTiles {
  uint32_t serial = 0;
  PixelRect film;  ///< the whole picture
  AovSet aovs;
  std::vector<TilePixels> tiles;
  std::vector<uint64_t> workers;  ///< by tile, the one that traced it
};

/// How a pass ended.
struct PassEnd {
  enum class How { done, failed, interrupted };
  uint32_t serial = 0;
  How how = How::done;
  std::optional<Error> why{};  ///< where it failed
  double overhead = 0;         ///< seconds until its first tile was begun
  double trace = 0;            ///< and from then on
  uint64_t rays = 0;
  std::shared_ptr<const Film> film{};  ///< null unless it is done
  /// What the film is of. Where that is to be denoised, denoised() makes the picture of the film.
  std::shared_ptr<const FullFrame> frame{};
};

/// Has passes traced by a coordinator of this process and passes on what becomes done. Used by the
/// coordinator's thread.
class PassRunner {
 public:
  struct Events {
    std::function<void(PassTiles)> tiles;
    std::function<void(PassEnd)> end;
    std::function<void(uint32_t serial, const JobProgress&)> progress;
  };
  explicit PassRunner(Events events) : events_(std::move(events)) {}

  void start(Coordinator& coordinator, const PassOrder& order, Time now);
  /// Its end is not told any more.
  void interrupt(Coordinator& coordinator, uint32_t serial, Time now);
  /// Passes on what became done since the last call.
  void look(Coordinator& coordinator, Time now);
  bool is_idle() const { return running_.empty(); }

  static constexpr Time kTellProgress = std::chrono::milliseconds(200);

 private:
  struct Running {
    uint64_t job = 0;
    Time begun{};
    AovSet aovs;
    std::vector<bool> told;  ///< by tile, whether it was passed on
    Time next_progress{};
    std::shared_ptr<const FullFrame> frame;
  };
  void pass_on_tiles(Coordinator& coordinator, uint32_t serial, Running& running, Time now);
  void pass_on_end(uint32_t serial, const Running& running, JobResult result, Time now);

  Events events_;
  std::map<uint32_t, Running> running_;  ///< by serial
};

}  // namespace tessera
