#include "studio/frame_runner.h"

#include <array>
#include <utility>
#include <vector>

#include "base/error.h"
#include "coordinator/coordinator.h"
#include "coordinator/jobs/preview.h"
#include "coordinator/tiles/tile_store.h"
#include "studio/view_panes.h"

namespace tessera {
namespace {

/// Keeps finished tiles for as long as it lives: of a frame that is paused.
class TilesInMemory : public TileStore {
 public:
  void keep(const Digest& job, const FinishedTile& tile) override {
    tiles_[job].insert_or_assign(key_of(tile.rect), tile);
  }
  void drop(const Digest& job, const PixelRect& tile) override { tiles_[job].erase(key_of(tile)); }
  void drop_all(const Digest& job) override { tiles_.erase(job); }
  std::vector<FinishedTile> find(const Digest& job) override {
    std::vector<FinishedTile> found;
    for (const auto& [rect, tile] : tiles_[job]) found.push_back(tile);
    return found;
  }

 private:
  using Key = std::array<int, 4>;
  static Key key_of(const PixelRect& rect) { return {rect.y0, rect.x0, rect.y1, rect.x1}; }

  std::map<Digest, std::map<Key, FinishedTile>> tiles_;
};

}  // namespace

void FrameRunner::start(Coordinator& coordinator, const TraceFrame& order, Time now) {
  try {
    JobSpec job = job_of(order.frame);
    job.priority = kFullPicturePriority;
    auto& tiles = tiles_[order.job];
    if (!tiles) tiles = std::make_shared<TilesInMemory>();
    const uint64_t id = coordinator.submit(std::move(job), now, tiles);
    running_.insert_or_assign(order.job, Running{id, now, now});
  } catch (const Error& error) {
    tiles_.erase(order.job);
    events_.end({.job = order.job, .failure = error.what()});
  }
}

void FrameRunner::end(Coordinator& coordinator, const EndFrame& order, Time now) {
  if (!order.keeps_tiles) tiles_.erase(order.job);
  const auto at = running_.find(order.job);
  if (at == running_.end()) return;
  coordinator.interrupt(at->second.job, now);
  coordinator.take_result(at->second.job);
  running_.erase(at);
}

std::shared_ptr<const Film> FrameRunner::film(const Coordinator& coordinator, uint64_t job) const {
  const auto at = running_.find(job);
  const auto view = at == running_.end() ? std::nullopt : coordinator.film(at->second.job);
  if (!view) return nullptr;
  return std::make_shared<const Film>(light_of(*view));
}

void FrameRunner::look(Coordinator& coordinator, Time now) {
  std::vector<FrameEnd> ended;
  for (auto at = running_.begin(); at != running_.end();) {
    auto& [number, running] = *at;
    if (auto result = coordinator.take_result(running.job)) {
      events_.progress(number, {.tiles_done = result->report.tiles_done,
                                .tiles_total = result->report.tiles_total});
      ended.push_back({.job = number,
                       .result = std::make_shared<JobResult>(std::move(*result)),
                       .seconds = to_seconds(now - running.begun)});
      tiles_.erase(number);
      at = running_.erase(at);
      continue;
    }
    if (now >= running.next_progress) {
      running.next_progress = now + kTellProgress;
      if (const auto progress = coordinator.progress(running.job, now))
        events_.progress(number, *progress);
    }
    ++at;
  }
  for (FrameEnd& end : ended) events_.end(std::move(end));
}

}  // namespace tessera
