#include "tests/farm/simulation.h"

#include <fmt/format.h>

#include <cstdio>
#include <utility>
#include <variant>

#include "proto/wire/frame.h"
#include "proto/wire/pixels.h"
#include "worker/run_worker.h"

namespace tessera::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Time kTroubleTime = seconds(20);
constexpr Time kPatience = seconds(600);
constexpr size_t kWorkersAtStart = 3;
constexpr size_t kMostWorkers = 6;
constexpr char kHost[] = "simulated";

}  // namespace

Simulation::Simulation(uint64_t seed,
                       const std::function<void(Faults&, CoordinatorOptions&)>& adjust)
    : random_(seed) {
  draw_faults();
  options_.epoch = 1;
  options_.host = kHost;
  options_.compress_pixels = draw() < 0.2;
  options_.verify = draw() < 0.2 ? draw() : 0;
  if (adjust) adjust(faults_, options_);
  const int tile = 4 + static_cast<int>(draw(9));
  job_ = make_job(16 + static_cast<int>(draw(9)), 16 + static_cast<int>(draw(9)), tile);
  job_.crop.x0 = static_cast<int>(draw(5));
  job_.crop.y1 -= static_cast<int>(draw(5));
  coordinator_ = std::make_unique<Coordinator>(options_);
}

void Simulation::draw_faults() {
  // Each kind is absent from half of the seeds, so that the others show what they do alone.
  const auto sometimes = [this](double most) { return draw() < 0.5 ? 0 : draw() * most; };
  faults_.loss = sometimes(0.2);
  faults_.duplication = sometimes(0.3);
  faults_.corruption = sometimes(0.05);
  faults_.delay = milliseconds(1 + static_cast<int64_t>(sometimes(1500)));
  faults_.in_order = draw() < 0.5;
  faults_.events = draw() < 0.3 ? 0 : static_cast<int>(draw(8));
  faults_.split_bands = draw() < 0.3;
  faults_.as_frames = draw() < 0.2;
  faults_.by_client = draw() < 0.2;
  faults_.one_fails = draw() < 0.1;
  faults_.one_hangs = draw() < 0.2;
  faults_.bad_scene = draw() < 0.05;
  faults_.restarts = draw() < 0.2;
  pace_ = 0.2 + 8 * draw() * draw();
}

void Simulation::say(const std::string& text) const {
  if (trace) std::fprintf(stderr, "%9.3f %s\n", to_seconds(now_) - 1000, text.c_str());
}

void Simulation::at(Time time, std::function<void()> act) {
  events_.push({time, ++order_, std::move(act)});
}

void Simulation::carry(const v1::Envelope& message, const std::string& line,
                       const std::function<void(const v1::Envelope&)>& arrive) {
  ++messages_;
  if (!quiet_ && draw() < faults_.loss) return;
  auto carried = std::make_shared<std::optional<v1::Envelope>>(message);
  if (faults_.as_frames) {
    Frame frame = encode(message);
    if (!quiet_ && draw() < faults_.corruption) {
      frame[draw(frame.size())] ^= static_cast<std::byte>(1u << draw(8));
    }
    *carried = decode(frame, max_message_bytes(Channel::bulk));
    if (!*carried) return;
  }
  const int copies = !quiet_ && draw() < faults_.duplication ? 2 : 1;
  for (int copy = 0; copy < copies; ++copy) {
    Time arrival = now_ + Time(50'000) + (quiet_ ? Time{0} : draw_time(faults_.delay));
    if (faults_.in_order) {
      Time& last = last_arrival_[line];
      last = arrival = std::max(arrival, last);
    }
    at(arrival, [carried, arrive] { arrive(**carried); });
  }
}

// --------------------------------------------------------------------------------------- workers

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
  worker.lies = faults_.one_lies && processes_ == 3;
  worker.slowness = draw() < 0.2 ? 10 : 0.5 + draw();
  SessionOptions options;
  v1::Hello& hello = options.hello;
  hello.set_protocol_major(kProtocolMajor);
  hello.set_numerics_id(kNumericsId);
  hello.set_worker_id(random_() | 1);
  hello.set_host(draw() < 0.5 ? kHost : "elsewhere");
  hello.set_process_id(worker.process);
  hello.set_threads(1 + static_cast<uint32_t>(draw(3)));
  hello.set_credit(hello.threads() + 1);
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
  at(now_ + draw_time(milliseconds(50)), [this, peer, process, own_fault] {
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
  switch (draw(6)) {
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
      worker.frozen_until = now_ + (draw() < 0.3 ? Time(seconds(10000)) : draw_time(seconds(15)));
      return say(fmt::format("worker {} is stopped", worker.process));
    case 4:
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

void Simulation::perform(Worker& worker) {
  const uint32_t process = worker.process;
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
        if (faults_.bad_scene) {
          outcome.failure = "simulated";
          outcome.exit_code = static_cast<int>(ExitCode::bad_scene);
        } else {
          outcome.renderer = make_fake_renderer(run->scene, run->blobs, run->frame, 1);
        }
        builder->session->on_built(std::move(outcome), now_);
        perform(*builder);
      });
    } else if (auto* trace_action = std::get_if<StartTrace>(&action)) {
      worker.queue.push_back(std::move(trace_action->run));
    } else if (auto* quit = std::get_if<Quit>(&action)) {
      say(fmt::format("worker {} quits: {}", process, quit->reason));
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
  worker->session->leave("simulated");
  perform(*worker);
  workers_.erase(process);
}

// --------------------------------------------------------------------------------------- network

void Simulation::to_coordinator(Channel channel, const PeerId& peer, const v1::Envelope& message) {
  with_coordinator([&](Coordinator& c) { c.on_message(channel, peer, message, now_); });
  deliver();
}

bool Simulation::tell_client(const PeerId& peer, Channel channel, const v1::Envelope& message) {
  if (peer != "client" || !client_) return false;
  client_->on_message(channel, message, now_);
  deliver_client();
  return true;
}

Time Simulation::next_client_time() const {
  return client_ ? client_->next_deadline() : Time::max();
}

void Simulation::tick_clients() {
  if (!client_ || now_ < client_->next_deadline()) return;
  client_->on_tick(now_);
  deliver_client();
}

void Simulation::deliver() {
  for (OutgoingMessage& out : coordinator_->take_outgoing()) {
    const Channel channel = out.channel;
    const PeerId peer = out.peer;
    note_sent(out);
    if (const Worker* worker = find(peer); worker && now_ < worker->cut_until && worker->cut_from) {
      continue;
    }
    const std::function<void(const v1::Envelope&)> arrive = [this, channel,
                                                             peer](const v1::Envelope& message) {
      if (tell_client(peer, channel, message)) return;
      Worker* worker = find(peer);
      if (!worker) return;
      worker->session->on_message(channel, message, now_);
      perform(*worker);
    };
    carry(out.message, fmt::format("{}<{}", peer, static_cast<int>(channel)),
          [this, peer, arrive](const v1::Envelope& message) {
            // A stopped process finds its messages when it goes on.
            const Worker* worker = find(peer);
            if (!worker || now_ >= worker->frozen_until) return arrive(message);
            at(worker->frozen_until, [message, arrive] { arrive(message); });
          });
  }
}

void Simulation::deliver_client() {
  for (auto& [channel, message] : client_->take_outgoing()) {
    carry(message, fmt::format("client>{}", static_cast<int>(channel)),
          [this, channel = channel](const v1::Envelope& arrived) {
            to_coordinator(channel, "client", arrived);
          });
  }
}

// ------------------------------------------------------------------------------------------ time

Time Simulation::next_time() const {
  Time next = coordinator_->next_deadline();
  if (!events_.empty()) next = std::min(next, events_.top().time);
  for (const auto& [process, worker] : workers_) {
    next = std::min(next, std::max(worker.session->next_deadline(), worker.frozen_until));
  }
  return std::max(std::min(next, next_client_time()), now_);
}

void Simulation::tick() {
  while (!events_.empty() && events_.top().time <= now_) {
    const Event event = events_.top();
    events_.pop();
    event.act();
  }
  if (now_ >= coordinator_->next_deadline()) {
    with_coordinator([this](Coordinator& c) { c.on_tick(now_); });
    for (const pid_t process : coordinator_->take_stuck_processes()) {
      crash(static_cast<uint32_t>(process), true, false);
      join();
    }
    deliver();
  }
  for (auto& [process, worker] : workers_) {
    if (now_ < worker.frozen_until || now_ < worker.session->next_deadline()) continue;
    for (auto& [key, run] : worker.tracing) {
      const bool stuck = now_ - run.second > seconds(60);
      if (!stuck)
        run.first->progress.work_done = static_cast<uint64_t>((now_ - run.second).count());
    }
    worker.session->on_tick(now_);
    perform(worker);
  }
  tick_clients();
}

void Simulation::thaw_all() {
  say("trouble ends");
  quiet_ = true;
  for (auto& [process, worker] : workers_) {
    worker.cut_until = {};
    worker.slowness = std::min(worker.slowness, 1.0);
  }
  if (!faults_.one_alone) join();
}

void Simulation::submit() {
  if (faults_.by_client) {
    client_ = std::make_unique<JobClient>(job_, 42, now_);
    deliver_client();
  } else {
    id_ = coordinator_->submit(job_, now_);
  }
}

void Simulation::restart_coordinator() {
  say("the coordinator is started anew");
  ++options_.epoch;
  coordinator_ = std::make_unique<Coordinator>(options_);
  if (client_) return;
  job_.frame.set_seed(job_.frame.seed() + 1);
  submit();
  deliver();
}

std::optional<JobResult> Simulation::run() {
  const Time start = now_;
  submit();
  if (faults_.restarts) at(now_ + draw_time(seconds(5)), [this] { restart_coordinator(); });
  for (size_t i = 0; i < (faults_.one_alone ? 1 : kWorkersAtStart); ++i)
    at(now_ + draw_time(milliseconds(500)), [this] { join(); });
  for (int i = 0; i < faults_.events; ++i) {
    at(now_ + draw_time(draw() < 0.5 ? Time(seconds(2)) : kTroubleTime),
       [this] { something_happens(); });
  }
  at(now_ + kTroubleTime, [this] { thaw_all(); });
  while (now_ - start < kPatience) {
    now_ = next_time();
    tick();
    auto result = client_ ? client_->take_result() : coordinator_->take_result(id_);
    if (result) return result;
  }
  return std::nullopt;
}

}  // namespace tessera::testing
