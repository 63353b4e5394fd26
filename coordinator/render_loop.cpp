#include "coordinator/render_loop.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <random>
#include <utility>

#include "base/log.h"
#include "base/plural.h"
#include "coordinator/coordinator.h"
#include "coordinator/key_registry.h"
#include "coordinator/permissions.h"
#include "coordinator/tiles/identity.h"
#include "proto/wire/frame.h"

namespace tessera {
namespace {

/// How long a coordinator that ends keeps telling so.
constexpr Time kFarewell = std::chrono::milliseconds(300);
constexpr std::chrono::milliseconds kBetweenFarewells{20};
constexpr Time kLookAtProcesses = std::chrono::milliseconds(20);
// Where a look comes so much too late, this process did not run.
constexpr Time kLongestDelay = std::chrono::seconds(1);
constexpr Time kTellProgress = std::chrono::milliseconds(100);
// After so many messages, what is due by the clock has its turn.
constexpr int kMessagesPerRound = 256;

CoordinatorOptions completed(CoordinatorOptions options, const ServerTransport& transport) {
  if (transport.endpoint().starts_with("ipc://")) {
    options.shared_by_process = static_cast<uint32_t>(getpid());
  }
  std::random_device random;
  if (options.verify_key == 0) options.verify_key = uint64_t{random()} << 32 | random();
  if (options.opening.empty()) options.opening = draw_opening();
  if (options.host.empty()) {
    std::array<char, 256> name{};
    if (gethostname(name.data(), name.size() - 1) == 0) options.host = name.data();
  }
  return options;
}

}  // namespace

RenderLoop::RenderLoop(std::unique_ptr<ServerTransport> transport,
                       const CoordinatorOptions& options, std::shared_ptr<JobStore> store)
    : transport_(std::move(transport)),
      coordinator_(
          std::make_unique<Coordinator>(completed(options, *transport_), std::move(store))),
      greeting_(options.greeting) {}

RenderLoop::~RenderLoop() = default;

JobResult RenderLoop::run(JobSpec job, const ProgressCallback& progress,
                          const std::atomic<bool>& stop, std::shared_ptr<TileStore> tiles) {
  const uint64_t id = coordinator_->submit(std::move(job), monotonic_now(), std::move(tiles));
  try {
    return wait_for(id, progress, stop);
  } catch (...) {
    coordinator_->abandon(id);
    throw;
  }
}

JobResult RenderLoop::wait_for(uint64_t id, const ProgressCallback& progress,
                               const std::atomic<bool>& stop) {
  tiles_done_ = 0;
  Time next_progress{};
  while (true) {
    deliver();
    // Before the step: only running jobs have progress, and a small job ends within its first step.
    if (const Time now = monotonic_now(); progress && now >= next_progress) {
      progress(coordinator_->progress(now));
      next_progress = now + kTellProgress;
    }
    step(kLongestWait);
    if (stop) coordinator_->interrupt(id, monotonic_now());
    if (auto result = coordinator_->take_result(id)) {
      deliver();
      return std::move(*result);
    }
  }
}

void RenderLoop::observe(std::function<void(Coordinator&, Time)> look, Time every) {
  observer_ = std::move(look);
  observe_every_ = every;
}

void RenderLoop::wake() {
  woken_ = true;  // first: a wait that ends by the next line finds it
  transport_->wake();
}

void RenderLoop::serve(const std::atomic<bool>& stop, Time drain,
                       const std::function<void()>& each_round) {
  while (!stop) {
    step(kLongestWait);
    if (each_round) each_round();
  }
  coordinator_->drain();
  const Time end = monotonic_now() + drain;
  while (monotonic_now() < end && !coordinator_->drained()) step(kLongestWait);
}

void RenderLoop::shut_down(const std::string& reason) {
  // Whose hello has just come must hear it too.
  receive();
  coordinator_->shut_down(reason);
  deliver();
}

void RenderLoop::bid_farewell(const std::string& reason) {
  const Time end = monotonic_now() + kFarewell;
  while (monotonic_now() < end) {
    shut_down(reason);
    transport_->wait(kBetweenFarewells);
  }
}

void RenderLoop::step(Time pause) {
  Time due = coordinator_->next_deadline();
  if (local_workers_) due = std::min(due, next_look_);
  if (observer_ && is_unobserved_) due = std::min(due, next_observation_);
  const Time wait = std::min(pause, due - monotonic_now());
  transport_->wait(std::chrono::ceil<std::chrono::milliseconds>(std::max(wait, Time{0})));
  receive();
  const Time now = monotonic_now();
  if (now >= coordinator_->next_deadline()) coordinator_->on_tick(now);
  if (local_workers_ && now >= next_look_) attend_local_workers(now);
  const uint64_t news = coordinator_->news();
  const bool woken = woken_.exchange(false);
  if (observer_ && (woken || now >= next_observation_ || news != observed_news_)) {
    next_observation_ = now + observe_every_;
    is_unobserved_ = false;
    observed_news_ = news;
    observer_(*coordinator_, now);
  }
  deliver();
}

void RenderLoop::receive() {
  for (int i = 0; i < kMessagesPerRound; ++i) {
    const auto received = transport_->receive();
    if (!received) return;
    is_unobserved_ = true;
    const Time start = monotonic_now();
    const auto message = decode(received->bytes, max_message_bytes(received->channel));
    if (!message) {
      if (const auto count = garbage_.note(start)) {
        spdlog::warn("dropped {} that {} none of ours, the last one of {} bytes",
                     counted(*count, "message"), *count == 1 ? "is" : "are",
                     received->bytes.size());
      }
      continue;
    }
    if (const auto reject = refuse(received->sender, *message)) {
      turn_away(*received, *reject);
      continue;
    }
    if (message->has_enrol()) {
      if (keys_ && received->sender.role == Role::enrol) enrol(*received, message->enrol());
      continue;
    }
    // Counted before the job may end with this very band, so the writing of the last one is not.
    if (message->has_tile_band()) {
      coordinator_->note_assembling(message->tile_band().job(), monotonic_now() - start);
    }
    const Time handling = monotonic_now();
    coordinator_->on_message(received->channel, received->peer, *message, handling,
                             received->sender);
    if (message->has_tile_band()) {
      coordinator_->note_assembling(message->tile_band().job(), monotonic_now() - handling);
    }
    deliver();
  }
}

void RenderLoop::turn_away(const ReceivedMessage& received, const v1::Reject& reject) {
  // One line a key: whoever does not listen may go on for ever.
  if (told_refused_.insert(received.sender.name).second) spdlog::warn("refused: {}", reject.text());
  v1::Envelope answer;
  *answer.mutable_reject() = reject;
  transport_->send(received.channel, received.peer, encode(answer));
}

void RenderLoop::enrol(const ReceivedMessage& received, const v1::Enrol& request) {
  const AllowedKey& token = received.sender;
  const size_t known = keys_->keys().size();
  v1::Envelope answer;
  *answer.mutable_enrol_answer() = keys_->enrol(token, request, wall_clock_now());
  const v1::EnrolAnswer& outcome = answer.enrol_answer();
  std::string address = transport_->address(received.peer);
  if (address.empty()) address = "an unknown address";
  if (keys_->keys().size() > known) {
    spdlog::info("enrolled the {} {}, key {}, by the token {}, from {}", outcome.role(),
                 outcome.name(), request.public_key(), token.name, address);
    let_in(keys_->keys());
  } else if (outcome.outcome() != v1::EnrolAnswer::ENROLLED &&
             told_refused_.insert(token.name).second) {
    spdlog::warn("enrolled nobody by the token {} from {}: {}", token.name, address,
                 outcome.text());
  }
  transport_->send(received.channel, received.peer, encode(answer));
}

void RenderLoop::set_allowed(AllowList allowed) {
  told_refused_.clear();
  coordinator_->forgive_keys();
  let_in(std::move(allowed));
}

void RenderLoop::let_in(AllowList allowed) {
  coordinator_->set_worker_keys(allowed.count(Role::worker));
  const Time now = monotonic_now();
  for (const PeerId& peer : transport_->set_allowed(std::move(allowed))) {
    coordinator_->on_peer_gone(peer, now);
  }
  deliver();
}

void RenderLoop::tell_way(const PeerId& peer, v1::Envelope& message) const {
  if (message.has_welcome()) {
    message.mutable_welcome()->set_bulk_endpoint(transport_->bulk_endpoint_for(peer));
    message.mutable_welcome()->set_compress_pixels(transport_->comes_by_network(peer));
  } else if (message.has_job_status()) {
    message.mutable_job_status()->set_bulk_endpoint(transport_->bulk_endpoint_for(peer));
  }
}

void RenderLoop::deliver() {
  for (auto messages = coordinator_->take_outgoing(); !messages.empty();
       messages = coordinator_->take_outgoing()) {
    for (OutgoingMessage& out : messages) {
      if (out.channel == Channel::control) tell_way(out.peer, out.message);
      const SendResult sent = transport_->send(out.channel, out.peer, encode(out.message));
      // What was dropped for a peer that does not read is told again when it does.
      if (sent == SendResult::gone && out.channel == Channel::control) {
        coordinator_->on_peer_gone(out.peer, monotonic_now(), !out.message.has_welcome());
      }
    }
  }
}

void RenderLoop::kill_silent(Time now) {
  std::map<pid_t, std::optional<Silence>> silent;
  for (const pid_t process : local_workers_->processes()) {
    if (coordinator_->workers().knows_process(process)) continue;
    const auto known = silent_since_.find(process);
    // Nothing once it was killed, though it may not have ended by the next look.
    std::optional<Silence> silence =
        known == silent_since_.end() ? std::optional(Silence(now)) : known->second;
    if (silence) silence->listen(next_look_ + kLongestDelay, now);
    if (silence && silence->length(now) > greeting_) {
      local_workers_->kill_silent(process);
      silence.reset();
    }
    silent.emplace(process, silence);
  }
  silent_since_ = std::move(silent);
}

void RenderLoop::attend_local_workers(Time now) {
  const JobProgress progress = coordinator_->progress(now);
  const bool is_idle = progress.tiles_done == progress.tiles_total;
  if (progress.tiles_done != std::exchange(tiles_done_, progress.tiles_done))
    local_workers_->note_progress();
  kill_silent(now);
  next_look_ = now + (is_idle ? kLongestWait : kLookAtProcesses);
  for (const pid_t process : coordinator_->take_stuck_processes()) {
    local_workers_->kill_stuck(process);
  }
  const std::vector<EndedProcess> ended = local_workers_->collect_ended();
  for (const EndedProcess& process : ended)
    coordinator_->on_process_ended(process.pid, process.crashed, process.how, now);
  try {
    local_workers_->replace(ended, now);
  } catch (const Error& error) {
    spdlog::error("{}", error.what());
    coordinator_->fail_jobs(error.what(), now);
  }
}

}  // namespace tessera
