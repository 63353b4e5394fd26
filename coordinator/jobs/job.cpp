#include "coordinator/jobs/job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/plural.h"
#include "job/job_messages.h"
#include "job/tile_grid.h"

namespace tessera {
namespace {

/// A guess of what a tile takes, until some are done.
constexpr double kTileSeconds = 0.1;

/// Frames of a job that are held until people have looked at them, before all of it is.
constexpr ptrdiff_t kMostForPeople = 3;

uint64_t total(const v1::JobEnd& end, const char* name) {
  const auto it = end.totals().values().find(name);
  return it == end.totals().values().end() ? 0 : it->second;
}

/// What a store says last of seconds that only grow.
double last_of(const v1::KeptJob& kept, double (v1::KeptJob::*of_job)() const,
               double (v1::JobEnd::*of_end)() const) {
  double seconds = (kept.*of_job)();
  for (const v1::KeptJob::End& end : kept.ends()) {
    seconds = std::max(seconds, (end.end().*of_end)());
  }
  return std::isfinite(seconds) && seconds > 0 ? seconds : 0;
}

}  // namespace

Job::Job(v1::KeptJob kept)
    : kept_(std::move(kept)),
      meter_(last_of(kept_, &v1::KeptJob::worked_seconds, &v1::JobEnd::worked_seconds)),
      traced_in_earlier_runs_(
          last_of(kept_, &v1::KeptJob::traced_seconds, &v1::JobEnd::traced_seconds)) {
  const v1::SubmitJob& request = kept_.request();
  ends_.resize(static_cast<size_t>(request.frames_size()));
  tiles_per_frame_ =
      cut_tiles(rect_of(request.crop()), static_cast<int>(request.tile_size())).size();
  for (const v1::KeptJob::End& end : kept_.ends()) {
    if (end.frame() < ends_.size()) this->end(end.frame(), end.end());
  }
  kept_.clear_ends();
}

Job::Job(uint64_t id, JobSpec spec, std::shared_ptr<TileStore> tiles)
    : local_(std::move(spec)), local_tiles_(std::move(tiles)), ends_(1) {
  kept_.set_job(id);
  kept_.mutable_request()->set_priority(local_->priority);
}

bool Job::ended() const {
  return frames_ended_ == ends_.size() || (kept_.cancelled() && running_.empty());
}

std::optional<uint32_t> Job::next_frame(Time now) const {
  if (kept_.cancelled()) return std::nullopt;
  // What ends workers is not tried with frame after frame.
  const auto is_for_people = [](const auto& of) {
    return of.second.until == Time::max() && !of.second.until_another_worker;
  };
  if (std::count_if(holds_.begin(), holds_.end(), is_for_people) >= kMostForPeople) {
    return std::nullopt;
  }
  for (uint32_t frame = next_frame_; frame < ends_.size(); ++frame) {
    const auto is_it = [frame](const Running& running) { return running.frame == frame; };
    if (ends_[frame] || std::any_of(running_.begin(), running_.end(), is_it)) continue;
    const auto hold = holds_.find(frame);
    if (hold == holds_.end() || hold->second.until <= now) return frame;
  }
  return std::nullopt;
}

void Job::begin(uint32_t frame, std::unique_ptr<ActiveFrame> active) {
  // Of those before it, some may be held.
  while (next_frame_ < ends_.size() && (ends_[next_frame_] || next_frame_ == frame)) ++next_frame_;
  holds_.erase(frame);
  pauses_.erase(frame);
  tiles_per_frame_ = active->assembler().tiles().size();
  running_.push_back({frame, std::move(active)});
  begun_ = true;
  stored_.erase(frame);
}

void Job::set_stored(uint32_t frame, uint64_t tiles) {
  // There may be tiles of another grid.
  stored_[frame] = std::min(tiles, tiles_per_frame_);
}

uint64_t Job::stored(uint32_t frame) const {
  const auto it = stored_.find(frame);
  return it == stored_.end() ? 0 : it->second;
}

void Job::stop(uint32_t frame) {
  const auto is_it = [frame](const Running& running) { return running.frame == frame; };
  const auto it = std::find_if(running_.begin(), running_.end(), is_it);
  if (it == running_.end()) return;
  traced_before_ += it->active->traced();
  const uint64_t tiles = it->active->assembler().tiles_done();
  running_.erase(it);
  for (const uint32_t equal : waiting_equals(frame)) {
    if (stored(equal) < tiles) set_stored(equal, tiles);
  }
}

std::vector<uint32_t> Job::waiting_equals(uint32_t frame) const {
  std::vector<uint32_t> result;
  const auto& keys = kept_.tile_keys();
  const auto count = static_cast<uint32_t>(keys.size());
  for (uint32_t other = next_frame_; frame < count && other < std::min(count, frame_count());
       ++other) {
    const auto is_it = [other](const Running& running) { return running.frame == other; };
    const bool is_equal = keys[static_cast<int>(other)] == keys[static_cast<int>(frame)];
    if (is_equal && !ends_[other] && std::none_of(running_.begin(), running_.end(), is_it)) {
      result.push_back(other);
    }
  }
  return result;
}

Job::WaitingTiles Job::waiting_tiles() const {
  WaitingTiles waiting;
  for (const auto& [frame, tiles] : stored_) waiting.done += tiles;
  for (const Running& running : running_) {
    const uint64_t tiles = running.active->assembler().tiles_done();
    for (const uint32_t equal : waiting_equals(running.frame)) {
      const uint64_t done = std::max(tiles, stored(equal));
      waiting.done += done - stored(equal);
      waiting.coming += tiles_per_frame_ - std::min(done, tiles_per_frame_);
    }
  }
  return waiting;
}

void Job::end(uint32_t frame, v1::JobEnd end) {
  if (!ends_[frame]) {
    ++frames_ended_;
    if (end.how() == v1::JobEnd::DONE) ++frames_done_;
  }
  ends_[frame] = std::move(end);
  stop(frame);
  stored_.erase(frame);
  holds_.erase(frame);
  pauses_.erase(frame);
  scene_failures_.erase(frame);
  expected_films_.erase(frame);
}

bool Job::held() const {
  const size_t open = ends_.size() - frames_ended_;
  return !holds_.empty() && running_.empty() &&
         (holds_.size() == open || !next_frame(Time::max() - Time{1}));
}

std::string Job::hold_cause() const {
  if (holds_.empty()) return "";
  const auto& [frame, hold] = *holds_.begin();
  if (frame_count() == 1) return hold.cause;
  const std::string others =
      holds_.size() > 1
          ? fmt::format(" (and {} are held)", counted(holds_.size() - 1, "other frame"))
          : "";
  return fmt::format("frame {}: {}{}", number_of(frame), hold.cause, others);
}

int32_t Job::number_of(uint32_t frame) const {
  return request().animation() ? request().frames(static_cast<int>(frame)).number()
                               : static_cast<int32_t>(frame) + 1;
}

void Job::note_worker(WorkerId worker) {
  std::erase_if(holds_, [&](const auto& held) {
    const auto failures = scene_failures_.find(held.first);
    const bool has_failed = failures != scene_failures_.end() && failures->second.contains(worker);
    return held.second.until_another_worker && !has_failed;
  });
}

void Job::release() {
  holds_.clear();
  pauses_.clear();
  scene_failures_.clear();
}

void Job::put_aside(uint32_t frame) {
  for (Running& running : running_) {
    if (running.frame != frame) continue;
    scene_failures_[frame] = running.active->scene_failures();
    last_costs_ = running.active->scheduler().costs();
  }
  next_frame_ = std::min(next_frame_, frame);
  stop(frame);
}

Time Job::next_pause(uint32_t frame) {
  constexpr int kMostDoublings = 6;
  return std::chrono::seconds(1) * (1 << std::min(pauses_[frame]++, kMostDoublings));
}

void Job::reopen(uint32_t frame, uint64_t stored) {
  if (!ends_[frame]) return;
  --frames_ended_;
  if (ends_[frame]->how() == v1::JobEnd::DONE) --frames_done_;
  ends_[frame].reset();
  next_frame_ = std::min(next_frame_, frame);
  set_stored(frame, stored);
}

TileWork Job::traced() const {
  TileWork work = traced_before_;
  for (const Running& running : running_) work += running.active->traced();
  return work;
}

TileWork Job::left(uint64_t tiles) const {
  TileWork begun, seen = last_costs_ ? last_costs_->known() : TileWork{};
  for (const Running& running : running_) {
    const TileScheduler& scheduler = running.active->scheduler();
    begun += scheduler.left();
    seen += scheduler.costs().known();
  }
  seen += begun;
  // The other frames' tiles are as those of the frames that were seen, in the mean.
  const uint64_t others = tiles - std::min(tiles, begun.tiles);
  const double mean = seen.seconds / static_cast<double>(std::max<uint64_t>(1, seen.tiles));
  return {tiles, begun.seconds + mean * static_cast<double>(others)};
}

size_t Job::leases() const {
  size_t count = 0;
  for (const Running& running : running_) count += running.active->scheduler().live_count();
  return count;
}

size_t Job::working_threads() const {
  size_t most = 0;  // the frames share their workers
  for (const Running& running : running_) {
    most = std::max(most, running.active->scheduler().working_threads());
  }
  return most;
}

bool Job::works(const std::vector<int32_t>& served) const {
  if (working_threads() == 0) return false;
  if (leases() > 0) return true;
  return !kept_.paused() &&
         std::find(served.begin(), served.end(), request().priority()) != served.end();
}

void Job::account(Time now, bool works) {
  meter_.account(now, works ? working_threads() : 0, traced(), tiles_per_frame_ * ends_.size());
  const double seconds = to_seconds(now - std::exchange(counted_until_, now));
  held_seconds_ += static_cast<double>(leases()) * seconds;
}

double Job::share() const {
  const auto held = static_cast<double>(leases());
  const auto mean =
      running_.empty() ? std::nullopt : running_.front().active->scheduler().mean_seconds();
  const double weight = std::max<uint32_t>(1, kept_.request().weight());
  return head_start_ + (held_seconds_ + held * mean.value_or(kTileSeconds)) / weight;
}

void Job::catch_up(double share) {
  const double weight = std::max<uint32_t>(1, kept_.request().weight());
  head_start_ = std::max(head_start_, share - held_seconds_ / weight);
}

uint64_t Job::tiles_restored() const {
  uint64_t count = 0;
  for (const auto& end : ends_) {
    if (end) count += total(*end, "tiles_restored");
  }
  count += waiting_tiles().done;
  for (const Running& running : running_) count += running.active->report().tiles_restored;
  return count;
}

JobProgress Job::progress(Time now, bool works) const {
  JobProgress progress;
  const WaitingTiles waiting = waiting_tiles();
  progress.tiles_done = waiting.done;
  // Those that are not done and that nobody will trace: of frames that failed, given up, or taken
  // from equal frames.
  uint64_t untraced = waiting.coming;
  const auto add = [&](uint64_t done, uint64_t open) {
    progress.tiles_done += done;
    untraced += tiles_per_frame_ - std::min(tiles_per_frame_, done + open);
  };
  for (const auto& end : ends_) {
    if (end) add(total(*end, "tiles_done"), 0);
  }
  for (const Running& running : running_) {
    const ActiveFrame& active = *running.active;
    add(active.assembler().tiles_done(), active.scheduler().left().tiles);
  }
  progress.tiles_total = tiles_per_frame_ * ends_.size();
  progress.elapsed_seconds = meter_.seconds(now, works);
  progress.remaining_seconds = -1;
  if (works) {
    const uint64_t closed = progress.tiles_done + untraced;
    const uint64_t open = progress.tiles_total - std::min(closed, progress.tiles_total);
    progress.remaining_seconds = meter_.remaining_seconds(
        traced(), left(open), progress.tiles_total, leases(), working_threads());
  }
  return progress;
}

}  // namespace tessera
