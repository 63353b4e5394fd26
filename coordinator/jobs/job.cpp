#include "coordinator/jobs/job.h"

#include <algorithm>
#include <utility>

#include "job/job_messages.h"
#include "job/tile_grid.h"

namespace tessera {
namespace {

/// A guess of what a tile takes, until some are done.
constexpr double kTileSeconds = 0.1;

uint64_t total(const v1::JobEnd& end, const char* name) {
  const auto it = end.totals().values().find(name);
  return it == end.totals().values().end() ? 0 : it->second;
}

}  // namespace

Job::Job(v1::KeptJob kept, std::optional<Time> now) : kept_(std::move(kept)), accepted_(now) {
  const v1::SubmitJob& request = kept_.request();
  ends_.resize(static_cast<size_t>(request.frames_size()));
  tiles_per_frame_ =
      cut_tiles(rect_of(request.crop()), static_cast<int>(request.tile_size())).size();
  for (const v1::KeptJob::End& end : kept_.ends()) {
    if (end.frame() < ends_.size()) this->end(end.frame(), end.end());
  }
  kept_.clear_ends();
}

Job::Job(uint64_t id, JobSpec spec, std::shared_ptr<TileStore> tiles, Time now)
    : local_(std::move(spec)), local_tiles_(std::move(tiles)), ends_(1), accepted_(now) {
  kept_.set_job(id);
  kept_.mutable_request()->set_priority(local_->priority);
}

bool Job::ended() const {
  return frames_ended_ == ends_.size() || (kept_.cancelled() && running_.empty());
}

std::optional<uint32_t> Job::next_frame() const {
  if (kept_.cancelled()) return std::nullopt;
  for (uint32_t frame = next_frame_; frame < ends_.size(); ++frame) {
    const auto is_it = [frame](const Running& running) { return running.frame == frame; };
    if (!ends_[frame] && std::none_of(running_.begin(), running_.end(), is_it)) return frame;
  }
  return std::nullopt;
}

void Job::begin(uint32_t frame, std::unique_ptr<ActiveFrame> active, Time now) {
  next_frame_ = frame + 1;
  tiles_per_frame_ = active->assembler().tiles().size();
  running_.push_back({frame, std::move(active)});
  pauses_ = 0;
  if (begun_) return;
  begun_ = now;
  done_when_begun_ = progress(now).tiles_done;
}

void Job::end(uint32_t frame, v1::JobEnd end) {
  if (!ends_[frame]) {
    ++frames_ended_;
    if (end.how() == v1::JobEnd::DONE) ++frames_done_;
  }
  ends_[frame] = std::move(end);
  std::erase_if(running_, [frame](const Running& running) { return running.frame == frame; });
  scene_failures_.erase(frame);
  expected_films_.erase(frame);
}

void Job::put_aside(uint32_t frame, Hold hold) {
  std::erase_if(running_, [frame](const Running& running) { return running.frame == frame; });
  next_frame_ = std::min(next_frame_, frame);
  hold_ = std::move(hold);
}

Time Job::next_pause() {
  constexpr int kMostDoublings = 6;
  return std::chrono::seconds(1) * (1 << std::min(pauses_++, kMostDoublings));
}

void Job::reopen(uint32_t frame) {
  if (!ends_[frame]) return;
  --frames_ended_;
  if (ends_[frame]->how() == v1::JobEnd::DONE) --frames_done_;
  ends_[frame].reset();
  next_frame_ = std::min(next_frame_, frame);
}

size_t Job::leases() const {
  size_t count = 0;
  for (const Running& running : running_) count += running.active->scheduler().live_count();
  return count;
}

void Job::account(Time now) {
  const double seconds = to_seconds(now - std::exchange(counted_until_, now));
  worker_seconds_ += static_cast<double>(leases()) * seconds;
}

double Job::share(Time now) {
  account(now);
  const auto held = static_cast<double>(leases());
  const auto mean =
      running_.empty() ? std::nullopt : running_.front().active->scheduler().mean_seconds();
  const double weight = std::max<uint32_t>(1, kept_.request().weight());
  return head_start_ + (worker_seconds_ + held * mean.value_or(kTileSeconds)) / weight;
}

void Job::catch_up(double share) {
  const double weight = std::max<uint32_t>(1, kept_.request().weight());
  head_start_ = std::max(head_start_, share - worker_seconds_ / weight);
}

uint64_t Job::tiles_restored() const {
  uint64_t count = 0;
  for (const auto& end : ends_) {
    if (end) count += total(*end, "tiles_restored");
  }
  for (const Running& running : running_) count += running.active->report().tiles_restored;
  return count;
}

JobProgress Job::progress(Time now) const {
  JobProgress progress;
  for (const auto& end : ends_) {
    if (end) progress.tiles_done += total(*end, "tiles_done");
  }
  for (const Running& running : running_) {
    progress.tiles_done += running.active->assembler().tiles_done();
  }
  progress.tiles_total = tiles_per_frame_ * ends_.size();
  const auto since = accepted_ ? accepted_ : begun_;
  // Of one that has ended, until it was last at work.
  const Time until = ended() ? counted_until_ : now;
  progress.elapsed_seconds = since && until > *since ? to_seconds(until - *since) : 0;
  progress.remaining_seconds = -1;
  if (begun_ && progress.tiles_done > done_when_begun_) {
    progress.remaining_seconds =
        remaining_seconds(to_seconds(now - *begun_), progress.tiles_done - done_when_begun_,
                          progress.tiles_total - progress.tiles_done);
  }
  return progress;
}

}  // namespace tessera
