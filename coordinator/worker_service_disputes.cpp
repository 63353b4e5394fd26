// What follows where workers differ or fail: a part of WorkerService.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/log.h"
#include "base/plural.h"
#include "coordinator/worker_service.h"

namespace tessera {
namespace {

constexpr int kMaxFailuresOfWorker = 3;

}  // namespace

void WorkerService::on_unseen(const WorkerRecord& worker, ActiveFrame& job,
                              const v1::SceneReady::Unseen& unseen, Time now) {
  if (!job.is_sound(unseen)) return;
  const auto other = job.contradicted(unseen);
  if (!other) return job.fill_unseen(unseen, worker.id);
  ++job.report().mismatches;
  ++counters_.mismatches;
  spdlog::error(
      "workers {} and {} differ in what lies past everything; expected the same: it is traced, and "
      "all that they trace of the job is traced by others too",
      name_of(*other), worker.name());
  act(job, job.distrust_unseen(*other, worker.id), now);
}

std::string WorkerService::name_of(WorkerId id) {
  if (id == kFromStore) return "(before)";
  const std::string& key = jobs_.keys().key_of(id);
  const std::string of_key =
      key.empty() ? "" : fmt::format(" (key of {})", jobs_.keys().name_of(key));
  const WorkerRecord* worker = workers_.by_id(id);
  return (worker ? worker->name() : "(before)") + of_key;
}

void WorkerService::convict(ActiveFrame& job, const Conviction& conviction, Time now) {
  const Mismatch& about = conviction.dispute;
  const WorkerId right = about.first == conviction.wrong ? about.second : about.first;
  const std::string what = fmt::format(
      "worker {} traced wrong pixels in row {} of tile {}, as workers {} and {} agree",
      name_of(conviction.wrong), about.row, about.tile, name_of(right), name_of(conviction.judge));
  spdlog::error("{}; {} is set aside, and all tiles of that are traced again", what,
                conviction.of_key ? "its key" : "it");
  ++job.report().liars;
  const std::string key = jobs_.keys().key_of(conviction.wrong);
  const bool of_key = conviction.of_key && !key.empty();
  if (of_key) {
    set_key_aside(key, what, now);
  } else {
    set_aside(conviction.wrong, what, now);
  }
  // What a store kept from before, by nobody knows whom, is of this job alone.
  const auto jobs = conviction.wrong == kFromStore ? std::vector{&job} : jobs_.running();
  for (ActiveFrame* each : jobs) apply(*each, each->redo_tiles_of(conviction.wrong, of_key), now);
  serve(now);
  if (of_key) jobs_.distrust(key);
}

void WorkerService::on_mismatch(ActiveFrame& job, Mismatch mismatch, Time now) {
  ++job.report().mismatches;
  ++counters_.mismatches;
  const bool again = !job.scheduler().disputed_by(mismatch.tile).empty();
  const std::string what = fmt::format(
      "tile {} from row {}: workers {} and {} traced different "
      "pixels; expected the same bits",
      mismatch.tile, mismatch.row, name_of(mismatch.first), name_of(mismatch.second));
  spdlog::error("{}", what);
  // Of a tile that several keys have made, nobody knows who is wrong.
  const bool is_known = mismatch.first != kFromStore || !jobs_.keys().by_key();
  if (!is_known) return act(job, job.retrace(mismatch.tile), now);
  const auto events = job.dispute(std::move(mismatch), now);
  if (again) return fail_or_hold(job, what);
  act(job, events, now);
}

void WorkerService::abandon_checks(ActiveFrame& job, Time now) {
  const WorkerKeys& keys = jobs_.keys();
  const auto present = workers_.present();
  // Another voter may have time once it is done with other jobs, or has built the scene.
  const auto is_awaited = [&](uint32_t tile, const std::vector<WorkerId>& traced_by) {
    return std::any_of(present.begin(), present.end(), [&](const WorkerRecord* worker) {
      const bool gets_on = now - worker->got_on < options_.lease;
      return gets_on && !worker->leaves && !job.scene_failed_at(worker->id) &&
             !job.scheduler().is_barred(tile, worker->id) &&
             std::none_of(traced_by.begin(), traced_by.end(), [&](WorkerId by) {
               return keys.voter_of(by) == keys.voter_of(worker->id);
             });
    });
  };
  if (const size_t count = job.scheduler().abandon_checks(now, is_awaited)) {
    spdlog::warn("{} could not be verified: there is no second worker{}", counted(count, "tile"),
                 keys.by_key() ? " of another key" : "");
  }
}

void WorkerService::fail_undecided(ActiveFrame& job, Time now) {
  // Nobody is given a tile meanwhile.
  if (draining_ || !jobs_.store_trouble().empty()) return;
  const auto tile = job.scheduler().undecided(now, [&](WorkerId id) {
    const WorkerRecord* const worker = workers_.by_id(id);
    return worker && now - worker->got_on < options_.lease;
  });
  if (!tile) return;
  const auto& by = job.scheduler().disputed_by(*tile);
  fail_or_hold(job,
               fmt::format("tile {}: workers {} and {} traced different pixels, and there is no "
                           "third to decide",
                           *tile, name_of(by[0]), name_of(by[1])));
}

void WorkerService::fail_or_hold(ActiveFrame& job, const std::string& why) {
  // One of the keys would have ended the job alone.
  if (jobs_.keys().by_key()) return job.fall_short({why});
  job.fail(ExitCode::render_failed, why);
}

void WorkerService::put_barred_aside(ActiveFrame& job) {
  const auto present = workers_.present();
  if (present.empty()) return;
  for (const uint32_t tile : job.scheduler().barred_tiles()) {
    const TileScheduler::TileView view = job.scheduler().view(tile);
    const bool nobody =
        std::all_of(present.begin(), present.end(), [&](const WorkerRecord* worker) {
          return job.scene_failed_at(worker->id) || job.scheduler().is_barred(tile, worker->id);
        });
    if (view.done || view.given_up || view.copies > 0 || !nobody) continue;
    job.fall_short(
        {fmt::format("workers of one key alone, {}, failed tile {} or vanished with it: a "
                     "worker of another key is waited for",
                     jobs_.keys().name_of(jobs_.keys().key_of(present.front()->id)), tile)});
    return;
  }
}

void WorkerService::set_aside(WorkerId id, const std::string& cause, Time now) {
  if (id == kFromStore) return;
  workers_.set_aside(id, cause);
  ++counters_.workers_set_aside;
  if (WorkerRecord* const worker = workers_.by_id(id)) refuse(*worker, now);
}

void WorkerService::set_key_aside(const std::string& key, const std::string& cause, Time now) {
  const std::string name = jobs_.keys().name_of(key);
  workers_.set_key_aside(key, fmt::format("the key of {}: {}", name, cause));
  ++counters_.workers_set_aside;
  spdlog::error("all workers of the key of {} are set aside, until the list of keys is read again",
                name);
  for (WorkerRecord* each : workers_.with_key(key)) refuse(*each, now);
}

void WorkerService::refuse(WorkerRecord& worker, Time now) {
  const auto reject = workers_.judge(worker.hello, worker.sender);
  if (reject) *send(worker.peer).mutable_reject() = *reject;
  lose(worker, LossCause::left, "it is set aside", now);
}

bool WorkerService::key_is_blamed(const WorkerRecord& worker) {
  if (worker.sender.key.empty()) return false;
  bool are_others = false;
  for (const WorkerRecord* other : workers_.present()) {
    if (other == &worker) continue;
    if (other->sender.key == worker.sender.key) return false;
    are_others |= workers_.blamed(*other) < kMaxFailuresOfWorker;
  }
  return are_others;
}

void WorkerService::judge_failures(WorkerRecord& worker, Time now) {
  const int failures = workers_.blame(worker);
  if (worker.state == WorkerState::lost) return;
  const bool by_key = key_is_blamed(worker);
  if ((by_key ? failures : worker.failures) < kMaxFailuresOfWorker) return;
  const auto present = workers_.present();
  const bool others =
      by_key || std::any_of(present.begin(), present.end(), [&](const WorkerRecord* other) {
        return other != &worker && other->failures < kMaxFailuresOfWorker;
      });
  // The last one is kept, for want of a better.
  if (!others) return;
  const std::string whose =
      by_key ? fmt::format(" and earlier ones of its key ({})", worker.sender.name) : "";
  const std::string cause =
      fmt::format("worker {}{} failed {} tiles; expected none", worker.name(),
                  failures > worker.failures ? whose : "", by_key ? failures : worker.failures);
  if (by_key) return set_key_aside(worker.sender.key, cause, now);
  set_aside(worker.id, cause, now);
}

}  // namespace tessera
