// What follows where workers differ or fail: a part of WorkerDesk.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/log.h"
#include "coordinator/worker_desk.h"

namespace tessera {
namespace {

constexpr int kMaxFailuresOfWorker = 3;

}  // namespace

void WorkerDesk::on_unseen(const WorkerRecord& worker, ActiveJob& job,
                           const v1::SceneReady::Unseen& unseen, Time now) {
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

std::string WorkerDesk::name_of(WorkerId id) {
  if (id == kFromStore) return "(before)";
  const WorkerRecord* worker = workers_.by_id(id);
  return worker ? worker->name() : "(forgotten)";
}

void WorkerDesk::convict(ActiveJob& job, const Conviction& conviction, Time now) {
  const Mismatch& about = conviction.dispute;
  const WorkerId right = about.first == conviction.wrong ? about.second : about.first;
  const std::string what = fmt::format(
      "worker {} traced wrong pixels in row {} of tile {}, as workers {} and {} agree",
      name_of(conviction.wrong), about.row, about.tile, name_of(right), name_of(conviction.judge));
  spdlog::error("{}; it is set aside, and all its tiles are traced again", what);
  ++job.report().liars;
  set_aside(conviction.wrong, what, now);
  // What is kept from before is of this job alone.
  const auto jobs = conviction.wrong == kFromStore ? std::vector{&job} : jobs_.running();
  for (ActiveJob* each : jobs) act(*each, each->redo_tiles_of(conviction.wrong), now);
}

void WorkerDesk::on_mismatch(ActiveJob& job, Mismatch mismatch, Time now) {
  ++job.report().mismatches;
  ++counters_.mismatches;
  const bool again = !job.scheduler().disputed_by(mismatch.tile).empty();
  const std::string what = fmt::format(
      "tile {} from row {}: workers {} and {} traced different "
      "pixels; expected the same bits",
      mismatch.tile, mismatch.row, name_of(mismatch.first), name_of(mismatch.second));
  spdlog::error("{}", what);
  const auto events = job.dispute(std::move(mismatch), now);
  if (again) return job.fail(ExitCode::render_failed, what);
  act(job, events, now);
}

void WorkerDesk::fail_undecided(ActiveJob& job, Time now) {
  const auto tile = job.scheduler().undecided(now);
  if (!tile) return;
  const auto& by = job.scheduler().disputed_by(*tile);
  job.fail(ExitCode::render_failed,
           fmt::format("tile {}: workers {} and {} traced different pixels, and there is no "
                       "third to decide",
                       *tile, name_of(by[0]), name_of(by[1])));
}

void WorkerDesk::set_aside(WorkerId id, const std::string& cause, Time now) {
  if (id == kFromStore) return;
  workers_.set_aside(id, cause);
  ++counters_.workers_set_aside;
  WorkerRecord* const worker = workers_.by_id(id);
  if (!worker) return;
  const auto reject = workers_.judge(worker->hello);
  if (reject) *send(worker->peer).mutable_reject() = *reject;
  lose(*worker, LossCause::left, "it is set aside", now);
}

void WorkerDesk::judge_failures(WorkerRecord& worker, Time now) {
  if (++worker.failures < kMaxFailuresOfWorker || worker.state == WorkerState::lost) return;
  const auto present = workers_.present();
  const bool others = std::any_of(present.begin(), present.end(), [&](const WorkerRecord* other) {
    return other != &worker && other->failures < kMaxFailuresOfWorker;
  });
  // The last one is kept, for want of a better.
  if (!others) return;
  set_aside(worker.id,
            fmt::format("worker {} failed {} tiles; expected none", worker.name(), worker.failures),
            now);
}

}  // namespace tessera
