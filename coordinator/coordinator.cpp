#include "coordinator/coordinator.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/log.h"

namespace tessera {
namespace {

constexpr Time kTick = std::chrono::milliseconds(100);
constexpr int kMaxFailuresOfWorker = 3;
constexpr size_t kMaxText = 2000;

}  // namespace

Coordinator::Coordinator(CoordinatorOptions options)
    : options_(std::move(options)), workers_(options_), clients_(options_) {}

// ------------------------------------------------------------------------------------------ jobs

uint64_t Coordinator::enqueue(JobSpec spec, uint64_t submission) {
  check_job(spec);
  constexpr int kJobBits = 20;
  const uint64_t id = (options_.epoch << kJobBits) + ++jobs_queued_;
  queue_.push_back({id, submission, std::move(spec)});
  return id;
}

uint64_t Coordinator::submit(JobSpec spec, Time now) {
  const uint64_t id = enqueue(std::move(spec), 0);
  advance_jobs(now);
  return id;
}

void Coordinator::interrupt(uint64_t job, Time now) {
  const auto queued =
      std::find_if(queue_.begin(), queue_.end(), [&](const QueuedJob& q) { return q.id == job; });
  if (queued != queue_.end()) {
    ActiveJob unstarted(job, std::move(queued->spec), options_, now);
    queue_.erase(queued);
    unstarted.interrupt();
    results_.emplace(job, unstarted.finish());
  }
  if (!job_ || job_->id() != job) return;
  job_->interrupt();
  advance_jobs(now);
}

void Coordinator::fail_job(const std::string& why, Time now) {
  if (job_) job_->fail(ExitCode::render_failed, why);
  advance_jobs(now);
}

std::optional<JobResult> Coordinator::take_result(uint64_t job) {
  const auto it = results_.find(job);
  if (it == results_.end()) return std::nullopt;
  std::optional<JobResult> result = std::move(it->second);
  results_.erase(it);
  return result;
}

JobProgress Coordinator::progress(Time now) const {
  JobProgress progress;
  if (job_) progress = job_->progress(0, now);
  progress.workers = workers_.present_count();
  return progress;
}

void Coordinator::note_assembling(double seconds) {
  if (job_) job_->report().assemble_seconds += seconds;
}

void Coordinator::advance_jobs(Time now) {
  if (job_ && job_->ended()) end_job();
  if (!job_ && !queue_.empty()) {
    QueuedJob next = std::move(queue_.front());
    queue_.pop_front();
    start_job(std::move(next), now);
  }
}

void Coordinator::start_job(QueuedJob queued, Time now) {
  job_ = std::make_unique<ActiveJob>(queued.id, std::move(queued.spec), options_, now);
  submission_ = queued.submission;
  next_tick_ = now;
  for (WorkerRecord* worker : workers_.present()) {
    worker->foreign = 0;
    tell_job(*worker, now);
  }
}

void Coordinator::end_job() {
  for (const WorkerRecord* worker : workers_.present()) {
    send(worker->peer).mutable_cancel_job()->set_job(job_->id());
  }
  JobResult result = job_->finish();
  result.report.workers_seen = workers_.seen();
  result.report.workers_lost = workers_.lost();
  if (submission_ != 0) {
    clients_.ended(submission_, result);
  } else {
    results_.emplace(job_->id(), std::move(result));
  }
  job_.reset();
}

void Coordinator::attend_clients(Time now) {
  for (ClientDesk::Ready& ready : clients_.take_ready()) {
    try {
      enqueue(std::move(ready.spec), ready.submission);
    } catch (const Error& error) {
      clients_.refused(ready.submission, error);
    }
  }
  for (const uint64_t submission : clients_.take_abandoned()) {
    std::erase_if(queue_, [&](const QueuedJob& q) { return q.submission == submission; });
    if (job_ && submission_ == submission) job_->interrupt();
  }
  advance_jobs(now);
  if (job_ && submission_ != 0) clients_.running(submission_, progress(now));
  for (ClientDesk::Outgoing& out : clients_.take_outgoing()) {
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
    if (message.has_blob_chunk()) clients_.on_chunk(message.blob_chunk(), now);
    if (message.has_blob_missing()) clients_.on_missing(message.blob_missing());
    return attend_clients(now);
  }
  if (message.has_hello()) return on_hello(peer, message.hello(), now);
  if (on_client_message(peer, message, now)) return attend_clients(now);
  WorkerRecord* worker = workers_.by_peer(peer);
  if (!worker) {
    send(peer).mutable_hello_request();
    return;
  }
  on_worker_message(*worker, message, now);
  advance_jobs(now);
}

bool Coordinator::on_client_message(const PeerId& peer, const v1::Envelope& message, Time now) {
  switch (message.message_case()) {
    case v1::Envelope::kSubmitJob:
      clients_.on_submit(peer, message.submit_job(), now);
      return true;
    case v1::Envelope::kJobQuery:
      clients_.on_query(peer, message.job_query(), now);
      return true;
    case v1::Envelope::kJobRelease:
      clients_.on_release(message.job_release());
      return true;
    default:
      return false;
  }
}

void Coordinator::on_blob_request(const PeerId& peer, const v1::BlobRequest& request) {
  const auto digest = Digest::parse(request.digest());
  BlobData blob;
  if (digest && job_) blob = job_->find_blob(*digest);
  if (digest && !blob) blob = clients_.find_blob(*digest);
  v1::Envelope& answer = send(peer, Channel::bulk);
  answer = answer_blob_request(request, blob);
  if (job_) job_->report().bytes_scene += answer.blob_chunk().data().size();
}

void Coordinator::on_worker_message(WorkerRecord& worker, const v1::Envelope& message, Time now) {
  if (message.has_bye()) {
    if (message.bye().session() == worker.hello.session()) {
      lose(worker, LossCause::left, message.bye().reason().substr(0, kMaxText), now);
    }
    return;
  }
  workers_.heard(worker, now);
  if (job_) job_->scheduler().set_suspect(worker.id, false);
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
  if (greeting.anew && job_) act(job_->scheduler().leave(worker.id, LossCause::left, now), now);
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
  if (job_ && worker.ready_job != job_->id()) tell_job(worker, now);
}

void Coordinator::tell_job(WorkerRecord& worker, Time now) {
  *send(worker.peer).mutable_job_start() = job_->start_message();
  worker.told_job = now;
}

void Coordinator::on_heartbeat(WorkerRecord& worker, const v1::Heartbeat& heartbeat, Time now) {
  if (heartbeat.session() != worker.hello.session()) return;
  send(worker.peer).mutable_ping()->set_session(heartbeat.session());
  if (!job_ || heartbeat.job() != job_->id()) {
    if (heartbeat.job() != 0) send(worker.peer).mutable_cancel_job()->set_job(heartbeat.job());
    if (job_ && now - worker.told_job >= options_.heartbeat) tell_job(worker, now);
    return;
  }
  if (heartbeat.ready() && worker.ready_job != job_->id()) {
    v1::SceneReady ready;  // whose own message was lost
    ready.set_job(job_->id());
    on_ready(worker, ready, now);
  }
  std::vector<LeaseProgress> held;
  for (const auto& entry : heartbeat.progress()) {
    held.push_back({entry.lease(), entry.work_done(), entry.started()});
  }
  SchedulerEvents events;
  worker.foreign = job_->scheduler().report(worker.id, held, now, events);
  act(events, now);
  fill(worker, now);
}

void Coordinator::on_ready(WorkerRecord& worker, const v1::SceneReady& ready, Time now) {
  if (!job_ || ready.job() != job_->id()) return;
  worker.ready_job = ready.job();
  JobReport& report = job_->report();
  // Not a number fails the comparison, and is left out.
  if (ready.build_seconds() > report.build_seconds) report.build_seconds = ready.build_seconds();
  // Every worker builds the same scene: the first one speaks for all.
  if (report.build_counters.empty() && plausible_counters(ready.counters())) {
    const auto& values = ready.counters().values();
    report.build_counters.insert(values.begin(), values.end());
  }
  job_->scheduler().join(worker.id);
  fill(worker, now);
}

void Coordinator::on_band(WorkerRecord& worker, const v1::TileBand& band, Time now) {
  if (!job_ || band.job() != job_->id()) return;
  JobReport& report = job_->report();
  const BandResult result = job_->assembler().add(band, worker.id);
  if (!result.valid) {
    spdlog::warn("worker {} sent a damaged band of tile {}", worker.name(), band.tile());
    return act(job_->scheduler().fail(band.lease(), worker.id, now), now);
  }
  report.bytes_results += band.pixels().size();
  job_->note_result(now);
  if (result.duplicate_tile) ++report.duplicates;
  if (result.mismatch) {
    ++report.mismatches;
    const WorkerRecord* first = workers_.by_id(result.mismatch->first);
    spdlog::error("tile {} from row {}: workers {} and {} traced different pixels", band.tile(),
                  result.mismatch->row, first ? first->name() : "(forgotten)", worker.name());
  }
  if (result.completed_tile) {
    act(job_->scheduler().complete(band.tile(), band.lease(), now), now);
  }
  if (band.last()) fill(worker, now);
}

void Coordinator::on_tile_failed(WorkerRecord& worker, const v1::TileFailed& failed, Time now) {
  if (!job_ || failed.job() != job_->id()) return;
  const std::string text = failed.text().substr(0, kMaxText);
  spdlog::warn("worker {} failed tile {}: {}", worker.name(), failed.tile(), text);
  job_->report().failure = text;
  act(job_->scheduler().fail(failed.lease(), worker.id, now), now);
}

void Coordinator::on_scene_failed(WorkerRecord& worker, const v1::SceneFailed& failed) {
  if (!job_ || failed.job() != job_->id()) return;
  const std::string text = failed.text().substr(0, kMaxText);
  if (failed.exit_code() == static_cast<uint32_t>(ExitCode::bad_scene)) {
    return job_->fail(ExitCode::bad_scene, text);
  }
  spdlog::warn("worker {} could not build the scene: {}", worker.name(), text);
  worker.failed_job = job_->id();
  const auto present = workers_.present();
  const bool hopeless = std::all_of(present.begin(), present.end(), [&](const WorkerRecord* other) {
    return other->failed_job == job_->id() && other->ready_job != job_->id();
  });
  if (hopeless) job_->fail(ExitCode::render_failed, text);
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
  if (job_) act(job_->scheduler().leave(worker.id, cause, now), now);
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
  if (!events.cancelled.empty() || job_->scheduler().has_pending()) fill(now);
}

void Coordinator::judge_failures(WorkerRecord& worker, Time now) {
  if (++worker.failures < kMaxFailuresOfWorker || worker.state == WorkerState::lost) return;
  const auto present = workers_.present();
  const bool others = std::any_of(present.begin(), present.end(), [&](const WorkerRecord* other) {
    return other != &worker && other->failures < kMaxFailuresOfWorker;
  });
  // The last one is kept, for want of a better.
  if (!others) return;
  workers_.set_aside(worker);
  const auto reject = workers_.judge(worker.hello);
  if (reject) *send(worker.peer).mutable_reject() = *reject;
  lose(worker, LossCause::left, "it is set aside", now);
}

void Coordinator::fill(Time now) {
  for (WorkerRecord* worker : workers_.present()) fill(*worker, now);
}

void Coordinator::fill(WorkerRecord& worker, Time now) {
  if (!job_ || job_->ended() || worker.ready_job != job_->id() || worker.foreign > 0 ||
      worker.state != WorkerState::active) {
    return;
  }
  TileScheduler& scheduler = job_->scheduler();
  while (scheduler.held_by(worker.id) < worker.hello.credit()) {
    const auto lease = scheduler.assign(worker.id, now);
    if (!lease) return;
    job_->note_assignment(now);
    *send(worker.peer).mutable_assign() = job_->assignment(*lease, options_.epoch);
  }
}

void Coordinator::on_tick(Time now) {
  const auto silence = workers_.check(now);
  for (WorkerRecord* worker : silence.suspects) {
    if (job_) job_->scheduler().set_suspect(worker->id, true);
  }
  for (WorkerRecord* worker : silence.lost) {
    lose(*worker, LossCause::vanished, "no word from it for too long", now);
  }
  if (job_) {
    const SchedulerEvents events = job_->scheduler().expire(now);
    for (const WorkerId id : events.blamed) {
      const WorkerRecord* worker = workers_.by_id(id);
      if (worker && worker->hello.host() == options_.host) {
        stuck_.push_back(static_cast<pid_t>(worker->hello.process_id()));
      }
    }
    act(events, now);
    fill(now);
  }
  clients_.on_tick(now);
  attend_clients(now);
  next_tick_ = now + (job_ ? kTick : options_.heartbeat);
}

std::vector<pid_t> Coordinator::take_stuck_processes() { return std::exchange(stuck_, {}); }

void Coordinator::shut_down(const std::string& reason) {
  for (const WorkerRecord* worker : workers_.present()) {
    send(worker->peer).mutable_shutdown()->set_reason(reason);
  }
}

}  // namespace tessera
