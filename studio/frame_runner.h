#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>

#include "base/monotonic.h"
#include "job/job.h"
#include "studio/render_orders.h"

namespace tessera {

class Coordinator;
class TileStore;

/// Has full pictures traced by a coordinator of this process, and traced on from the tiles that
/// were done. Used by the coordinator's thread.
class FrameRunner {
 public:
  static constexpr Time kTellProgress = std::chrono::milliseconds(200);

  struct Events {
    std::function<void(FrameEnd)> end;
    std::function<void(uint64_t job, const JobProgress&)> progress;
  };
  explicit FrameRunner(Events events) : events_(std::move(events)) {}

  void start(Coordinator& coordinator, const TraceFrame& order, Time now);
  /// Its end is not told any more.
  void end(Coordinator& coordinator, const EndFrame& order, Time now);
  /// The light that is done of it; null where there is none.
  std::shared_ptr<const Film> film(const Coordinator& coordinator, uint64_t job) const;
  /// Tells of what has ended and how far the others are.
  void look(Coordinator& coordinator, Time now);

 private:
  struct Running {
    uint64_t job = 0;  ///< of the coordinator
    Time begun{};
    Time next_progress{};
  };

  Events events_;
  std::map<uint64_t, Running> running_;                   ///< by the queue's number
  std::map<uint64_t, std::shared_ptr<TileStore>> tiles_;  ///< of those and of paused ones
};

}  // namespace tessera
