#include "coordinator/coordinator.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/log.h"
#include "base/plural.h"
#include "proto/wire/blob_transfer.h"
#include "proto/wire/printable.h"

namespace tessera {
namespace {

constexpr Time kTick = std::chrono::milliseconds(100);
constexpr int kMaxFailuresOfWorker = 3;

}  // namespace

Coordinator::Coordinator(CoordinatorOptions options)
    : options_(std::move(options)), workers_(options_), jobs_(options_) {}

// ------------------------------------------------------------------------------------------ jobs

uint64_t Coordinator::submit(JobSpec spec, Time now) {
  const uint64_t id = jobs_.submit(std::move(spec));
  advance_jobs(now);
  return id;
}

void Coordinator::interrupt(uint64_t job, Time now) {
  jobs_.interrupt(job, now);
  advance_jobs(now);
}

void Coordinator::fail_job(const std::string& why, Time now) {
  if (job()) job()->fail(ExitCode::render_failed, why);
  advance_jobs(now);
}

std::optional<JobResult> Coordinator::take_result(uint64_t job) { return jobs_.take_result(job); }

JobProgress Coordinator::progress(Time now) const {
  JobProgress progress;
  if (job()) progress = job()->progress(now);
  progress.workers = workers_.present_count();
  if (job() && progress.workers == 0) progress.waiting_for = "workers";
  return progress;
}

void Coordinator::note_assembling(Time spent) {
  if (job()) job()->report().assemble_seconds += to_seconds(spent);
}

void Coordinator::advance_jobs(Time now) {
  if (job() && job()->ended()) {
    for (const WorkerRecord* worker : workers_.present()) {
      send(worker->peer).mutable_cancel_job()->set_job(job()->id());
    }
    jobs_.end_active(workers_.seen(), workers_.lost());
  }
  if (!jobs_.start_next(now)) return;
  workers_.start_counting();
  next_tick_ = now;
  for (WorkerRecord* worker : workers_.present()) {
    worker->foreign = 0;
    tell_job(*worker, now);
  }
}

void Coordinator::attend_clients(Time now) {
  jobs_.attend_clients();
  advance_jobs(now);
  jobs_.tell_client(progress(now));
  forward_to_clients();
}

void Coordinator::forward_to_clients() {
  for (ClientDesk::Outgoing& out : jobs_.clients().take_outgoing()) {
    outgoing_.push_back({Channel::control, std::move(out.peer), std::move(out.message)});
  }
}

// -------------------------------------------------------------------------------------- messages

v1::Envelope& Coordinator::send(const PeerId& peer, Channel channel) {
  outgoing_.push_back({channel, peer, {}});
  return outgoing_.back().message;
}

std::vector<OutgoingMessage> Coordinator::take_outgoing() { return std::exchange(outgoing_, {}); }

void Coordinator::on_message(Channel channel, const PeerId& peer, const v1::Envelope& message,
                             Time now) {
  if (channel == Channel::bulk) {
    if (message.has_blob_request()) on_blob_request(peer, message.blob_request());
    if (message.has_blob_chunk()) jobs_.clients().on_chunk(message.blob_chunk(), now);
    if (message.has_blob_missing()) jobs_.clients().on_missing(message.blob_missing());
    return attend_clients(now);
  }
  if (message.has_hello()) return on_hello(peer, message.hello(), now);
  if (jobs_.clients().on_control(peer, message, now)) return attend_clients(now);
  WorkerRecord* worker = workers_.by_peer(peer);
  if (!worker) {
    send(peer).mutable_hello_request();
    return;
  }
  // Nothing but a set-aside id is refused after its hello was accepted.
  if (auto reject = workers_.judge(worker->hello)) {
    *send(peer).mutable_reject() = std::move(*reject);
    return;
  }
  on_worker_message(*worker, message, now);
  advance_jobs(now);
}

void Coordinator::on_blob_request(const PeerId& peer, const v1::BlobRequest& request) {
  const auto digest = Digest::parse(request.digest());
  const auto blob = digest ? jobs_.find_blob(*digest) : JobQueue::FoundBlob{};
  v1::Envelope& answer = send(peer, Channel::bulk);
  if (request.place() && options_.shared_by_process != 0 && blob.data &&
      blob.data->descriptor() >= 0) {
    v1::BlobPlace& place = *answer.mutable_blob_place();
    place.set_digest(request.digest());
    place.set_process_id(options_.shared_by_process);
    place.set_file(static_cast<uint32_t>(blob.data->descriptor()));
    return;
  }
  answer = answer_blob_request(request, blob.data);
  // Films that clients fetch are no part of what the job costs.
  if (blob.of_active) job()->report().bytes_scene += answer.blob_chunk().data().size();
}

void Coordinator::on_worker_message(WorkerRecord& worker, const v1::Envelope& message, Time now) {
  if (message.has_bye()) {
    if (message.bye().session() == worker.hello.session()) {
      lose(worker, LossCause::left, printable(message.bye().reason()), now);
    }
    return;
  }
  workers_.heard(worker, now);
  if (job()) job()->scheduler().set_suspect(worker.id, false);
  switch (message.message_case()) {
    case v1::Envelope::kHeartbeat:
      return on_heartbeat(worker, message.heartbeat(), now);
    case v1::Envelope::kTileBand:
      return on_band(worker, message.tile_band(), now);
    case v1::Envelope::kTileFailed:
      return on_tile_failed(worker, message.tile_failed(), now);
    case v1::Envelope::kSceneReady:
      if (message.scene_ready().session() == worker.hello.session()) {
        on_ready(worker, message.scene_ready(), now);
      }
      return;
    case v1::Envelope::kSceneFailed:
      return on_scene_failed(worker, message.scene_failed());
    default:
      return;  // not for a coordinator, or of a newer minor version
  }
}

void Coordinator::on_hello(const PeerId& peer, const v1::Hello& hello, Time now) {
  if (auto reject = workers_.judge(hello)) {
    spdlog::warn("refused a worker: {}", reject->text());
    *send(peer).mutable_reject() = std::move(*reject);
    return;
  }
  const auto greeting = workers_.greet(peer, hello, now);
  if (!greeting.worker) return;
  WorkerRecord& worker = *greeting.worker;
  if (greeting.anew && hello.session() == 1) {
    spdlog::info("worker {} has come, with {}", worker.name(), counted(hello.threads(), "thread"));
  }
  if (greeting.anew && job()) act(job()->scheduler().leave(worker.id, LossCause::left, now), now);
  v1::Welcome& welcome = *send(peer).mutable_welcome();
  welcome.set_epoch(options_.epoch);
  welcome.set_session(hello.session());
  const auto milliseconds = [](Time time) {
    return static_cast<uint32_t>(
        std::chrono::duration_cast<std::chrono::milliseconds>(time).count());
  };
  welcome.set_heartbeat_ms(milliseconds(options_.heartbeat));
  welcome.set_lost_after_ms(milliseconds(options_.lost_after));
  welcome.set_compress_pixels(options_.compress_pixels);
  welcome.set_bulk_endpoint(options_.bulk_endpoint);
  if (job() && worker.ready_job != job()->id()) tell_job(worker, now);
}

void Coordinator::tell_job(WorkerRecord& worker, Time now) {
  *send(worker.peer).mutable_job_start() = job()->start_message();
  worker.told_job = now;
}

void Coordinator::on_heartbeat(WorkerRecord& worker, const v1::Heartbeat& heartbeat, Time now) {
  if (heartbeat.session() != worker.hello.session()) return;
  send(worker.peer).mutable_ping()->set_session(heartbeat.session());
  if (!job() || heartbeat.job() != job()->id()) {
    if (heartbeat.job() != 0) send(worker.peer).mutable_cancel_job()->set_job(heartbeat.job());
    if (job() && now - worker.told_job >= options_.heartbeat) tell_job(worker, now);
    return;
  }
  // Its SceneReady was lost. Told the job again, it repeats it, with all that belongs to it.
  const bool unheard = heartbeat.ready() && worker.ready_job != job()->id();
  if (unheard && now - worker.told_job >= options_.heartbeat) tell_job(worker, now);
  std::vector<LeaseProgress> held;
  for (const auto& entry : heartbeat.progress()) {
    held.push_back({entry.lease(), entry.work_done(), entry.started()});
  }
  SchedulerEvents events;
  worker.foreign = job()->scheduler().report(worker.id, held, now, events);
  act(events, now);
  fill(worker, now);
}

void Coordinator::on_ready(WorkerRecord& worker, const v1::SceneReady& ready, Time now) {
  if (!job() || ready.job() != job()->id()) return;
  worker.ready_job = ready.job();
  job()->assembler().note_build_counters(ready.counters());
  // Not a number fails the comparison, and is left out.
  double& longest = job()->report().build_seconds;
  if (ready.build_seconds() > longest) longest = ready.build_seconds();
  job()->scheduler().join(worker.id);
  fill(worker, now);
}

void Coordinator::on_band(WorkerRecord& worker, const v1::TileBand& band, Time now) {
  if (!job() || band.job() != job()->id()) return;
  TileScheduler& scheduler = job()->scheduler();
  const uint32_t tile = TileScheduler::tile_of(band.lease());
  if (!scheduler.issued(band.lease(), worker.id)) {
    spdlog::warn("worker {} sent pixels under a lease that it was not given", worker.name());
    return;
  }
  // What else it sent of that tile before it heard of it.
  const auto& disputed = scheduler.disputed_by(tile);
  if (std::find(disputed.begin(), disputed.end(), worker.id) != disputed.end()) return;
  const bool was_complete =
      tile < job()->assembler().tiles().size() && job()->assembler().complete(tile);
  BandResult result = job()->assembler().add(band, worker.id);
  if (!result.valid) {
    spdlog::warn("worker {} sent a damaged band of tile {}", worker.name(), tile);
    return act(scheduler.fail(band.lease(), worker.id, now), now);
  }
  job()->report().bytes_results += band.pixels().size();
  job()->note_result(now);
  if (result.duplicate_tile) ++job()->report().duplicates;
  if (result.mismatch) return on_mismatch(std::move(*result.mismatch), now);
  act(job()->note_band(band, worker.id, was_complete), now);
  if (result.completed_tile) complete(tile, band.lease(), worker.id, now);
  if (band.last()) fill(worker, now);
}

std::string Coordinator::name_of(WorkerId id) {
  if (id == kFromStore) return "(of before, from the store)";
  const WorkerRecord* worker = workers_.by_id(id);
  return worker ? worker->name() : "(forgotten)";
}

void Coordinator::complete(uint32_t tile, LeaseId lease, WorkerId from, Time now) {
  const auto completion = job()->complete(tile, lease, from, now);
  act(completion.events, now);
  if (completion.conviction) convict(*completion.conviction, now);
}

void Coordinator::convict(const Conviction& conviction, Time now) {
  const Mismatch& about = conviction.dispute;
  const WorkerId right = about.first == conviction.wrong ? about.second : about.first;
  const SchedulerEvents events = job()->redo_tiles_of(conviction.wrong);
  const std::string what = fmt::format(
      "worker {} traced wrong pixels in row {} of tile {}, as workers {} and {} agree",
      name_of(conviction.wrong), about.row, about.tile, name_of(right), name_of(conviction.judge));
  spdlog::error("{}; it is set aside, and all its tiles are traced again", what);
  ++job()->report().liars;
  set_aside(conviction.wrong, what, now);
  act(events, now);
}

void Coordinator::on_mismatch(Mismatch mismatch, Time now) {
  ++job()->report().mismatches;
  const bool again = !job()->scheduler().disputed_by(mismatch.tile).empty();
  const std::string what = fmt::format(
      "tile {} from row {}: workers {} and {} traced different "
      "pixels; expected the same bits",
      mismatch.tile, mismatch.row, name_of(mismatch.first), name_of(mismatch.second));
  spdlog::error("{}", what);
  const auto events = job()->dispute(std::move(mismatch), now);
  if (again) return job()->fail(ExitCode::render_failed, what);
  act(events, now);
}

void Coordinator::fail_undecided(Time now) {
  const auto tile = job()->scheduler().undecided(now);
  if (!tile) return;
  const auto& by = job()->scheduler().disputed_by(*tile);
  job()->fail(ExitCode::render_failed,
              fmt::format("tile {}: workers {} and {} traced different pixels, and there is no "
                          "third to decide",
                          *tile, name_of(by[0]), name_of(by[1])));
}

void Coordinator::on_tile_failed(WorkerRecord& worker, const v1::TileFailed& failed, Time now) {
  if (!job() || failed.job() != job()->id()) return;
  const std::string text = printable(failed.text());
  spdlog::warn("worker {} failed tile {}: {}", worker.name(), failed.tile(), text);
  job()->report().failure = text;
  act(job()->scheduler().fail(failed.lease(), worker.id, now), now);
}

void Coordinator::on_scene_failed(WorkerRecord& worker, const v1::SceneFailed& failed) {
  if (!job() || failed.job() != job()->id()) return;
  const std::string text = printable(failed.text());
  if (!job()->scene_failed_at(worker.id)) {
    spdlog::info("worker {} could not build the scene: {}", worker.name(), text);
  }
  std::vector<WorkerId> present;
  for (const WorkerRecord* other : workers_.present()) present.push_back(other->id);
  const bool bad = failed.exit_code() == static_cast<uint32_t>(ExitCode::bad_scene);
  job()->note_scene_failure(worker.id, bad ? ExitCode::bad_scene : ExitCode::render_failed, text,
                            present);
}

// --------------------------------------------------------------------------------------- workers

void Coordinator::on_peer_gone(const PeerId& peer, Time now) {
  WorkerRecord* worker = workers_.by_peer(peer);
  if (!worker || worker->peer != peer) return;
  lose(*worker, LossCause::vanished, "its connection is gone", now);
  advance_jobs(now);
}

void Coordinator::on_process_ended(pid_t process, bool crashed, const std::string& how, Time now) {
  WorkerRecord* worker = workers_.by_process(process);
  if (!worker) return;
  lose(*worker, crashed ? LossCause::crashed : LossCause::vanished, how, now);
  advance_jobs(now);
}

void Coordinator::lose(WorkerRecord& worker, LossCause cause, const std::string& how, Time now) {
  if (worker.state == WorkerState::lost) return;
  if (cause != LossCause::left) spdlog::warn("lost worker {}: {}", worker.name(), how);
  workers_.lose(worker);
  if (job()) act(job()->scheduler().leave(worker.id, cause, now), now);
}

void Coordinator::act(const SchedulerEvents& events, Time now) {
  for (const Lease& lease : events.cancelled) {
    const WorkerRecord* worker = workers_.by_id(lease.worker);
    if (worker) send(worker->peer).mutable_cancel_tile()->set_lease(lease.id);
  }
  for (const uint32_t tile : events.given_up) {
    spdlog::error("tile {} is given up: it failed too often", tile);
  }
  for (const WorkerId id : events.blamed) {
    WorkerRecord* worker = workers_.by_id(id);
    if (worker) judge_failures(*worker, now);
  }
  if (!events.cancelled.empty() || job()->scheduler().has_pending()) fill(now);
}

void Coordinator::set_aside(WorkerId id, const std::string& cause, Time now) {
  if (id == kFromStore) return;
  workers_.set_aside(id, cause);
  WorkerRecord* const worker = workers_.by_id(id);
  if (!worker) return;
  if (const auto reject = workers_.judge(worker->hello))
    *send(worker->peer).mutable_reject() = *reject;
  lose(*worker, LossCause::left, "it is set aside", now);
}

void Coordinator::judge_failures(WorkerRecord& worker, Time now) {
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

void Coordinator::fill(Time now) {
  for (WorkerRecord* worker : workers_.present()) fill(*worker, now);
}

void Coordinator::fill(WorkerRecord& worker, Time now) {
  if (!job() || job()->ended() || worker.ready_job != job()->id() || worker.foreign > 0 ||
      worker.state != WorkerState::active) {
    return;
  }
  TileScheduler& scheduler = job()->scheduler();
  while (scheduler.held_by(worker.id) < worker.hello.credit()) {
    const auto lease = scheduler.assign(worker.id, now);
    if (!lease) return;
    job()->note_assignment(now);
    *send(worker.peer).mutable_assign() = job()->assignment(*lease);
  }
}

void Coordinator::on_tick(Time now) {
  const auto silence = workers_.check(now);
  for (WorkerRecord* worker : silence.suspects) {
    if (job()) job()->scheduler().set_suspect(worker->id, true);
  }
  for (WorkerRecord* worker : silence.lost) {
    // A process of ours that is stopped would never come back by itself.
    note_stuck(*worker);
    lose(*worker, LossCause::vanished, "no word from it for too long", now);
  }
  if (job()) {
    const SchedulerEvents events = job()->scheduler().expire(now);
    for (const WorkerId id : events.blamed) {
      if (const WorkerRecord* worker = workers_.by_id(id)) note_stuck(*worker);
    }
    act(events, now);
    fill(now);
    fail_undecided(now);
    if (const size_t count = job()->scheduler().abandon_checks(now)) {
      spdlog::warn("{} could not be verified: there is no second worker", counted(count, "tile"));
    }
  }
  jobs_.clients().on_tick(now);
  attend_clients(now);
  next_tick_ = now + (job() ? kTick : options_.heartbeat);
}

void Coordinator::note_stuck(const WorkerRecord& worker) {
  if (worker.hello.host() != options_.host) return;
  stuck_.push_back(static_cast<pid_t>(worker.hello.process_id()));
}

std::vector<pid_t> Coordinator::take_stuck_processes() { return std::exchange(stuck_, {}); }

void Coordinator::shut_down(const std::string& reason) {
  for (const WorkerRecord* worker : workers_.present()) {
    send(worker->peer).mutable_shutdown()->set_reason(reason);
  }
  jobs_.clients().close(reason);
  forward_to_clients();
}

}  // namespace tessera
