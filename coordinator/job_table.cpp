#include "coordinator/job_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <unordered_set>
#include <utility>

#include "base/log.h"
#include "coordinator/job_status.h"
#include "coordinator/preview.h"
#include "job/check_job.h"
#include "job/job_messages.h"
#include "job/tile_grid.h"
#include "proto/wire/printable.h"
#include "proto/wire/scene_codec.h"

namespace tessera {
namespace {

constexpr int kFrameBits = 20;
constexpr size_t kMaxJobs = 4096;
// So many jobs have their scenes and films in memory; more only where they are more urgent.
constexpr size_t kMaxRunning = 8;
constexpr size_t kMaxRunningUrgent = 64;
/// Frames of one job at a time: the next begins when all tiles of the one before are given out.
constexpr size_t kMaxFramesOfJob = 2;

PixelRect rect_of(const v1::PixelRect& r) { return {r.x0(), r.y0(), r.x1(), r.y1()}; }

Digest digest_of(const std::string& hex) { return Digest::parse(hex).value_or(Digest{}); }

void log_end(const FarmJob& job, uint32_t frame, const v1::JobEnd& end) {
  const std::string of_it =
      job.frame_count() > 1 ? fmt::format(" frame {} of {}", frame + 1, job.frame_count()) : "";
  const std::string what = fmt::format("job {}{}", job.id(), of_it);
  switch (end.how()) {
    case v1::JobEnd::FAILED:
      return spdlog::warn("{} failed: {}", what, printable(end.failure()));
    case v1::JobEnd::INTERRUPTED:
      return spdlog::info("{} was cancelled, or its client is gone", what);
    default:
      return spdlog::info("{} is done, traced in {:.2f} s", what, end.trace_seconds());
  }
}

FilmShelf::Recipe recipe_of(const v1::KeptJob& kept, uint32_t frame) {
  return {digest_of(kept.tile_keys(static_cast<int>(frame))), rect_of(kept.request().crop()),
          static_cast<int>(kept.request().tile_size())};
}

}  // namespace

JobTable::JobTable(const CoordinatorOptions& options, std::shared_ptr<JobStore> store)
    : options_(options), store_(std::move(store)), films_(store_) {
  last_job_ = store_->last_job();
  std::unordered_set<Digest> blobs;
  for (v1::KeptJob& kept : store_->jobs()) {
    for (const std::string& hex : kept.blobs()) blobs.insert(digest_of(hex));
    for (const v1::KeptJob::End& end : kept.ends()) {
      const auto film = Digest::parse(end.end().film_digest());
      if (film) films_.note(*film, recipe_of(kept, end.frame()));
    }
    auto job = std::make_unique<FarmJob>(std::move(kept));
    by_submission_[job->request().submission()] = job->id();
    add(std::move(job));
  }
  store_->keep_only_blobs(blobs);
}

void JobTable::add(std::unique_ptr<FarmJob> job) {
  const uint64_t id = job->id();
  if (!job->ended()) open_.emplace(id, job.get());
  jobs_.emplace(id, std::move(job));
}

v1::JobStatus JobTable::status(const FarmJob& job, uint32_t frame, Time now) const {
  return status_of(job, frame, store_trouble(), now);
}

void JobTable::describe(FarmSnapshot& snapshot, Time now) const {
  snapshot.store_trouble = store_trouble();
  snapshot.counters.tiles_restored = tiles_restored_;
  snapshot.counters.jobs_accepted = jobs_accepted_;
  for (const auto& [id, job] : jobs_) {
    if (!job->local()) snapshot.jobs.push_back(tessera::describe(*job, now));
  }
}

const ActiveJob* JobTable::running(uint64_t job, uint32_t frame) const {
  const auto it = open_.find(job);
  if (it == open_.end()) return nullptr;
  for (const FarmJob::Running& running : it->second->running()) {
    if (running.frame == frame) return running.active.get();
  }
  return nullptr;
}

std::optional<PreviewImage> JobTable::preview(uint64_t id, uint32_t frame, int most_side) {
  FarmJob* const job = find(id);
  if (!job || frame >= job->frame_count()) return std::nullopt;
  const v1::Output& output = job->request().frames(static_cast<int>(frame)).output();
  if (const ActiveJob* active = running(id, frame)) {
    return make_preview(active->assembler().film(), output, active->assembler().tiles_done(),
                        most_side);
  }
  const auto& end = job->end_of(frame);
  const BlobData pixels = end ? films_.find(digest_of(end->film_digest())) : nullptr;
  if (!pixels) return std::nullopt;
  Film film(rect_of(job->request().crop()));
  std::memcpy(film.values().data(), pixels->data(),
              std::min(pixels->size(), film.values().size_bytes()));
  return make_preview(film, output, from_message(*end).tiles_done, most_side);
}

uint64_t JobTable::frame_id(uint64_t job, uint32_t frame) const {
  // Numbers of jobs that do not outlive us must differ from those of the coordinator before us.
  const uint64_t base = store_->farm() != 0 ? 0 : options_.epoch;
  return ((base + job) << kFrameBits) + frame + 1;
}

// ------------------------------------------------------------------------- jobs of this process

uint64_t JobTable::submit(JobSpec spec, Time now) {
  check_job(spec);
  const uint64_t id = ++last_job_;
  add(std::make_unique<FarmJob>(id, std::move(spec), now));
  return frame_id(id, 0);
}

void JobTable::interrupt(uint64_t frame, Time now) {
  for (const auto& [id, job] : open_) {
    if (!job->local() || frame_id(id, 0) != frame) continue;
    if (job->running().empty()) {
      job->begin(0, std::make_unique<ActiveJob>(frame, job->take_local_spec(), options_, now), now);
    }
    job->running().front().active->interrupt();
  }
}

std::optional<JobResult> JobTable::take_result(uint64_t frame) {
  const auto it = results_.find(frame);
  if (it == results_.end()) return std::nullopt;
  std::optional<JobResult> result = std::move(it->second);
  results_.erase(it);
  return result;
}

// ------------------------------------------------------------------------------ jobs of clients

void JobTable::accept(v1::SubmitJob request, const std::vector<Digest>& blobs, Time now) {
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
    kept.add_tile_keys(
        tile_key(digest_of(frame.scene_digest()), frame.settings(), probe.crop).hex());
  }
  if (request.frames().empty()) throw usage_error("a job without frames; expected at least one");
  if (probe.tile_size == 0) {
    probe.tile_size = choose_tile_size(probe.crop, options_.expected_workers);
  }
  request.set_tile_size(static_cast<uint32_t>(probe.tile_size));
  for (const Digest& blob : blobs) kept.add_blobs(blob.hex());
  kept.set_job(last_job_ + 1);
  *kept.mutable_request() = std::move(request);
  store_->save(kept);
  ++last_job_;
  auto job = std::make_unique<FarmJob>(std::move(kept), now);
  by_submission_[job->request().submission()] = job->id();
  add(std::move(job));
  ++jobs_accepted_;
}

FarmJob* JobTable::find(uint64_t id) {
  const auto it = jobs_.find(id);
  return it == jobs_.end() || it->second->local() ? nullptr : it->second.get();
}

FarmJob* JobTable::find_submission(uint64_t submission) {
  const auto it = by_submission_.find(submission);
  return it == by_submission_.end() ? nullptr : find(it->second);
}

void JobTable::pause(FarmJob& job, bool paused) {
  if (job.ended() || job.kept().paused() == paused) return;
  v1::KeptJob changed = job.kept();
  changed.set_paused(paused);
  store_->save(changed);
  job.kept() = std::move(changed);
}

void JobTable::set_priority(FarmJob& job, int32_t priority) {
  v1::KeptJob changed = job.kept();
  changed.mutable_request()->set_priority(priority);
  store_->save(changed);
  job.kept() = std::move(changed);
}

void JobTable::cancel(FarmJob& job) {
  if (job.ended() || job.kept().cancelled()) return;
  v1::KeptJob changed = job.kept();
  changed.set_cancelled(true);
  store_->save(changed);
  job.kept() = std::move(changed);
  while (!job.running().empty()) {
    job.running().front().active->interrupt();
    finish(job, job.running().front(), changes_);
  }
}

void JobTable::forget(FarmJob& job) {
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
      if (!others.contains(hex)) result.push_back(digest_of(hex));
    }
    return result;
  };
  const std::vector<Digest> keys = only_here(job.kept().tile_keys());
  store_->remove(job.id(), keys, only_here(job.kept().blobs()));
  for (uint32_t frame = 0; frame < job.frame_count(); ++frame) {
    const auto& end = job.end_of(frame);
    const bool shared = others.contains(job.kept().tile_keys(static_cast<int>(frame)));
    if (end && !shared) films_.forget(digest_of(end->film_digest()));
  }
  std::erase_if(unsaved_, [&](const auto& end) { return end.first == job.id(); });
  by_submission_.erase(job.request().submission());
  const uint64_t id = job.id();
  open_.erase(id);
  jobs_.erase(id);
}

// ------------------------------------------------------------------------------ frames that run

std::vector<ActiveJob*> JobTable::running() {
  std::vector<ActiveJob*> result;
  for (const auto& [id, job] : open_) {
    for (FarmJob::Running& running : job->running()) result.push_back(running.active.get());
  }
  return result;
}

ActiveJob* JobTable::running(uint64_t frame) {
  for (ActiveJob* active : running()) {
    if (active->id() == frame) return active;
  }
  return nullptr;
}

std::vector<ActiveJob*> JobTable::by_need(Time now) {
  struct Need {
    int32_t priority;
    double share;
    FarmJob* job;
  };
  std::vector<Need> needs;
  for (const auto& [id, job] : open_) {
    if (job->running().empty()) continue;
    const double share = job->share(now);
    if (!job->kept().paused()) needs.push_back({job->request().priority(), share, job});
  }
  std::stable_sort(needs.begin(), needs.end(), [](const Need& a, const Need& b) {
    return std::pair(-int64_t{a.priority}, a.share) < std::pair(-int64_t{b.priority}, b.share);
  });
  std::vector<ActiveJob*> result;
  for (const Need& need : needs) {
    for (FarmJob::Running& running : need.job->running()) result.push_back(running.active.get());
  }
  return result;
}

void JobTable::account(Time now) {
  for (const auto& [id, job] : open_) {
    if (!job->running().empty()) job->account(now);
  }
}

std::vector<FarmJob*> JobTable::startable() {
  std::vector<FarmJob*> result;
  for (const auto& [id, job] : open_) {
    if (!job->kept().paused() && job->next_frame()) result.push_back(job);
  }
  std::stable_sort(result.begin(), result.end(), [](const FarmJob* a, const FarmJob* b) {
    return a->request().priority() > b->request().priority();
  });
  return result;
}

bool JobTable::has_room_for(const FarmJob& job) const {
  if (!job.running().empty()) {
    const auto given_out = [](const FarmJob::Running& running) {
      return !running.active->scheduler().has_pending();
    };
    return job.running().size() < kMaxFramesOfJob &&
           std::all_of(job.running().begin(), job.running().end(), given_out);
  }
  size_t running = 0;
  int32_t least = std::numeric_limits<int32_t>::max();
  for (const auto& [id, other] : open_) {
    if (other->running().empty() || other->kept().paused()) continue;
    ++running;
    least = std::min(least, other->request().priority());
  }
  return running < kMaxRunning || (running < kMaxRunningUrgent && job.request().priority() > least);
}

JobTable::Changes JobTable::advance(Time now) {
  Changes changes = std::exchange(changes_, {});
  for (auto it = open_.begin(); it != open_.end();) {
    FarmJob& job = *it->second;
    for (size_t i = 0; i < job.running().size();) {
      if (job.running()[i].active->ended()) {
        finish(job, job.running()[i], changes);
      } else {
        ++i;
      }
    }
    if (!job.ended()) {
      ++it;
      continue;
    }
    it = open_.erase(it);
    if (job.local()) jobs_.erase(job.id());
  }
  for (FarmJob* job : startable()) {
    if (has_room_for(*job)) begin(*job, *job->next_frame(), now, changes);
  }
  return changes;
}

JobSpec JobTable::spec_of(FarmJob& job, uint32_t frame) {
  if (job.local()) return job.take_local_spec();
  const v1::SubmitJob& request = job.request();
  const v1::JobFrame& wanted = request.frames(static_cast<int>(frame));
  const auto load = [this](const std::string& hex) {
    BlobData data = store_->find_blob(digest_of(hex));
    if (!data) {
      throw render_error(
          fmt::format("blob {} is gone from the store, or damaged; submit the job again", hex));
    }
    return data;
  };
  const BlobData bytes = load(wanted.scene_digest());
  auto scene = parse_scene({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
  if (!scene) throw scene_error("the submitted bytes are no scene");
  JobSpec spec;
  for (const v1::BlobRef& ref : referenced_blobs(*scene).value_or(std::vector<v1::BlobRef>())) {
    spec.blobs.put(digest_of(ref.digest()), load(ref.digest()));
  }
  spec.scene = std::move(*scene);
  spec.frame = wanted.settings();
  spec.crop = rect_of(request.crop());
  spec.tile_size = static_cast<int>(request.tile_size());
  spec.store = store_;
  spec.must_keep = true;
  check_job(spec);
  return spec;
}

void JobTable::begin(FarmJob& job, uint32_t frame, Time now, Changes& changes) {
  // One that comes, or comes back, owes nothing to those that have been there.
  if (job.running().empty()) {
    std::optional<double> least;
    for (const auto& [id, other] : open_) {
      const bool peer = !other->running().empty() && !other->kept().paused() &&
                        other->request().priority() == job.request().priority();
      if (peer) least = std::min(least.value_or(1e300), other->share(now));
    }
    job.share(now);
    if (least) job.catch_up(*least);
  }
  try {
    auto active =
        std::make_unique<ActiveJob>(frame_id(job.id(), frame), spec_of(job, frame), options_, now);
    tiles_restored_ += active->report().tiles_restored;
    changes.begun.push_back(active.get());
    job.begin(frame, std::move(active), now);
  } catch (const Error& error) {
    JobReport report;
    report.end = JobReport::End::failed;
    report.exit_code = error.code();
    report.failure = error.what();
    file_end(job, frame, to_message(report));
  }
}

void JobTable::finish(FarmJob& job, FarmJob::Running& running, Changes& changes) {
  const uint64_t id = running.active->id();
  const uint32_t frame = running.frame;
  changes.ended.push_back(id);
  JobResult result = running.active->finish();
  v1::JobEnd end = to_message(result.report);
  if (job.local()) {
    job.end(frame, std::move(end));
    results_.emplace(id, std::move(result));
    return;
  }
  end.set_film_digest(films_.put(result.film, recipe_of(job.kept(), frame)).hex());
  end.set_film_size(result.film.values().size_bytes());
  file_end(job, frame, std::move(end));
}

void JobTable::file_end(FarmJob& job, uint32_t frame, v1::JobEnd end) {
  log_end(job, frame, end);
  v1::KeptJob::End kept;
  kept.set_frame(frame);
  *kept.mutable_end() = end;
  job.end(frame, std::move(end));
  unsaved_.emplace_back(job.id(), std::move(kept));
  keep_rest();
}

void JobTable::keep_rest() {
  for (ActiveJob* active : running()) {
    if (active->waits_for_store()) active->keep_rest();
  }
  try {
    while (!unsaved_.empty()) {
      store_->save_end(unsaved_.back().first, unsaved_.back().second);
      unsaved_.pop_back();
    }
    trouble_.clear();
  } catch (const Error& error) {
    trouble_ = error.what();
  }
}

std::string JobTable::store_trouble() const {
  if (!trouble_.empty()) return trouble_;
  for (const auto& [id, job] : open_) {
    for (const FarmJob::Running& running : job->running()) {
      if (running.active->waits_for_store()) return running.active->store_trouble();
    }
  }
  return "";
}

JobTable::FoundBlob JobTable::find_blob(const Digest& digest) {
  for (ActiveJob* active : running()) {
    if (BlobData data = active->find_blob(digest)) return {std::move(data), active};
  }
  return {films_.find(digest), nullptr};
}

}  // namespace tessera
