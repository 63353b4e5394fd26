#include "coordinator/jobs/job_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <unordered_set>
#include <utility>

#include "base/log.h"
#include "base/plural.h"
#include "coordinator/jobs/frame_number.h"
#include "coordinator/jobs/preview.h"
#include "coordinator/tiles/identity.h"
#include "job/check_job.h"
#include "job/job_messages.h"
#include "job/scene_motion.h"
#include "job/tile_grid.h"
#include "proto/wire/printable.h"

namespace tessera {
namespace {

constexpr size_t kMaxJobs = 4096;
/// Of who paused a job, in bytes.
constexpr size_t kMostBy = 200;

}  // namespace

bool JobTable::has_frame(const v1::KeptJob& kept, uint32_t frame) {
  return std::cmp_less(frame, std::min(kept.request().frames_size(), kept.tile_keys_size()));
}

FilmShelf::Recipe JobTable::recipe_of(const v1::KeptJob& kept, uint32_t frame) {
  const v1::SubmitJob& request = kept.request();
  return {Digest::from_hex(kept.tile_keys(static_cast<int>(frame))), rect_of(request.crop()),
          static_cast<int>(request.tile_size()), aovs_of(request, frame)};
}

JobTable::JobTable(const JobRules& rules, std::shared_ptr<JobStore> store)
    : rules_(rules), store_(std::move(store)), films_(store_) {
  last_job_ = store_->last_job();
  std::unordered_set<Digest> blobs;
  for (v1::KeptJob& kept : store_->jobs()) {
    for (const std::string& hex : kept.blobs()) blobs.insert(Digest::from_hex(hex));
    for (const v1::KeptJob::End& end : kept.ends()) {
      const auto film = Digest::parse(end.end().film_digest());
      if (film && has_frame(kept, end.frame())) films_.note(*film, recipe_of(kept, end.frame()));
    }
    last_job_ = std::max(last_job_, kept.job());
    auto job = std::make_unique<Job>(std::move(kept));
    by_submission_[job->request().submission()] = job->id();
    count_stored(*job);
    add(std::move(job));
  }
  last_job_before_ = last_job_;
  store_->keep_only_blobs(blobs);
  keep_rest();
  if (jobs_.empty()) return;
  spdlog::info("the store has {}, of which {} not ended", counted(jobs_.size(), "job"),
               open_.size() == 1 ? "1 has" : fmt::format("{} have", open_.size()));
}

uint64_t JobTable::stored_tiles(const Job& job, uint32_t frame) {
  if (!has_frame(job.kept(), frame)) return 0;
  const auto key = Digest::parse(job.kept().tile_keys(static_cast<int>(frame)));
  try {
    return key ? store_->tile_count(*key) : 0;
  } catch (const Error& error) {
    spdlog::warn("{}; how far job {} is cannot be told before it is begun", error.what(), job.id());
    return 0;
  }
}

void JobTable::count_stored(Job& job) {
  for (uint32_t frame = 0; frame < job.frame_count() && !job.ended(); ++frame) {
    if (job.end_of(frame)) continue;
    if (const uint64_t tiles = stored_tiles(job, frame)) job.set_stored(frame, tiles);
  }
}

void JobTable::add(std::unique_ptr<Job> job) {
  const uint64_t id = job->id();
  if (!job->ended()) open_.emplace(id, job.get());
  jobs_.emplace(id, std::move(job));
}

v1::JobStatus JobTable::status(const Job& job, uint32_t frame, Time now) const {
  return status(job, frame, state(now), now);
}

void JobTable::each_status(uint64_t after, Time now,
                           const std::function<bool(v1::JobStatus)>& take) const {
  const FarmState farm = state(now);
  for (auto it = jobs_.upper_bound(after); it != jobs_.end(); ++it) {
    if (!it->second->local() && !take(status(*it->second, 0, farm, now))) return;
  }
}

v1::JobStatus JobTable::status(const Job& job, uint32_t frame, const FarmState& farm,
                               Time now) const {
  v1::JobStatus status = status_of(job, open_job(job, now), farm, frame, now);
  const bool unsaved = std::any_of(unsaved_.begin(), unsaved_.end(),
                                   [&job](const auto& end) { return end.first == job.id(); });
  // Nobody is told of an end that a coordinator after this one would not know of.
  if (!unsaved || !job.request().detached() || job.kept().cancelled()) return status;
  if (status.state() == v1::JobStatus::ENDED) status.set_state(v1::JobStatus::RUNNING);
  status.clear_end();
  status.clear_how();
  status.clear_exit_code();
  status.set_failure(farm.trouble);
  status.set_waits_for("the store: " + farm.trouble);
  return status;
}

void JobTable::describe(FarmSnapshot& snapshot, Time now) const {
  const FarmState farm = state(now);
  snapshot.store_trouble = farm.trouble;
  snapshot.counters.tiles_restored = tiles_restored_;
  snapshot.counters.jobs_accepted = jobs_accepted_;
  snapshot.counters.commit_seconds = store_->commit_seconds();
  for (const auto& [id, job] : jobs_) {
    if (job->local()) continue;
    snapshot.jobs.push_back(tessera::describe(*job, open_job(*job, now), farm, now));
  }
}

std::optional<JobProgress> JobTable::progress(uint64_t frame, Time now) const {
  const auto it = open_.find(job_of_number(frame));
  if (it == open_.end() || it->second->running().empty()) return std::nullopt;
  return it->second->progress(now, it->second->works(served()));
}

std::vector<std::pair<uint64_t, uint32_t>> JobTable::running_frames() const {
  std::vector<std::pair<uint64_t, uint32_t>> result;
  for (const auto& [id, job] : open_) {
    for (const Job::Running& running : job->running()) result.emplace_back(id, running.frame);
  }
  return result;
}

const ActiveFrame* JobTable::running(uint64_t job, uint32_t frame) const {
  const auto it = open_.find(job);
  if (it == open_.end()) return nullptr;
  for (const Job::Running& running : it->second->running()) {
    if (running.frame == frame) return running.active.get();
  }
  return nullptr;
}

std::optional<FilmView> JobTable::film(uint64_t id, uint32_t frame) {
  if (const ActiveFrame* active = running(id, frame)) {
    const Film& film = active->assembler().film();
    return FilmView{film.rect(), film.channels(), film.values(), nullptr};
  }
  const Job* const job = find(id);
  const auto end = job && frame < job->frame_count() ? job->end_of(frame) : std::nullopt;
  BlobData pixels = end ? films_.find(Digest::from_hex(end->film_digest())) : nullptr;
  if (job && !end && job->stored(frame) > 0 && has_frame(job->kept(), frame)) {
    auto part = films_.part(recipe_of(job->kept(), frame));
    if (part) pixels = FilmShelf::to_blob(std::move(part->first));
  }
  const PixelRect rect = job ? rect_of(job->request().crop()) : PixelRect{};
  const int channels = job ? aovs_of(job->request(), frame).channels() : kFilmChannels;
  const size_t count = static_cast<size_t>(rect.area()) * static_cast<size_t>(channels);
  if (!pixels || pixels->size() != count * sizeof(float)) return std::nullopt;
  return FilmView{rect, channels, {reinterpret_cast<const float*>(pixels->data()), count}, pixels};
}

std::optional<PreviewImage> JobTable::preview(uint64_t id, uint32_t frame, int most_side) {
  Job* const job = find(id);
  if (!job || frame >= job->frame_count()) return std::nullopt;
  const v1::Output& output = job->request().frames(static_cast<int>(frame)).output();
  if (const ActiveFrame* active = running(id, frame)) {
    if (active->assembler().tiles_done() == 0) return std::nullopt;
    return make_preview(active->assembler().film(), output, active->assembler().tiles_done(),
                        most_side);
  }
  const auto& end = job->end_of(frame);
  if (!end && job->stored(frame) > 0 && has_frame(job->kept(), frame)) {
    const auto part = films_.part(recipe_of(job->kept(), frame));
    if (part) return make_preview(part->first, output, part->second, most_side);
  }
  const BlobData pixels = end ? films_.find(Digest::from_hex(end->film_digest())) : nullptr;
  if (!pixels) return std::nullopt;
  try {
    Film film(rect_of(job->request().crop()), aovs_of(job->request(), frame));
    std::memcpy(film.values().data(), pixels->data(),
                std::min(pixels->size(), film.values().size_bytes()));
    return make_preview(film, output, from_message(*end).tiles_done, most_side);
  } catch (const std::bad_alloc&) {
    return std::nullopt;
  }
}

int32_t JobTable::number_of(uint64_t job, uint32_t frame) const {
  const auto found = jobs_.find(job);
  const bool is_known = found != jobs_.end() && frame < found->second->frame_count();
  return is_known ? found->second->number_of(frame) : static_cast<int32_t>(frame) + 1;
}

std::shared_ptr<const FrameTrace> JobTable::trace(uint64_t job, uint32_t frame) const {
  if (const ActiveFrame* active = running(job, frame)) {
    return std::make_shared<const FrameTrace>(active->trace());
  }
  const uint64_t id = frame_number(job, frame);
  for (const auto& [ended, trace] : traces_) {
    if (ended == id) return trace;
  }
  return nullptr;
}

// ------------------------------------------------------------------------- jobs of this process

uint64_t JobTable::submit(JobSpec spec, std::shared_ptr<TileStore> tiles) {
  check_job(spec);
  const uint64_t id = ++last_job_;
  auto job = std::make_unique<Job>(id, std::move(spec), std::move(tiles));
  job->kept().set_id(job_id_of(rules_.opening, id));
  add(std::move(job));
  return frame_number(id, 0);
}

void JobTable::interrupt(uint64_t frame, Time now) {
  for (const auto& [id, job] : open_) {
    if (!job->local() || frame_number(id, 0) != frame) continue;
    if (job->running().empty()) job->begin(0, make_active(*job, 0, now));
    job->running().front().active->interrupt();
  }
}

void JobTable::abandon(uint64_t frame) {
  results_.erase(frame);
  const auto at = std::ranges::find_if(open_, [&](const auto& open) {
    return open.second->local() && frame_number(open.first, 0) == frame;
  });
  if (at == open_.end()) return;
  const auto [id, job] = *at;
  for (const Job::Running& running : job->running()) changes_.ended.push_back(running.active->id());
  open_.erase(at);
  jobs_.erase(id);
  list_running();
}

std::optional<JobResult> JobTable::take_result(uint64_t frame) {
  const auto it = results_.find(frame);
  if (it == results_.end()) return std::nullopt;
  std::optional<JobResult> result = std::move(it->second);
  results_.erase(it);
  return result;
}

// ------------------------------------------------------------------------------ jobs of clients

void JobTable::accept(v1::SubmitJob request, const std::vector<Digest>& blobs,
                      SceneFactsMap scenes) {
  if (jobs_.size() >= kMaxJobs) {
    throw render_error(
        fmt::format("the coordinator has {} jobs; expected fewer: forget some", jobs_.size()));
  }
  v1::KeptJob kept;
  JobSpec probe;
  probe.crop = rect_of(request.crop());
  probe.tile_size = static_cast<int>(std::min<uint32_t>(request.tile_size(), kMaxFrameSide));
  for (const v1::JobFrame& frame : request.frames()) {
    probe.frame = frame.settings();
    check_job(probe);
    const Digest scene = Digest::from_hex(frame.scene_digest());
    kept.add_tile_keys(
        tile_key(scene, settled(frame.settings(), scenes.at(scene).moves), probe.crop).hex());
  }
  if (request.frames().empty()) throw usage_error("a job without frames; expected at least one");
  if (probe.tile_size == 0) {
    const int threads = threads_ > 0 ? static_cast<int>(threads_) : rules_.expected_workers;
    probe.tile_size = choose_tile_size(probe.crop, threads);
  }
  request.set_tile_size(static_cast<uint32_t>(probe.tile_size));
  for (const Digest& blob : blobs) kept.add_blobs(blob.hex());
  kept.set_job(last_job_ + 1);
  kept.set_id(job_id_of(rules_.opening, kept.job()));
  *kept.mutable_request() = std::move(request);
  store_->save(kept);
  ++last_job_;
  auto job = std::make_unique<Job>(std::move(kept));
  job->scenes() = std::move(scenes);
  by_submission_[job->request().submission()] = job->id();
  count_stored(*job);
  add(std::move(job));
  ++jobs_accepted_;
}

Job* JobTable::find(uint64_t id) {
  const auto it = jobs_.find(id);
  return it == jobs_.end() || it->second->local() ? nullptr : it->second.get();
}

Job* JobTable::find_submission(uint64_t submission) {
  const auto it = by_submission_.find(submission);
  return it == by_submission_.end() ? nullptr : find(it->second);
}

v1::KeptJob JobTable::kept_now(const Job& job) {
  v1::KeptJob kept = job.kept();
  kept.set_worked_seconds(job.worked_seconds());
  kept.set_traced_seconds(job.traced_seconds());
  return kept;
}

void JobTable::pause(Job& job, bool paused, const std::string& by) {
  if (job.ended() || job.kept().paused() == paused) return;
  v1::KeptJob changed = kept_now(job);
  changed.set_paused(paused);
  changed.set_paused_by(paused && by.size() <= kMostBy ? printable(by) : "");
  store_->save(changed);
  job.kept() = std::move(changed);
}

void JobTable::set_priority(Job& job, int32_t priority) {
  if (priority < -kMostPriority || priority > kMostPriority) {
    throw usage_error(fmt::format("priority {}; expected a number from {} to {}", priority,
                                  -kMostPriority, kMostPriority));
  }
  v1::KeptJob changed = kept_now(job);
  changed.mutable_request()->set_priority(priority);
  store_->save(changed);
  job.kept() = std::move(changed);
}

void JobTable::cancel(Job& job) {
  if (job.ended() || job.kept().cancelled()) return;
  v1::KeptJob changed = kept_now(job);
  changed.set_cancelled(true);
  store_->save(changed);
  job.kept() = std::move(changed);
  while (!job.running().empty()) {
    job.running().front().active->interrupt();
    finish(job, job.running().front(), changes_);
  }
}

void JobTable::forget_film(const Job& job, const std::string& film) {
  if (film.empty()) return;
  films_.forget(Digest::from_hex(film));
  for (const auto& [id, other] : jobs_) {
    if (other.get() == &job) continue;
    for (uint32_t frame = 0; frame < other->frame_count(); ++frame) {
      const auto& end = other->end_of(frame);
      if (!end || end->film_digest() != film || !has_frame(other->kept(), frame)) continue;
      films_.note(Digest::from_hex(film), recipe_of(other->kept(), frame));
    }
  }
}

bool JobTable::retry(Job& job) {
  if (!job.holds().empty()) {
    job.release();
    return true;
  }
  if (!job.ended() || job.kept().cancelled()) return false;
  bool any = false;
  for (uint32_t frame = 0; frame < job.frame_count(); ++frame) {
    const auto& end = job.end_of(frame);
    if (!end || end->how() != v1::JobEnd::FAILED) continue;
    reopen(job, frame);
    any = true;
  }
  return any;
}

void JobTable::reopen(Job& job, uint32_t frame) {
  store_->remove_end(job.id(), frame);
  std::erase_if(unsaved_, [&](const auto& unsaved) {
    return unsaved.first == job.id() && unsaved.second.frame() == frame;
  });
  forget_film(job, job.end_of(frame)->film_digest());
  job.reopen(frame, stored_tiles(job, frame));
  open_.emplace(job.id(), &job);
}

void JobTable::forget(Job& job) {
  if (!job.ended()) return;
  std::unordered_set<std::string> others;
  for (const auto& [id, other] : jobs_) {
    if (id == job.id()) continue;
    for (const std::string& blob : other->kept().blobs()) others.insert(blob);
    for (const std::string& key : other->kept().tile_keys()) others.insert(key);
  }
  const auto only_here = [&others](const auto& names) {
    std::vector<Digest> result;
    for (const std::string& hex : names) {
      if (!others.contains(hex)) result.push_back(Digest::from_hex(hex));
    }
    return result;
  };
  const std::vector<Digest> keys = only_here(job.kept().tile_keys());
  store_->remove(job.id(), keys, only_here(job.kept().blobs()));
  std::unordered_set<std::string> films;
  for (uint32_t frame = 0; frame < job.frame_count(); ++frame) {
    if (const auto& end = job.end_of(frame)) films.insert(end->film_digest());
  }
  for (const std::string& film : films) forget_film(job, film);
  std::erase_if(unsaved_, [&](const auto& end) { return end.first == job.id(); });
  by_submission_.erase(job.request().submission());
  const uint64_t id = job.id();
  open_.erase(id);
  jobs_.erase(id);
}

}  // namespace tessera
