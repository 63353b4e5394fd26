#include "tests/farm/simulation.h"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "proto/wire/frame.h"

namespace tessera::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Time kTroubleTime = seconds(20);
constexpr Time kPatience = seconds(600);
constexpr size_t kWorkersAtStart = 3;

}  // namespace

Simulation::Simulation(uint64_t seed,
                       const std::function<void(Faults&, CoordinatorOptions&)>& adjust)
    : random_(seed) {
  draw_faults();
  // Not drawn, so that the schedules of all others are what they were.
  if (seed % 4 == 0) faults_.coordinator_stops = seconds(2 + seed / 4 % 60);
  options_.opening = opening_of(1);
  options_.host = kHost;
  options_.compress_pixels = draw() < 0.2;
  options_.verify = draw() < 0.2 ? draw() : 0;
  if (adjust) adjust(faults_, options_);
  options_.worker_keys = faults_.keys;
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

// --------------------------------------------------------------------------------------- network

void Simulation::to_coordinator(Channel channel, const PeerId& peer, const v1::Envelope& message) {
  const Time reads = coordinator_stopped_until_ + kRead;
  if (now_ < reads) {
    return at(reads, [this, channel, peer, message] { to_coordinator(channel, peer, message); });
  }
  const Worker* const worker = find(peer);
  const AllowedKey sender = worker ? worker->key : AllowedKey{};
  with_coordinator([&](Coordinator& c) { c.on_message(channel, peer, message, now_, sender); });
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
            // A stopped process finds its messages when it goes on, after it has seen the time.
            const Worker* worker = find(peer);
            if (!worker || now_ >= worker->frozen_until + kRead) return arrive(message);
            at(worker->frozen_until + kRead, [message, arrive] { arrive(message); });
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
  Time next = std::max(coordinator_->next_deadline(), coordinator_stopped_until_);
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
  if (now_ >= std::max(coordinator_->next_deadline(), coordinator_stopped_until_)) {
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
  coordinator_stopped_until_ = {};
  options_.opening = opening_of(++openings_);
  coordinator_ = std::make_unique<Coordinator>(options_);
  if (client_) return;
  job_.frame.set_seed(job_.frame.seed() + 1);
  submit();
  deliver();
}

void Simulation::plan_stop() {
  if (faults_.coordinator_stops == Time{0}) return;
  at(now_ + draw_time(seconds(8)), [this] {
    say("the coordinator is stopped");
    coordinator_stopped_until_ = now_ + faults_.coordinator_stops;
  });
}

std::optional<JobResult> Simulation::run() {
  const Time start = now_;
  submit();
  plan_stop();
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
