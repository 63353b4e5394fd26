// The workers of a simulation: what they do, and what happens to them.
#include <fmt/format.h>

#include <utility>
#include <variant>

#include "proto/wire/pixels.h"
#include "tests/farm/simulation.h"
#include "worker/run_worker.h"

namespace tessera::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr size_t kMostWorkers = 6;

}  // namespace

Simulation::Worker* Simulation::find_process(uint32_t process) {
  const auto it = workers_.find(process);
  return it == workers_.end() ? nullptr : &it->second;
}

Simulation::Worker* Simulation::find(const PeerId& peer) {
  for (auto& [process, worker] : workers_) {
    if (worker.peer == peer) return &worker;
  }
  return nullptr;
}

void Simulation::join() {
  Worker& worker = workers_[++processes_];
  worker.process = processes_;
  worker.peer = fmt::format("peer-{}", ++peers_);
  worker.failures_left = faults_.one_fails && processes_ == 1 ? 2 : 0;
  worker.hangs = faults_.one_hangs && processes_ == 2;
  worker.starves = faults_.one_starves && processes_ == 1;
  worker.lies = faults_.one_lies && processes_ == 3;
  if (faults_.keys > 0) {
    const std::string name = fmt::format("key-{}", processes_ % faults_.keys);
    worker.key = {Role::worker, name, "public " + name};
    worker.lies |= faults_.key_lies && processes_ % faults_.keys == 0;
  }
  worker.slowness = draw() < 0.2 ? 10 : 0.5 + draw();
  SessionOptions options;
  v1::Hello& hello = options.hello;
  hello.set_protocol_major(kProtocolMajor);
  hello.set_numerics_id(kNumericsId);
  hello.set_worker_id(random_() >> 1 | 1);
  if (const auto folder = spool_folder(); !folder.empty()) {
    worker.spool = std::make_unique<ResultSpool>(folder, uint64_t{1} << 30, kNumericsId);
    if (const auto& before = worker.spool->origin()) {
      hello.set_worker_id(before->worker_id);
      hello.set_session(before->session);
    }
  }
  hello.set_host(draw() < 0.5 ? kHost : "elsewhere");
  hello.set_process_id(worker.process);
  hello.set_threads(1 + static_cast<uint32_t>(draw(3)));
  hello.set_credit(hello.threads() + 1);
  options.orphan_timeout = faults_.orphan_timeout;
  options.result_bytes = faults_.result_bytes;
  worker.session = std::make_unique<WorkerSession>(options, now_);
  say(fmt::format("worker {} joins", worker.process));
  perform(worker);
}

void Simulation::crash(uint32_t process, bool noticed, bool own_fault) {
  const Worker* worker = find_process(process);
  if (!worker) return;
  say(fmt::format("worker {} dies{}", process, noticed ? ", noticed" : ""));
  const PeerId peer = worker->peer;
  workers_.erase(process);
  if (!noticed) return;
  const Time noticed_at = std::max(now_, coordinator_stopped_until_) + draw_time(milliseconds(50));
  at(noticed_at, [this, peer, process, own_fault] {
    with_coordinator([&](Coordinator& c) {
      c.on_process_ended(static_cast<pid_t>(process), own_fault, "simulated", now_);
      c.on_peer_gone(peer, now_);
    });
    deliver();
  });
}

void Simulation::something_happens() {
  if (workers_.empty()) return join();
  auto it = workers_.begin();
  std::advance(it, static_cast<ptrdiff_t>(draw(workers_.size())));
  Worker& worker = it->second;
  constexpr uint64_t kCutOff = 4;
  switch (faults_.orphan_timeout != Time::max() && draw() < 0.5 ? kCutOff : draw(6)) {
    case 0:
      return crash(worker.process, draw() < 0.5, false);
    case 1:
      if (draw() < 0.5) {
        say(fmt::format("worker {} drains", worker.process));
        worker.session->drain(now_);
        worker.drains = true;
        at(now_ + WorkerOptions().drain, [this, process = worker.process] { end_drain(process); });
        return perform(worker);
      }
      say(fmt::format("worker {} leaves", worker.process));
      worker.session->leave("simulated");
      perform(worker);
      workers_.erase(it);
      return;
    case 2:
      if (workers_.size() < kMostWorkers) join();
      return;
    case 3:
      worker.frozen_from = now_;
      worker.frozen_until = now_ + (draw() < 0.3 ? Time(seconds(10000)) : draw_time(seconds(15)));
      return say(fmt::format("worker {} is stopped", worker.process));
    case kCutOff:
      worker.cut_until = now_ + draw_time(seconds(15));
      worker.cut_to = draw() < 0.7;
      worker.cut_from = !worker.cut_to || draw() < 0.5;
      return say(fmt::format("worker {} is cut off", worker.process));
    default:
      worker.slowness *= 10;
      return say(fmt::format("worker {} slows down", worker.process));
  }
}

double Simulation::seconds_of(const TraceRun& run) const {
  const double whole = pace_ * (0.02 + 0.3 * static_cast<double>(run.tile * 37 % 11) / 11);
  return whole / TilePiece::of(run.lease).parts;
}

void Simulation::start_tracing(Worker& worker) {
  const uint32_t process = worker.process;
  while (worker.tracing.size() < 2 && !worker.queue.empty()) {
    auto run = std::move(worker.queue.front());
    worker.queue.pop_front();
    run->started = !run->progress.cancelled;
    worker.tracing[run.get()] = {run, now_};
    const double tile_seconds = seconds_of(*run);
    if (worker.hangs && run->started) {
      worker.hangs = false;
      say(fmt::format("worker {} hangs in tile {}", process, run->tile));
      continue;
    }
    // What is cancelled in the queue takes no time.
    const double spent = run->started ? tile_seconds * worker.slowness : 0;
    const Time end = now_ + Time(static_cast<int64_t>(spent * 1e9));
    at(end, [this, process, run] { finish_tracing(process, run); });
  }
}

void Simulation::finish_tracing(uint32_t process, const std::shared_ptr<TraceRun>& run) {
  Worker* worker = find_process(process);
  if (!worker) return;
  if (now_ < worker->frozen_until) {
    at(worker->frozen_until, [this, process, run] { finish_tracing(process, run); });
    return;
  }
  worker->tracing.erase(run.get());
  worker->session->on_traced(outcome_of(*worker, run), now_);
  start_tracing(*worker);
  perform(*worker);
}

TraceOutcome Simulation::outcome_of(Worker& worker, const std::shared_ptr<TraceRun>& run) {
  TraceOutcome outcome = tessera::trace(run);
  if (outcome.cancelled) return outcome;
  if (worker.starves && worker.queue.size() + worker.tracing.size() > 0) {
    outcome.bands.clear();
    outcome.out_of_memory = true;
    outcome.failure = "simulated";
    return outcome;
  }
  const auto microseconds = static_cast<uint64_t>(seconds_of(*run) * worker.slowness * 1e6);
  if (!outcome.bands.empty()) outcome.bands.back().set_trace_microseconds(microseconds);
  if (worker.failures_left > 0) {
    --worker.failures_left;
    outcome.bands.clear();
    outcome.failure = "simulated";
    return outcome;
  }
  if (!faults_.split_bands && !worker.lies) return outcome;
  const PixelRect& rect = run->task.rect;
  TileProgress progress;
  auto values = run->renderer->render(run->task, progress)->values;
  if (worker.lies) values[values.size() / 2] += 1;
  auto counters = outcome.bands.back().counters();
  outcome.bands.clear();
  const size_t row = static_cast<size_t>(rect.width()) * kFilmChannels;
  for (int y = rect.y0; y < rect.y1; ++y) {
    const auto offset = row * static_cast<size_t>(y - rect.y0);
    auto bands =
        encode_bands(std::span(values).subspan(offset, row), rect.width(), y, run->compress);
    outcome.bands.push_back(std::move(bands[0]));
    outcome.bands.back().set_last(false);
  }
  outcome.bands.back().set_last(true);
  *outcome.bands.back().mutable_counters() = std::move(counters);
  outcome.bands.back().set_trace_microseconds(microseconds);
  return outcome;
}

void Simulation::hand_in(Worker& worker) {
  const bool welcome = worker.session->is_welcome();
  if (welcome == std::exchange(worker.was_welcome, welcome) || !welcome || !worker.spool) return;
  handed_in_ += hand_in_spooled(*worker.session, *worker.spool);
}

void Simulation::leave_results(Worker& worker) {
  if (!worker.spool) return;
  const SpooledResults left = spool_unsent(*worker.session, *worker.spool);
  if (left.kept > 0) say(fmt::format("worker {} leaves {} results", worker.process, left.kept));
}

void Simulation::perform(Worker& worker) {
  const uint32_t process = worker.process;
  hand_in(worker);
  for (SessionAction& action : worker.session->take_actions()) {
    if (auto* send = std::get_if<SendMessage>(&action)) {
      if (now_ < worker.cut_until && worker.cut_to) continue;
      const Channel channel = send->channel;
      carry(send->message, fmt::format("{}>{}", worker.peer, static_cast<int>(channel)),
            [this, channel, peer = worker.peer](const v1::Envelope& message) {
              to_coordinator(channel, peer, message);
            });
    } else if (std::get_if<Reconnect>(&action)) {
      worker.peer = fmt::format("peer-{}", ++peers_);
    } else if (auto* build = std::get_if<StartBuild>(&action)) {
      at(now_ + milliseconds(20) + draw_time(milliseconds(300)), [this, process, run = build->run] {
        Worker* builder = find_process(process);
        if (!builder) return;
        BuildOutcome outcome;
        outcome.job = run->job;
        outcome.frame_id = run->frame_id;
        if (faults_.bad_scene) {
          outcome.failure = "simulated";
          outcome.cause = v1::SceneFailed::BAD_SCENE;
        } else if (const auto why = cannot_build(run->scene())) {
          outcome.failure = *why;
          outcome.cause = v1::SceneFailed::OUT_OF_RESOURCES;
        } else {
          outcome.renderer = make_fake_renderer(run->scene(), run->blobs, run->frame, 1);
        }
        builder->session->on_built(std::move(outcome), now_);
        perform(*builder);
      });
    } else if (auto* trace_action = std::get_if<StartTrace>(&action)) {
      worker.queue.push_back(std::move(trace_action->run));
    } else if (auto* spooled = std::get_if<SpoolResult>(&action)) {
      if (worker.spool) {
        worker.spool->keep(worker.session->hello(), worker.session->farm(), spooled->result);
      }
    } else if (auto* quit = std::get_if<Quit>(&action)) {
      say(fmt::format("worker {} quits: {}", process, quit->reason));
      const bool was_stopped = worker.frozen_until - worker.frozen_from >= seconds(3);
      const bool is_orphan = !quit->refused && quit->exit_code == ExitCode::render_failed;
      if (was_stopped && is_orphan && now_ < worker.frozen_until + seconds(1)) ++hasty_workers_;
      if (worker.spool && quit->refused) worker.spool->clear();
      leave_results(worker);
      if (!quit->refused && faults_.orphan_timeout != Time::max()) {
        at(now_ + draw_time(seconds(3)), [this] { join(); });
      }
      return at(now_, [this, process] { crash(process, true, false); });
    }
  }
  start_tracing(worker);
  if (worker.drains && worker.session->drained()) {
    at(now_, [this, process] { end_drain(process); });
  }
}

void Simulation::end_drain(uint32_t process) {
  Worker* worker = find_process(process);
  if (!worker || !worker->drains) return;
  if (now_ < worker->frozen_until) {
    return at(worker->frozen_until, [this, process] { end_drain(process); });
  }
  worker->drains = false;
  say(fmt::format("worker {} has drained", process));
  leave_results(*worker);
  worker->session->leave("simulated");
  perform(*worker);
  workers_.erase(process);
}

}  // namespace tessera::testing
