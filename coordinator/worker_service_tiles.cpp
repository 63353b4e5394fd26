// Who gets which tile: the other half of WorkerService.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "base/log.h"
#include "coordinator/worker_service.h"

namespace tessera {

size_t WorkerService::held_by(const WorkerRecord& worker) const {
  size_t held = 0;
  for (ActiveFrame* job : jobs_.running()) held += job->scheduler().held_by(worker.id);
  return held;
}

void WorkerService::fill(Time now) {
  for (WorkerRecord* worker : workers_.present()) fill(*worker, now);
}

void WorkerService::fill_idle(Time now) {
  const std::vector<ActiveFrame*>& jobs = jobs_.running();
  const auto any_pending = [&jobs] {
    return std::any_of(jobs.begin(), jobs.end(),
                       [](const ActiveFrame* job) { return job->scheduler().has_pending(); });
  };
  // There may be thousands, and one tile.
  std::set<WorkerId> hungry = std::exchange(idle_, {});
  while (!hungry.empty() && any_pending()) {
    const WorkerId id = hungry.extract(hungry.begin()).value();
    if (WorkerRecord* worker = workers_.by_id(id)) fill(*worker, now);
  }
  idle_.merge(hungry);
}

bool WorkerService::takes_tiles(const WorkerRecord& worker) {
  return worker.foreign == 0 && !worker.leaves && worker.state == WorkerState::active;
}

std::string WorkerService::broken_rule(Time now, bool has_ticked) const {
  if (draining_ || !jobs_.store_trouble().empty()) return "";
  const std::vector<ActiveFrame*>& jobs = jobs_.by_need();
  for (const auto& [id, worker] : workers_.all()) {
    const bool is_alone = std::any_of(jobs.begin(), jobs.end(), [id = id](const ActiveFrame* job) {
      return job->scheduler().isolates(id);
    });
    if (!takes_tiles(worker) || is_alone) continue;
    for (const ActiveFrame* job : jobs) {
      if (job->ended() || job->scene_failed_at(id) || !worker.ready_for(job->id())) continue;
      // What it was given just now of less urgent jobs could have been a tile of this one, but not
      // a piece of one that was split since because no other was left.
      size_t given = 0;
      for (const ActiveFrame* other : jobs) {
        if (other->priority() >= job->priority()) continue;
        const std::vector<Lease> leases = other->scheduler().leases_of(id);
        given +=
            static_cast<size_t>(std::count_if(leases.begin(), leases.end(), [&](const Lease& l) {
              return l.issued == now && other->scheduler().is_own(l.id);
            }));
      }
      const TileScheduler& scheduler = job->scheduler();
      if (given == 0 && !has_ticked) continue;
      const size_t held = held_by(worker) - given;
      const bool could = (held == 0 || given > 0) && held < worker.hello.credit() &&
                         held < scheduler.depth(worker.hello.threads()) &&
                         scheduler.has_tile_for(id, now, held > scheduler.held_by(id), given == 0);
      if (could) {
        return fmt::format("worker {} {} beside tiles of frame {} that it could trace", id,
                           given > 0 ? "was given less urgent tiles" : "idles", job->id());
      }
    }
  }
  return "";
}

void WorkerService::fill(WorkerRecord& worker, Time now) {
  if (draining_ || !jobs_.store_trouble().empty()) return;
  while (takes_tiles(worker) && held_by(worker) < worker.hello.credit()) {
    if (give_tile(worker, now)) continue;
    idle_.insert(worker.id);
    return;
  }
}

bool WorkerService::give_at_end(WorkerRecord& worker, const std::vector<ActiveFrame*>& jobs,
                                int32_t least, Time now) {
  const size_t held = held_by(worker);
  for (ActiveFrame* job : jobs) {
    if (job->priority() < least) break;
    if (job->ended() || !worker.ready_for(job->id())) continue;
    TileScheduler& scheduler = job->scheduler();
    SchedulerEvents events;
    const bool idle = held < worker.hello.threads();
    const auto lease =
        scheduler.assign_at_end(worker.id, now, held > scheduler.held_by(worker.id), idle, events);
    if (events.recalled) recall(*job, *events.recalled);
    if (!lease) continue;
    give(worker, *job, *lease, now);
    return true;
  }
  return false;
}

void WorkerService::cancel(const WorkerRecord& worker, const ActiveFrame& job, LeaseId lease) {
  v1::CancelTile& cancel = *send(worker.peer).mutable_cancel_tile();
  cancel.set_lease(lease);
  cancel.set_job(job.id());
}

void WorkerService::recall(const ActiveFrame& job, const Lease& lease) {
  const WorkerRecord* holder = workers_.by_id(lease.worker);
  if (!holder) return;
  idle_.insert(lease.worker);
  v1::CancelTile& cancel = *send(holder->peer).mutable_cancel_tile();
  cancel.set_lease(lease.id);
  cancel.set_job(job.id());
  cancel.set_unless_started(true);
}

void WorkerService::give(WorkerRecord& worker, ActiveFrame& job, const Lease& lease, Time now) {
  if (lease.speculative) ++counters_.speculative;
  if (lease.again) ++counters_.retries;
  job.note_assignment(now);
  *send(worker.peer).mutable_assign() = job.assignment(lease);
}

bool WorkerService::give_tile(WorkerRecord& worker, Time now) {
  const std::vector<ActiveFrame*>& jobs = jobs_.by_need();
  // Beside a tile that failed before, nothing else runs.
  for (ActiveFrame* job : jobs_.running()) {
    if (job->scheduler().isolates(worker.id)) return false;
  }
  const size_t held = held_by(worker);
  // It builds one scene at a time.
  bool builds = std::any_of(worker.jobs.begin(), worker.jobs.end(),
                            [](const auto& known) { return !known.second.ready; });
  bool full = false;
  int32_t least = std::numeric_limits<int32_t>::min();
  for (ActiveFrame* job : jobs) {
    if (job->ended() || job->scene_failed_at(worker.id)) continue;
    if (job->priority() < least) break;
    if (worker.ready_for(job->id())) {
      TileScheduler& scheduler = job->scheduler();
      if (held >= scheduler.depth(worker.hello.threads())) {
        full = true;
        // Behind tiles of less urgent jobs it would wait the longer.
        if (scheduler.has_pending()) least = job->priority();
        continue;
      }
      const auto lease = scheduler.assign(worker.id, now, held > scheduler.held_by(worker.id));
      if (!lease) continue;
      give(worker, *job, *lease, now);
      return true;
    }
    if (builds || worker.jobs.contains(job->id())) continue;
    if (worker.jobs.size() >= options_.scenes_of_worker) {
      const Forget forget = scene_to_forget(known_scenes(worker), job->priority());
      const bool has_pending = job->scheduler().has_pending();
      if (forget.waits && has_pending) least = job->priority();
      if (!forget.frame || !has_pending) continue;
      forget_scene(worker, *forget.frame);
    }
    tell(worker, *job, now);
    builds = true;
  }
  return !full && give_at_end(worker, jobs, least, now);
}

std::vector<KnownScene> WorkerService::known_scenes(const WorkerRecord& worker) const {
  std::vector<KnownScene> scenes;
  for (const auto& [id, known] : worker.jobs) {
    const ActiveFrame* const job = std::as_const(jobs_).running(id);
    if (job) scenes.push_back({id, job->priority(), job->scheduler().held_by(worker.id)});
  }
  return scenes;
}

void WorkerService::forget_scene(WorkerRecord& worker, uint64_t frame) {
  worker.jobs.erase(frame);
  send(worker.peer).mutable_cancel_job()->set_job(frame);
  // It holds no tile of it, so that nothing follows from it.
  if (ActiveFrame* job = jobs_.running(frame)) {
    job->scheduler().leave(worker.id, LossCause::left, Time{});
  }
}

void WorkerService::follow(const JobTable::Changes& changes, Time now) {
  // As after nearly every message, while there may be thousands of workers.
  if (changes.ended.empty() && changes.begun.empty()) return;
  for (WorkerRecord* worker : workers_.present()) {
    for (const uint64_t job : changes.ended) {
      if (worker->jobs.erase(job) > 0) send(worker->peer).mutable_cancel_job()->set_job(job);
    }
    for (ActiveFrame* job : changes.begun) job->note_worker(worker->id);
  }
  fill(now);
}

void WorkerService::note_work(WorkerRecord& worker, const v1::Heartbeat& heartbeat, Time now) {
  uint64_t work = 0;
  for (const auto& entry : heartbeat.progress())
    work += entry.work_done() + (entry.started() ? 1 : 0);
  const bool builds = std::any_of(heartbeat.jobs().begin(), heartbeat.jobs().end(),
                                  [](const auto& job) { return !job.ready(); });
  if (builds || work != worker.work_told) worker.got_on = now;
  worker.work_told = work;
}

void WorkerService::note_stalls(ActiveFrame& job, const std::vector<Lease>& stalled, Time now) {
  std::set<WorkerId> blamed;
  for (const Lease& lease : stalled) {
    const WorkerRecord* worker = workers_.by_id(lease.worker);
    // Else it is busy with another job's tiles.
    if (!worker || now - worker->got_on < options_.lease) continue;
    SchedulerEvents events = job.scheduler().stall(lease, now);
    if (blamed.insert(lease.worker).second) {
      note_stuck(*worker);
    } else {
      events.blamed.clear();
    }
    apply(job, events, now);
  }
}

void WorkerService::apply(ActiveFrame& job, const SchedulerEvents& events, Time now) {
  for (const Lease& lease : events.cancelled) {
    const WorkerRecord* worker = workers_.by_id(lease.worker);
    if (!worker) continue;
    job.note_span(FrameTrace::Kind::wasted, worker->id, worker->name(), lease.tile, lease.issued,
                  now);
    cancel(*worker, job, lease.id);
    freed_.insert(lease.worker);
  }
  counters_.tiles_given_up += events.given_up.size();
  for (const uint32_t tile : events.given_up) {
    spdlog::error("tile {} is given up: it failed too often", tile);
  }
  some_are_pending_ = some_are_pending_ || job.scheduler().has_pending();
  for (const WorkerId id : events.blamed) {
    idle_.insert(id);
    WorkerRecord* worker = workers_.by_id(id);
    if (worker) judge_failures(*worker, now);
  }
}

void WorkerService::serve(Time now) {
  for (const WorkerId id : std::exchange(freed_, {})) {
    if (WorkerRecord* worker = workers_.by_id(id)) fill(*worker, now);
  }
  if (std::exchange(some_are_pending_, false)) fill_idle(now);
}

}  // namespace tessera
