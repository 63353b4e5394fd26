#include "coordinator/worker_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "base/log.h"
#include "base/plural.h"
#include "coordinator/tiles/identity.h"
#include "proto/wire/printable.h"

namespace tessera {

WorkerService::WorkerService(const CoordinatorOptions& options, JobTable& jobs)
    : options_(options), jobs_(jobs), workers_(options_) {}

void WorkerService::complain(WorkerRecord& worker, const std::string& what, Time now) {
  const auto times = worker.complaints.note(now);
  if (times) spdlog::warn("worker {} {}{}", worker.name(), what, *times > 1 ? ", again" : "");
}

v1::Envelope& WorkerService::send(const PeerId& peer) {
  outgoing_.push_back({peer, {}});
  return outgoing_.back().message;
}

// -------------------------------------------------------------------------------------- messages

void WorkerService::on_control(const PeerId& peer, const v1::Envelope& message, Time now,
                               const AllowedKey& sender) {
  if (message.has_hello()) return on_hello(peer, message.hello(), sender, now);
  WorkerRecord* const worker = workers_.by_peer(peer);
  if (!worker) {
    send(peer).mutable_hello_request();
    return;
  }
  // Nothing but a set-aside id or key is refused after its hello was accepted.
  if (auto reject = workers_.judge(*worker)) {
    *send(peer).mutable_reject() = std::move(*reject);
    return;
  }
  if (message.has_bye()) {
    if (message.bye().session() == worker->hello.session()) {
      lose(*worker, LossCause::left, printable(message.bye().reason()), now);
      serve(now);
      look_for_shortages();
    }
    return;
  }
  if (worker->unreachable) {
    // Its results are as good as ever.
    const v1::TileBand& band = message.tile_band();
    ActiveFrame* const job = find_frame(band.job(), band.frame_id());
    if (message.has_tile_band() && job) on_band(*worker, *job, band, now);
    return;
  }
  workers_.heard(*worker, now);
  tell_if_back(*worker);
  for (ActiveFrame* job : jobs_.running()) {
    job->scheduler().set_suspect(worker->id, false);
    job->note_worker(worker->id);
  }
  switch (message.message_case()) {
    case v1::Envelope::kHeartbeat:
      return on_heartbeat(*worker, message.heartbeat(), now);
    case v1::Envelope::kTileBand:
      if (ActiveFrame* job =
              find_frame(message.tile_band().job(), message.tile_band().frame_id())) {
        on_band(*worker, *job, message.tile_band(), now);
      }
      return;
    case v1::Envelope::kTileFailed:
      return on_tile_failed(*worker, message.tile_failed(), now);
    case v1::Envelope::kSceneReady:
      if (message.scene_ready().session() == worker->hello.session()) {
        on_ready(*worker, message.scene_ready(), now);
      }
      return;
    case v1::Envelope::kSceneFailed:
      return on_scene_failed(*worker, message.scene_failed(), now);
    default:
      return;  // not for a coordinator, or of a newer minor version
  }
}

ActiveFrame* WorkerService::find_frame(uint64_t number, const std::string& frame_id) {
  ActiveFrame* const job = jobs_.running(number);
  return job && job->frame_id() == frame_id ? job : nullptr;
}

/// A process that waits long for a core may take its own connection for lost and make another.
static spdlog::level::level_enum level_of(bool is_the_same_process) {
  return is_the_same_process ? spdlog::level::info : spdlog::level::warn;
}

void WorkerService::tell_if_back(WorkerRecord& worker) {
  if (std::exchange(worker.told_lost, false)) spdlog::info("worker {} is back", worker.name());
}

void WorkerService::tell_taken(const v1::Hello& hello, const AllowedKey& sender, Time now) {
  const auto count = taken_.note(now);
  const WorkerRecord* const owner = workers_.by_id(hello.worker_id());
  if (!count || !owner) return;
  const auto of_key = [](const AllowedKey& key) {
    return key.key.empty() ? "" : fmt::format(" of the key of {}", key.name);
  };
  WorkerRecord claimant;
  claimant.hello = hello;
  spdlog::log(level_of(claimant.name() == owner->name()),
              "refused {}{}: it says hello under the id of worker {}{}{}", claimant.name(),
              of_key(sender), owner->name(), of_key(owner->sender),
              *count > 1 ? fmt::format("; {} such hellos of late", *count) : "");
}

void WorkerService::on_hello(const PeerId& peer, const v1::Hello& hello, const AllowedKey& sender,
                             Time now) {
  auto refusal = workers_.judge(hello, sender);
  // Also where the worker of that id was forgotten: its pixels still are of its key's voter.
  const std::string& known_key = jobs_.keys().key_of(hello.worker_id());
  if (!refusal && !known_key.empty() && known_key != sender.key) refusal = id_taken(hello);
  if (auto& reject = refusal) {
    if (reject->reason() == v1::Reject::ID_TAKEN) {
      tell_taken(hello, sender, now);
    } else if (const auto count = refusals_.note(now)) {
      spdlog::warn("refused {}: {}", *count > 1 ? counted(*count, "worker") : "a worker",
                   reject->text());
    }
    *send(peer).mutable_reject() = std::move(*reject);
    return;
  }
  const auto greeting = workers_.greet(peer, hello, now, sender);
  if (greeting.older) {
    // A late one of that worker's own does not heed this, being in a later session.
    *send(peer).mutable_reject() = id_taken(hello);
    if (const WorkerRecord* own = workers_.by_peer(peer); !own || own->id != hello.worker_id()) {
      tell_taken(hello, sender, now);
    }
  }
  if (!greeting.worker) return;
  WorkerRecord& worker = *greeting.worker;
  if (!greeting.known) {
    ++counters_.workers_seen;
    spdlog::info("worker {} has come, with {}", worker.name(), counted(hello.threads(), "thread"));
  }
  if (!greeting.before.empty() && worker.returns.note(now)) {
    const bool same = greeting.before == worker.name();
    spdlog::log(level_of(same), "the id of worker {} came back by another connection{}",
                greeting.before, same ? "" : fmt::format(", as worker {}", worker.name()));
  }
  tell_if_back(worker);
  jobs_.keys().note(worker.id, sender.key, sender.name);
  v1::Welcome& welcome = *send(peer).mutable_welcome();
  welcome.set_opening(options_.opening);
  welcome.set_farm(options_.farm != 0 ? options_.farm : number_of(options_.opening));
  welcome.set_session(hello.session());
  const auto milliseconds = [](Time time) {
    return static_cast<uint32_t>(
        std::chrono::duration_cast<std::chrono::milliseconds>(time).count());
  };
  welcome.set_heartbeat_ms(milliseconds(options_.heartbeat));
  welcome.set_lost_after_ms(milliseconds(options_.lost_after));
  welcome.set_compress_pixels(options_.compress_pixels);
  welcome.set_bulk_endpoint(options_.bulk_endpoint);
  // Not before the welcome: what follows from it tells of jobs, and who is not welcomed yet does
  // not listen.
  for (ActiveFrame* job : jobs_.running()) {
    job->note_worker(worker.id);
    if (greeting.anew) apply(*job, job->scheduler().leave(worker.id, LossCause::left, now), now);
  }
  if (greeting.anew) jobs_.worker_has_come(worker.id);
  serve(now);
  fill(worker, now);
}

void WorkerService::on_heartbeat(WorkerRecord& worker, const v1::Heartbeat& heartbeat, Time now) {
  if (heartbeat.session() != worker.hello.session()) return;
  worker.resident_bytes = heartbeat.resident_bytes();
  worker.answered = now;
  v1::Ping& ping = *send(worker.peer).mutable_ping();
  ping.set_session(heartbeat.session());
  ping.set_results(heartbeat.results());
  look_at_jobs(worker, heartbeat, now);
  std::map<uint64_t, bool> same_frame;
  for (const auto& entry : heartbeat.jobs()) {
    same_frame[entry.job()] = find_frame(entry.job(), entry.frame_id()) != nullptr;
  }
  std::map<uint64_t, std::vector<LeaseProgress>> held;
  size_t of_others = 0;  // of frames that have the number of one of ours
  for (const auto& entry : heartbeat.progress()) {
    const auto known = same_frame.find(entry.job());
    if (known != same_frame.end() && !known->second) {
      ++of_others;
      continue;
    }
    held[entry.job()].push_back(
        {entry.lease(), entry.work_done(), entry.started(), entry.opening() == options_.opening});
  }
  note_work(worker, heartbeat, now);
  worker.foreign = of_others;
  worker.leaves = heartbeat.leaves();
  if (heartbeat.credit() > 0 && heartbeat.credit() < worker.hello.credit()) {
    worker.hello.set_credit(heartbeat.credit());
    spdlog::warn("worker {} is short of memory: it takes {} at one time", worker.name(),
                 counted(heartbeat.credit(), "tile"));
  }
  for (ActiveFrame* job : jobs_.running()) {
    SchedulerEvents events;
    worker.foreign +=
        job->scheduler().report(worker.id, held[job->id()], now, events, heartbeat.leaves());
    held.erase(job->id());
    for (const LeaseId lease : events.unwanted) cancel(worker, *job, lease);
    apply(*job, events, now);
  }
  // What is left is of jobs that are no more: it is cancelled, but runs as yet.
  for (const auto& [job, leases] : held) worker.foreign += leases.size();
  serve(now);
  fill(worker, now);
}

void WorkerService::look_at_jobs(WorkerRecord& worker, const v1::Heartbeat& heartbeat, Time now) {
  std::map<uint64_t, bool> has;
  for (const auto& entry : heartbeat.jobs()) {
    const ActiveFrame* const job = find_frame(entry.job(), entry.frame_id());
    if (job && !job->scene_failed_at(worker.id)) {
      has[entry.job()] = entry.ready();
      // It has it from a coordinator before us.
      if (!worker.jobs.contains(entry.job())) tell(worker, *job, now);
      continue;
    }
    send(worker.peer).mutable_cancel_job()->set_job(entry.job());
    worker.jobs.erase(entry.job());
  }
  for (auto& [id, known] : worker.jobs) {
    const auto it = has.find(id);
    const bool ready = it != has.end() && it->second;
    // It has forgotten the job, or what told it was lost; or its SceneReady was, and told the job
    // again it repeats that, with all that belongs to it.
    if (it != has.end() && ready == known.ready) continue;
    if (now - known.told < options_.heartbeat) continue;
    known.ready = false;
    if (const ActiveFrame* job = jobs_.running(id)) tell(worker, *job, now);
  }
}

void WorkerService::tell(WorkerRecord& worker, const ActiveFrame& job, Time now) {
  *send(worker.peer).mutable_job_start() = job.start_message();
  worker.jobs[job.id()].told = now;
}

void WorkerService::on_ready(WorkerRecord& worker, const v1::SceneReady& ready, Time now) {
  ActiveFrame* const job = find_frame(ready.job(), ready.frame_id());
  if (!job) return;
  auto& known = worker.jobs[ready.job()];
  if (!known.ready) {
    job->note_span(FrameTrace::Kind::scene, worker.id, worker.name(), 0, known.told, now);
  }
  known.ready = true;
  job->note_built();
  job->assembler().note_build_counters(ready.counters());
  // Not a number fails the comparison, and is left out.
  double& longest = job->report().build_seconds;
  if (ready.build_seconds() > longest) longest = ready.build_seconds();
  job->scheduler().join(worker.id, worker.hello.threads());
  if (ready.has_unseen()) on_unseen(worker, *job, ready.unseen(), now);
  fill(worker, now);
}

void WorkerService::on_band(WorkerRecord& worker, ActiveFrame& job, const v1::TileBand& band,
                            Time now) {
  TileScheduler& scheduler = job.scheduler();
  const uint32_t tile = TileScheduler::tile_of(band.lease());
  if (!scheduler.accepts(band.lease(), band.opening() == options_.opening, worker.id)) {
    complain(worker, "sent pixels under a lease that it was not given", now);
    return;
  }
  // What else it, or another of its key, sent of that tile before it heard of the dispute.
  if (tile < job.assembler().tiles().size() && scheduler.is_party(tile, worker.id)) return;
  const bool was_complete = tile < job.assembler().tiles().size() && job.assembler().complete(tile);
  BandResult result = job.assembler().add(band, worker.id);
  if (!result.valid) {
    complain(worker, fmt::format("sent a damaged band of tile {}", tile), now);
    return act(job, scheduler.fail(band.lease(), worker.id, now), now);
  }
  worker.got_on = now;
  if (now - worker.answered >= options_.heartbeat) {
    // Its heartbeats may stand behind much that it sends.
    worker.answered = now;
    send(worker.peer).mutable_ping()->set_session(worker.hello.session());
  }
  job.report().bytes_results += band.pixels().size();
  counters_.bytes_results += band.pixels().size();
  worker.bytes_results += band.pixels().size();
  for (const auto& [name, count] : band.counters().values()) {
    if (name.starts_with("rays_")) counters_.rays += count;
  }
  job.note_result(now);
  if (result.duplicate_tile) ++job.report().duplicates;
  if (result.duplicate_tile) ++counters_.duplicates;
  if (result.mismatch) return on_mismatch(job, std::move(*result.mismatch), now);
  const SchedulerEvents events = job.note_band(band, worker.id, was_complete);
  if (result.completed_tile) {
    // Before anybody is given what may be this very tile.
    on_completed(worker, job, band.lease(), now);
  } else {
    act(job, events, now);
  }
  if (!band.last()) return;
  fill(worker, now);
  // It may have split what another had.
  if (job.scheduler().has_pending()) fill_idle(now);
}

void WorkerService::on_completed(WorkerRecord& worker, ActiveFrame& job, LeaseId lease, Time now) {
  const uint32_t tile = TileScheduler::tile_of(lease);
  const auto completion = job.complete(tile, lease, worker.id, now);
  const double seconds = to_seconds(completion.events.took.value_or(Time{}));
  job.note_tile_seconds(tile, seconds);
  const bool is_named = job.trace().workers.contains(worker.id);
  job.note_span(FrameTrace::Kind::tile, worker.id, is_named ? "" : worker.name(), tile,
                now - completion.events.took.value_or(Time{}), now);
  counters_.note_tile(seconds);
  frames_begun_ += job.assembler().tiles_done() == 1;
  ++worker.tiles_done;
  worker.tile_seconds += seconds;
  act(job, completion.events, now);
  for (const Conviction& conviction : completion.convictions) convict(job, conviction, now);
  if (const auto& about = completion.undecided) {
    job.fail(ExitCode::render_failed,
             fmt::format("tile {}: workers {}, {} and {} traced three different pictures; expected "
                         "the same bits",
                         tile, name_of(about->first), name_of(about->second), worker.name()));
  }
}

void WorkerService::on_tile_failed(WorkerRecord& worker, const v1::TileFailed& failed, Time now) {
  ActiveFrame* const job = find_frame(failed.job(), failed.frame_id());
  if (!job) return;
  const SchedulerEvents events = job->scheduler().fail(failed.lease(), worker.id, now);
  // Of a lease that it does not hold it has nothing to tell.
  if (events.blamed.empty()) return;
  const std::string text = printable(failed.text());
  spdlog::warn("worker {} failed tile {}: {}", worker.name(),
               TileScheduler::tile_of(failed.lease()), text);
  job->report().failure = text;
  act(*job, events, now);
}

void WorkerService::on_scene_failed(WorkerRecord& worker, const v1::SceneFailed& failed, Time now) {
  // It need not keep what it has of the scene; that it is told so again does no harm.
  v1::CancelJob& cancel = *send(worker.peer).mutable_cancel_job();
  cancel.set_job(failed.job());
  ActiveFrame* const job = find_frame(failed.job(), failed.frame_id());
  if (!job) return;
  worker.jobs.erase(failed.job());
  const std::string text = printable(failed.text());
  if (!job->scene_failed_at(worker.id)) {
    spdlog::info("worker {} could not build the scene: {}", worker.name(), text);
  }
  job->note_scene_failure(worker.id, {failed.cause(), text});
  look_for_shortages();
  fill(worker, now);
}

void WorkerService::look_for_shortages() {
  std::vector<WorkerId> present;
  for (ActiveFrame* job : jobs_.running()) {
    if (!job->has_scene_failures()) continue;
    if (present.empty()) {
      for (const WorkerRecord* worker : workers_.present()) present.push_back(worker->id);
    }
    job->look_for_shortage(present);
  }
}

// --------------------------------------------------------------------------------------- workers

void WorkerService::on_peer_gone(const PeerId& peer, Time now, bool welcomed) {
  WorkerRecord* worker = workers_.by_peer(peer);
  if (!worker || worker->peer != peer) return;
  worker->unreachable = true;
  // Who was told to end, or is told by it too late, leaves as it should.
  const bool leaves = dismissed_ || !welcomed;
  lose(*worker, leaves ? LossCause::left : LossCause::vanished, "its connection is gone", now);
  serve(now);
  look_for_shortages();
}

void WorkerService::on_process_ended(pid_t process, bool crashed, const std::string& how,
                                     Time now) {
  WorkerRecord* worker = workers_.by_process(process);
  if (!worker) return;
  for (ActiveFrame* job : jobs_.running()) {
    const auto known = worker->jobs.find(job->id());
    const bool builds = known != worker->jobs.end() && !known->second.ready;
    // Tiles that it held may have been the cause as well.
    if (!crashed || !builds || held_by(*worker) > 0) continue;
    job->note_scene_failure(
        worker->id, {v1::SceneFailed::CRASHED,
                     fmt::format("building the scene ended the worker's process: {}", how)});
  }
  // Another process takes its place at once: that is waited for.
  lose(*worker, crashed ? LossCause::crashed : LossCause::vanished, how, now);
  serve(now);
}

void WorkerService::lose(WorkerRecord& worker, LossCause cause, const std::string& how, Time now) {
  if (worker.state == WorkerState::lost) return;
  if (cause != LossCause::left) {
    // One that is stopped and woken again and again is told of once in a while.
    const auto times = worker.losses.note(now);
    worker.told_lost |= times.has_value();
    if (times == 1) spdlog::warn("lost worker {}: {}", worker.name(), how);
    if (times > 1) spdlog::warn("lost worker {}: {}; {} times of late", worker.name(), how, *times);
  }
  const auto told = worker.jobs;
  workers_.lose(worker);
  if (cause != LossCause::left) ++counters_.workers_lost;
  for (ActiveFrame* job : jobs_.running()) {
    if (cause != LossCause::left) {
      job->note_lost_worker();
      const auto known = told.find(job->id());
      const bool builds = known != told.end() && !known->second.ready;
      if (builds) job->note_lost_builder(worker.id, known->second.told, now);
    }
    for (const Lease& lease : job->scheduler().leases_of(worker.id)) {
      job->note_span(FrameTrace::Kind::lost, worker.id, worker.name(), lease.tile, lease.issued,
                     now);
    }
    apply(*job, job->scheduler().leave(worker.id, cause, now), now);
  }
}

void WorkerService::forgive(Time silence, Time now) {
  workers_.forgive(silence, now);
  for (ActiveFrame* job : jobs_.running()) job->scheduler().forgive(silence, now);
}

void WorkerService::on_tick(Time now) {
  const auto silence = workers_.check(now);
  for (WorkerRecord* worker : silence.suspects) {
    for (ActiveFrame* job : jobs_.running()) job->scheduler().set_suspect(worker->id, true);
  }
  for (WorkerRecord* worker : silence.lost) {
    // A process of ours that is stopped would never come back by itself.
    note_stuck(*worker);
    lose(*worker, LossCause::vanished, "no word from it for too long", now);
  }
  look_for_shortages();
  for (ActiveFrame* job : jobs_.running()) {
    const SchedulerEvents events = job->scheduler().expire(now);
    for (const WorkerId id : events.blamed) {
      if (const WorkerRecord* worker = workers_.by_id(id)) note_stuck(*worker);
    }
    apply(*job, events, now);
    note_stalls(*job, events.stalled, now);
    fail_undecided(*job, now);
    put_barred_aside(*job);
    abandon_checks(*job, now);
  }
  serve(now);
  fill(now);
}

void WorkerService::note_stuck(const WorkerRecord& worker) {
  if (worker.hello.host() != options_.host) return;
  stuck_.push_back(static_cast<pid_t>(worker.hello.process_id()));
}

std::vector<pid_t> WorkerService::take_stuck_processes() { return std::exchange(stuck_, {}); }

void WorkerService::describe(FarmSnapshot& snapshot, Time now) const {
  snapshot.counters = counters_;
  for (const auto& [id, worker] : workers_.all()) {
    FarmSnapshot::Worker& shown = snapshot.workers.emplace_back();
    shown.id = id;
    shown.name = worker.name();
    shown.state = worker.state == WorkerState::active    ? FarmSnapshot::WorkerState::active
                  : worker.state == WorkerState::suspect ? FarmSnapshot::WorkerState::suspect
                                                         : FarmSnapshot::WorkerState::lost;
    shown.threads = worker.hello.threads();
    shown.credit = worker.hello.credit();
    shown.tiles_held = held_by(worker);
    shown.scenes = worker.jobs.size();
    shown.tiles_done = worker.tiles_done;
    shown.tile_seconds = worker.tile_seconds;
    shown.bytes_results = worker.bytes_results;
    shown.resident_bytes = worker.resident_bytes;
    shown.failures = worker.failures;
    shown.silent_seconds = to_seconds(now - worker.last_heard);
    shown.connected_seconds = to_seconds(now - worker.came);
  }
}

void WorkerService::shut_down(const std::string& reason) {
  dismissed_ = true;
  for (const WorkerRecord* worker : workers_.present()) {
    send(worker->peer).mutable_shutdown()->set_reason(reason);
  }
}

}  // namespace tessera
