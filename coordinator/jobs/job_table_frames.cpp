// Which frames of jobs run, and how they begin and end: the other half of JobTable.
#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <unordered_set>
#include <utility>

#include "base/log.h"
#include "coordinator/jobs/frame_number.h"
#include "coordinator/jobs/job_table.h"
#include "job/check_job.h"
#include "job/job_messages.h"
#include "proto/wire/printable.h"
#include "proto/wire/scene_codec.h"
#include "renderer/film/film.h"

namespace tessera {
namespace {

constexpr size_t kKeptTraces = 16;

void log_end(const Job& job, uint32_t frame, const v1::JobEnd& end) {
  const std::string of_it =
      job.frame_count() > 1 ? fmt::format(" frame {}", job.number_of(frame)) : "";
  const std::string what = fmt::format("job {}{}", job.id(), of_it);
  switch (end.how()) {
    case v1::JobEnd::FAILED:
      return spdlog::warn("{} failed: {}", what, printable(end.failure()));
    case v1::JobEnd::INTERRUPTED:
      // Where its client was gone, that was told before.
      return spdlog::info("{} was cancelled", what);
    default:
      return spdlog::info("{} is done, traced in {:.2f} s", what, end.trace_seconds());
  }
}

void log_going_on(const Job& job, Time now) {
  const JobProgress progress = job.progress(now, false);
  const std::string& name = job.request().name();
  spdlog::info("job {}{} goes on: {} of {} tiles are kept, {} to do", job.id(),
               name.empty() ? "" : " (" + printable(name) + ")", progress.tiles_done,
               progress.tiles_total, progress.tiles_total - progress.tiles_done);
}

}  // namespace

void JobTable::list_running() {
  running_.clear();
  for (const auto& [id, job] : open_) {
    for (Job::Running& running : job->running()) running_.push_back(running.active.get());
  }
}

const ActiveFrame* JobTable::running(uint64_t frame) const {
  for (const ActiveFrame* active : running_) {
    if (active->id() == frame) return active;
  }
  return nullptr;
}

ActiveFrame* JobTable::running(uint64_t frame) {
  return const_cast<ActiveFrame*>(std::as_const(*this).running(frame));
}

const std::vector<ActiveFrame*>& JobTable::by_need() {
  needs_.clear();
  for (const auto& [id, job] : open_) {
    if (job->running().empty()) continue;
    const double share = job->share();
    if (!job->kept().paused()) needs_.push_back({{job->request().priority(), share}, job});
  }
  if (needs_.size() > 1) {
    std::stable_sort(needs_.begin(), needs_.end(),
                     [](const auto& a, const auto& b) { return is_needier(a.first, b.first); });
  }
  by_need_.clear();
  for (const auto& [need, job] : needs_) {
    for (Job::Running& running : job->running()) {
      running.active->set_priority(need.priority);
      by_need_.push_back(running.active.get());
    }
  }
  return by_need_;
}

std::vector<int32_t> JobTable::served() const {
  std::vector<int32_t> result;
  for (const auto& [id, job] : open_) {
    const int32_t priority = job->request().priority();
    const bool is_known = std::find(result.begin(), result.end(), priority) != result.end();
    if (!is_known && job->leases() > 0) result.push_back(priority);
  }
  return result;
}

void JobTable::account(Time now) {
  const std::vector<int32_t> served = this->served();
  for (const auto& [id, job] : open_) {
    if (!job->running().empty()) job->account(now, job->works(served));
  }
}

BeginLimits JobTable::limits() const {
  BeginLimits limits = rules_.begin;
  limits.film_bytes = std::min(limits.film_bytes, rules_.client_budget_bytes);
  return limits;
}

OpenJob JobTable::open_job(const Job& job, Time now) const {
  OpenJob open{job.id(), job.request().priority(), job.kept().paused()};
  for (const Job::Running& running : job.running()) {
    const ActiveFrame& active = *running.active;
    open.begun.push_back({running.frame, film_bytes_of(job, running.frame),
                          active.scheduler().live_count(), active.scheduler().has_pending(),
                          !job.local() && !active.waits_for_store()});
  }
  const auto next = open.paused ? std::nullopt : job.next_frame(now);
  if (!next) return open;
  // What it would trace may be being traced.
  const auto key_of = [&job](uint32_t frame) {
    return has_frame(job.kept(), frame) ? job.kept().tile_keys(static_cast<int>(frame))
                                        : std::string();
  };
  const bool is_traced =
      std::any_of(job.running().begin(), job.running().end(),
                  [&](const auto& running) { return key_of(running.frame) == key_of(*next); });
  if (!is_traced) open.next = {*next, film_bytes_of(job, *next)};
  return open;
}

std::vector<OpenJob> JobTable::open_jobs(Time now) const {
  std::vector<OpenJob> result;
  for (const auto& [id, job] : open_) {
    OpenJob open = open_job(*job, now);
    if (!open.begun.empty() || open.next) result.push_back(std::move(open));
  }
  return result;
}

FarmState JobTable::state(Time now) const {
  FarmState state{workers_, limits(), {}, served(), store_trouble()};
  for (const auto& [id, job] : open_) {
    if (!job->running().empty()) state.begun.push_back(open_job(*job, now));
  }
  return state;
}

uint64_t JobTable::film_bytes_of(const Job& job, uint32_t frame) {
  return job.local() ? 0 : tessera::film_bytes_of(job.request(), frame);
}

std::string JobTable::broken_rule(Time now) const {
  return distrusted_.empty() ? tessera::broken_rule(open_jobs(now), limits()) : "";
}

JobTable::Changes JobTable::advance(Time now) {
  Changes changes = std::exchange(changes_, {});
  for (auto it = open_.begin(); it != open_.end();) {
    Job& job = *it->second;
    for (size_t i = 0; i < job.running().size();) {
      Job::Running& running = job.running()[i];
      ActiveFrame& active = *running.active;
      const auto& shortage = active.shortage();
      if (shortage && job.local()) active.fail(ExitCode::render_failed, shortage->cause);
      if (active.ended()) {
        finish(job, running, changes);
      } else if (shortage && !active.waits_for_store()) {
        const Job::Hold cause{.cause = shortage->cause,
                              .until_another_worker = shortage->until_another_worker};
        const uint32_t frame = running.frame;
        put_aside(job, frame, changes);
        hold(job, frame, cause);
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
  // What is kept of a frame may be of a key that is convicted.
  if (!distrusted_.empty()) return changes;
  const BeginPlan plan = plan_begin(open_jobs(now), limits());
  for (const FrameOfJob& aside : plan.put_aside) {
    put_aside(*open_.at(aside.job), aside.frame, changes);
  }
  for (const FrameOfJob& next : plan.begin) begin(*open_.at(next.job), next.frame, now, changes);
  changes.settled = changes.ended.empty() && plan.begin.empty();
  return changes;
}

void JobTable::put_aside(Job& job, uint32_t frame, Changes& changes) {
  for (const Job::Running& running : job.running()) {
    if (running.frame == frame) changes.ended.push_back(running.active->id());
  }
  job.put_aside(frame);
  list_running();
}

BlobData JobTable::load_blob(const std::string& hex) {
  BlobData data = store_->find_blob(Digest::from_hex(hex));
  if (!data) {
    throw temporary_error(fmt::format(
        "blob {} is gone from the store, or was damaged; submit its scene again and this goes on",
        hex));
  }
  return data;
}

PackedScene JobTable::load_scene(Job& job, uint32_t frame) {
  const std::string& hex = job.request().frames(static_cast<int>(frame)).scene_digest();
  PackedScene scene{load_blob(hex), Digest::from_hex(hex)};
  auto known = job.scenes().find(scene.digest);
  if (known == job.scenes().end()) {
    const auto read =
        parse_scene({reinterpret_cast<const char*>(scene.bytes->data()), scene.bytes->size()});
    auto facts = read ? facts_of(*read) : std::nullopt;
    if (!facts) throw scene_error("the submitted bytes are no scene");
    known = job.scenes().emplace(scene.digest, std::move(*facts)).first;
  }
  scene.moves = known->second.moves;
  return scene;
}

BlobStore JobTable::load_blobs_of(Job& job, const PackedScene& scene) {
  BlobStore blobs;
  std::optional<Error> lost;
  for (const v1::BlobRef& ref : job.scenes().at(scene.digest).blobs) {
    try {
      blobs.put(Digest::from_hex(ref.digest()), load_blob(ref.digest()));
    } catch (const Error& error) {
      // The others are looked at too, so that who submits the scene again brings all that is lost.
      if (!lost) lost = error;
    }
  }
  if (lost) throw *lost;
  return blobs;
}

const TileCosts* JobTable::earlier_costs(const Job& job) const {
  if (job.local()) return local_costs_ ? &*local_costs_ : nullptr;
  if (!job.running().empty()) return &job.running().back().active->scheduler().costs();
  return job.last_costs() ? &*job.last_costs() : nullptr;
}

JobRules JobTable::rules_for(const Job& job) const {
  JobRules rules = rules_;
  rules.adopts = job.id() <= last_job_before_;
  return rules;
}

TileKeeping JobTable::keeping_of(const Job& job) const {
  return job.local() ? TileKeeping{job.local_tiles(), false} : TileKeeping{store_, true};
}

void JobTable::begin(Job& job, uint32_t frame, Time now, Changes& changes) {
  // One that comes, or comes back, owes nothing to those that have been there.
  if (job.running().empty()) {
    std::optional<double> least;
    for (const auto& [id, other] : open_) {
      const bool peer = !other->running().empty() && !other->kept().paused() &&
                        other->request().priority() == job.request().priority();
      if (peer) least = std::min(least.value_or(1e300), other->share());
    }
    job.account(now, false);
    if (least) job.catch_up(*least);
  }
  const PixelRect local_crop = job.local() ? job.local_crop() : PixelRect{};
  const auto fail = [&](ExitCode code, const std::string& why) {
    JobReport report;
    report.end = JobReport::End::failed;
    report.exit_code = code;
    report.failure = why;
    if (!job.local()) return file_end(job, frame, to_message(report));
    report.holes = {local_crop};
    JobResult result{std::move(report), Film(local_crop)};
    result.film.mark_hole(local_crop);
    end_local(job, frame, std::move(result));
  };
  try {
    const uint64_t film = film_bytes_of(job, frame);
    if (const uint64_t most = limits().film_bytes; film > most)
      throw render_error(fmt::format("a picture of {} bytes; expected at most {}", film, most));
    auto active = make_active(job, frame, now);
    tiles_restored_ += active->report().tiles_restored;
    if (const TileCosts* earlier = earlier_costs(job)) {
      active->scheduler().costs().learn_from(*earlier);
    }
    changes.begun.push_back(active.get());
    const bool goes_on = !job.local() && job.id() <= last_job_before_ && !job.begun();
    active->set_priority(job.request().priority());
    job.begin(frame, std::move(active));
    if (goes_on) log_going_on(job, now);
    list_running();
  } catch (const Error& error) {
    if (error.code() != ExitCode::try_again || job.local()) return fail(error.code(), error.what());
    hold(job, frame, {.cause = error.what(), .until = now + job.next_pause(frame)});
  } catch (const std::bad_alloc&) {
    if (job.local()) throw;
    const v1::PixelRect& crop = job.request().crop();
    hold(job, frame,
         {.cause = fmt::format("the coordinator has no memory for {}x{} pixels with their scene",
                               crop.x1() - crop.x0(), crop.y1() - crop.y0()),
          .until = now + job.next_pause(frame)});
  }
}

void JobTable::hold(Job& job, uint32_t frame, Job::Hold hold) {
  const auto before = job.holds().find(frame);
  if (before == job.holds().end() || before->second.cause != hold.cause) {
    const std::string of_it =
        job.frame_count() > 1 ? fmt::format("frame {} of ", job.number_of(frame)) : "";
    spdlog::warn("{}job {} is held: {}", of_it, job.id(), printable(hold.cause));
  }
  job.hold(frame, std::move(hold));
}

std::unique_ptr<ActiveFrame> JobTable::make_active(Job& job, uint32_t frame, Time now) {
  const FrameName name{frame_number(job.id(), frame), job.kept().id()};
  if (job.local()) {
    JobSpec spec = job.take_local_spec();
    const PackedScene scene = pack_scene(spec.scene);
    return std::make_unique<ActiveFrame>(name, std::move(spec), scene, keeping_of(job),
                                         rules_for(job), *keys_, now);
  }
  if (!has_frame(job.kept(), frame)) throw render_error("what the store has of it is damaged");
  const PackedScene scene = load_scene(job, frame);
  JobSpec spec;
  spec.blobs = load_blobs_of(job, scene);
  spec.frame = job.request().frames(static_cast<int>(frame)).settings();
  spec.crop = rect_of(job.request().crop());
  spec.tile_size = static_cast<int>(job.request().tile_size());
  check_job(spec);
  const auto expected = job.expected_films().find(frame);
  if (expected != job.expected_films().end() && expected->second.drop_tiles) {
    store_->drop_all(Digest::from_hex(job.kept().tile_keys(static_cast<int>(frame))));
    for (const uint32_t equal : job.waiting_equals(frame)) job.set_stored(equal, 0);
    expected->second.drop_tiles = false;
    expected->second.dropped = true;
  }
  auto active =
      std::make_unique<ActiveFrame>(name, std::move(spec), scene, keeping_of(job), rules_for(job),
                                    *keys_, now, job.scene_failures()[frame]);
  if (active->key().hex() != job.kept().tile_keys(static_cast<int>(frame))) {
    change_key(job, frame, active->key());
  }
  return active;
}

bool JobTable::shares_key(const Job& job, const std::string& key) const {
  return std::any_of(jobs_.begin(), jobs_.end(), [&](const auto& other) {
    const auto& keys = other.second->kept().tile_keys();
    return other.second.get() != &job && std::count(keys.begin(), keys.end(), key) > 0;
  });
}

void JobTable::change_key(Job& job, uint32_t frame, const Digest& key) {
  v1::KeptJob changed = job.kept();
  const std::string before = changed.tile_keys(static_cast<int>(frame));
  changed.set_tile_keys(static_cast<int>(frame), key.hex());
  store_->save(changed);
  job.kept() = std::move(changed);
  job.expected_films().erase(frame);
  const auto& keys = job.kept().tile_keys();
  if (std::count(keys.begin(), keys.end(), before) > 0 || shares_key(job, before)) return;
  spdlog::info("job {}: frame {} is computed otherwise by this program: it begins anew", job.id(),
               job.number_of(frame));
  store_->drop_all(Digest::from_hex(before));
}

bool JobTable::is_expected(Job& job, uint32_t frame, v1::JobEnd& end) {
  const auto it = job.expected_films().find(frame);
  if (it == job.expected_films().end() || end.how() != v1::JobEnd::DONE ||
      end.film_digest() == it->second.digest) {
    return true;
  }
  forget_film(job, end.film_digest());
  if (!it->second.dropped) {
    it->second.drop_tiles = true;
    return false;
  }
  end.set_how(v1::JobEnd::FAILED);
  end.set_exit_code(static_cast<uint32_t>(ExitCode::render_failed));
  end.set_failure(
      fmt::format("traced again from nothing, the picture is {}; expected {}, as it was "
                  "when it was done first: one of the two is wrong",
                  end.film_digest(), it->second.digest));
  return true;
}

void JobTable::worker_has_come(WorkerId worker) {
  for (const auto& [id, job] : open_) {
    for (Job::Running& running : job->running()) running.active->note_another_worker();
    job->note_worker(worker);
  }
}

void JobTable::distrust(const std::string& key) {
  distrusted_.push_back(key);
  keep_rest();
}

void JobTable::redo_distrusted() {
  for (; !distrusted_.empty(); distrusted_.pop_back()) {
    const std::vector<StoredTile> tiles = store_->tiles_traced_by(distrusted_.back());
    std::unordered_set<std::string> keys;
    for (const StoredTile& tile : tiles) keys.insert(tile.key.hex());
    // First, so that nothing is left of them wherever this is cut short.
    for (const StoredTile& tile : tiles) store_->drop(tile.key, tile.rect);
    for (const auto& [id, job] : jobs_) {
      if (job->local() || job->kept().cancelled()) continue;
      for (uint32_t frame = 0; frame < job->frame_count(); ++frame) {
        if (!has_frame(job->kept(), frame) ||
            !keys.contains(job->kept().tile_keys(static_cast<int>(frame)))) {
          continue;
        }
        const bool is_open = !job->end_of(frame) && !running(id, frame);
        if (is_open) job->set_stored(frame, stored_tiles(*job, frame));
        job->expected_films().erase(frame);
        const auto& end = job->end_of(frame);
        if (!end || end->how() != v1::JobEnd::DONE) continue;
        spdlog::warn(
            "job {}: tiles of frame {} were traced by the key of {}: they are traced again", id,
            job->number_of(frame), keys_->name_of(distrusted_.back()));
        reopen(*job, frame);
      }
    }
  }
}

void JobTable::finish(Job& job, Job::Running& running, Changes& changes) {
  const uint64_t id = running.active->id();
  const uint32_t frame = running.frame;
  changes.ended.push_back(id);
  TileCosts costs = running.active->scheduler().costs();
  JobResult result = running.active->finish();
  if (job.local()) {
    local_costs_ = std::move(costs);
    return end_local(job, frame, std::move(result));
  }
  v1::JobEnd end = to_message(result.report);
  traces_.emplace_back(id, std::move(result.report.trace));
  if (traces_.size() > kKeptTraces) traces_.pop_front();
  job.last_costs() = std::move(costs);
  if (result.report.tiles_done > 0) {
    end.set_film_size(result.film.values().size_bytes());
    end.set_film_digest(films_.put(std::move(result.film), recipe_of(job.kept(), frame)).hex());
  }
  if (!is_expected(job, frame, end)) {
    job.put_aside(frame);
    list_running();
    return hold(job, frame, {.cause = "its tiles are not what they were", .until = Time{}});
  }
  file_end(job, frame, std::move(end));
}

void JobTable::end_local(Job& job, uint32_t frame, JobResult result) {
  job.end(frame, to_message(result.report));
  list_running();
  results_.emplace(frame_number(job.id(), frame), std::move(result));
}

void JobTable::file_end(Job& job, uint32_t frame, v1::JobEnd end) {
  end.set_worked_seconds(job.worked_seconds());
  end.set_traced_seconds(job.traced_seconds());
  log_end(job, frame, end);
  v1::KeptJob::End kept;
  kept.set_frame(frame);
  *kept.mutable_end() = end;
  job.end(frame, std::move(end));
  list_running();
  unsaved_.emplace_back(job.id(), std::move(kept));
  keep_rest();
}

void JobTable::keep_rest() {
  for (ActiveFrame* active : running()) {
    if (active->waits_for_store()) active->keep_rest();
  }
  try {
    redo_distrusted();
    while (!unsaved_.empty()) {
      store_->save_end(unsaved_.back().first, unsaved_.back().second);
      unsaved_.pop_back();
    }
    trouble_.clear();
  } catch (const Error& error) {
    trouble_ = error.what();
  }
}

void JobTable::keep_times(bool all) {
  try {
    for (const auto& [id, job] : open_) {
      const double kept = job->kept().worked_seconds(), more = job->worked_seconds() - kept;
      if (job->local() || !(more > 0)) continue;
      if (!all && more < std::clamp(kept / 20, 1., 10.)) continue;
      v1::KeptJob changed = kept_now(*job);
      store_->save(changed);
      job->kept() = std::move(changed);
    }
  } catch (const Error&) {
    // It is tried again; what else cannot be kept says why.
  }
}

std::string JobTable::store_trouble() const {
  if (!trouble_.empty()) return trouble_;
  for (const auto& [id, job] : open_) {
    for (const Job::Running& running : job->running()) {
      if (running.active->waits_for_store()) return running.active->store_trouble();
    }
  }
  return "";
}

std::optional<std::pair<BlobData, BlobStore>> JobTable::scene(uint64_t id, uint32_t frame) {
  Job* const job = find(id);
  if (!job || job->local() || frame >= job->frame_count()) return std::nullopt;
  const PackedScene scene = load_scene(*job, frame);
  return std::pair(scene.bytes, load_blobs_of(*job, scene));
}

JobTable::FoundBlob JobTable::find_blob(const Digest& digest) {
  for (ActiveFrame* active : running()) {
    if (BlobData data = active->find_blob(digest)) return {std::move(data), active};
  }
  FilmShelf::State state = FilmShelf::State::sound;
  BlobData film = films_.find(digest, &state);
  if (state != FilmShelf::State::sound) reopen(digest, state);
  return {std::move(film), nullptr};
}

void JobTable::reopen(const Digest& film, FilmShelf::State state) {
  const bool changed = state == FilmShelf::State::changed;
  for (const auto& [number, job] : jobs_) {
    const uint64_t id = number;
    if (job->local() || job->kept().cancelled()) continue;
    for (uint32_t frame = 0; frame < job->frame_count(); ++frame) {
      const auto& end = job->end_of(frame);
      if (!end || end->how() != v1::JobEnd::DONE || end->film_digest() != film.hex()) continue;
      spdlog::warn("job {}: tiles of frame {} are {}: they are traced again", id,
                   job->number_of(frame),
                   changed ? "not those of its picture any more" : "damaged in the store, or gone");
      std::erase_if(unsaved_, [&](const auto& unsaved) {
        return unsaved.first == id && unsaved.second.frame() == frame;
      });
      // The end stays in the store: the picture that it names is the one that is to come of this.
      job->reopen(frame, stored_tiles(*job, frame));
      job->expected_films()[frame] = {film.hex(), changed};
      open_.emplace(id, job.get());
    }
  }
}

}  // namespace tessera