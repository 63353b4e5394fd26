#include "coordinator/worker_registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "proto/wire/printable.h"

namespace tessera {
namespace {

constexpr size_t kMaxText = 256;
constexpr uint32_t kMaxCredit = 8192;
constexpr uint32_t kMaxThreads = 1024;  // of one worker, that count
/// More than this at once are refused: ids cost nothing to make up.
constexpr size_t kMaxWorkers = 16384;
// Lost workers that are remembered, so that late results are known for whose they are.
constexpr Time kForgetAfter = std::chrono::minutes(10);

v1::Reject rejected(v1::Reject::Reason reason, std::string text) {
  v1::Reject reject;
  reject.set_reason(reason);
  reject.set_text(std::move(text));
  return reject;
}

/// The worker of a process of this host.
template <typename Workers>
auto find_process(Workers& workers, const std::string& host, pid_t process) {
  return std::find_if(workers.begin(), workers.end(), [&](const auto& entry) {
    const v1::Hello& hello = entry.second.hello;
    return hello.process_id() == static_cast<uint32_t>(process) && hello.host() == host;
  });
}

}  // namespace

v1::Reject id_taken(const v1::Hello& hello) {
  v1::Reject reject = rejected(
      v1::Reject::ID_TAKEN, fmt::format("another worker uses this id, {:016x}; expected one that "
                                        "this worker drew itself: start it again",
                                        hello.worker_id()));
  reject.set_session(hello.session());
  return reject;
}

std::string WorkerRecord::name() const {
  return fmt::format("{}:{}", hello.host().empty() ? "worker" : printable(hello.host()),
                     hello.process_id());
}

bool WorkerRecord::ready_for(uint64_t job) const {
  const auto it = jobs.find(job);
  return it != jobs.end() && it->second.ready;
}

std::optional<v1::Reject> WorkerRegistry::judge(const v1::Hello& hello,
                                                const AllowedKey& sender) const {
  if (hello.protocol_major() != options_.protocol_major) {
    return rejected(
        v1::Reject::PROTOCOL,
        fmt::format("the worker ({}) speaks protocol {}.{}; the coordinator expected {}.x",
                    printable(hello.build()), hello.protocol_major(), hello.protocol_minor(),
                    options_.protocol_major));
  }
  if (hello.numerics_id() != options_.numerics_id) {
    return rejected(v1::Reject::NUMERICS,
                    fmt::format("the worker computes by '{}'; the coordinator expected '{}'",
                                printable(hello.numerics_id()), options_.numerics_id));
  }
  if (auto reject = judge_aside(hello.worker_id(), sender)) return reject;
  const auto known = workers_.find(hello.worker_id());
  if (known != workers_.end() && known->second.sender.key != sender.key) return id_taken(hello);
  if (hello.worker_id() == 0 || hello.worker_id() >= kReservedId || hello.session() == 0 ||
      hello.credit() == 0 || hello.credit() > kMaxCredit || hello.host().size() > kMaxText) {
    return rejected(v1::Reject::PROTOCOL,
                    fmt::format("worker {}, session {}, credit {}; expected numbers above 0, an id "
                                "below 2^63 and at most {} tiles of credit",
                                hello.worker_id(), hello.session(), hello.credit(), kMaxCredit));
  }
  return std::nullopt;
}

std::optional<v1::Reject> WorkerRegistry::judge_aside(WorkerId id, const AllowedKey& sender) const {
  const auto aside = set_aside_.find(id);
  if (aside != set_aside_.end()) return rejected(v1::Reject::QUARANTINED, aside->second);
  const auto blame = blame_.find(sender.key);
  if (blame != blame_.end() && blame->second.set_aside) {
    return rejected(v1::Reject::QUARANTINED, *blame->second.set_aside);
  }
  return std::nullopt;
}

WorkerRegistry::Greeting WorkerRegistry::greet(const PeerId& peer, const v1::Hello& hello, Time now,
                                               const AllowedKey& sender) {
  if (workers_.size() >= kMaxWorkers && !workers_.contains(hello.worker_id())) {
    forget_lost();
    if (workers_.size() >= kMaxWorkers) return {};
  }
  const auto [it, inserted] = workers_.try_emplace(hello.worker_id());
  WorkerRecord& worker = it->second;
  if (inserted) {
    worker.id = hello.worker_id();
    worker.sender = sender;
  } else if (hello.session() < worker.hello.session()) {
    return {nullptr, true};
  }
  const std::string before = inserted || worker.peer == peer ? "" : worker.name();
  const bool anew = inserted || hello.session() != worker.hello.session();
  if (!worker.peer.empty() && worker.peer != peer) by_peer_.erase(worker.peer);
  const auto other = by_peer_.find(peer);
  if (other != by_peer_.end() && other->second != &worker) other->second->peer.clear();
  by_peer_[peer] = &worker;
  worker.peer = peer;
  worker.unreachable = false;
  worker.hello = hello;
  worker.last_heard = now;
  worker.state = WorkerState::active;
  if (anew) {
    worker.came = now;
    worker.jobs.clear();
    worker.foreign = 0;
    worker.leaves = false;
  }
  return {&worker, false, anew, !inserted, before};
}

void WorkerRegistry::forget_lost() {
  std::erase_if(workers_, [this](const auto& entry) {
    const WorkerRecord& worker = entry.second;
    if (worker.state != WorkerState::lost) return false;
    by_peer_.erase(worker.peer);
    return true;
  });
}

WorkerRecord* WorkerRegistry::by_id(WorkerId id) {
  const auto it = workers_.find(id);
  return it == workers_.end() ? nullptr : &it->second;
}

WorkerRecord* WorkerRegistry::by_peer(const PeerId& peer) {
  const auto it = by_peer_.find(peer);
  return it == by_peer_.end() ? nullptr : it->second;
}

WorkerRecord* WorkerRegistry::by_process(pid_t process) {
  const auto it = find_process(workers_, options_.host, process);
  return it == workers_.end() ? nullptr : &it->second;
}

bool WorkerRegistry::knows_process(pid_t process) const {
  return find_process(workers_, options_.host, process) != workers_.end();
}

bool WorkerRegistry::heard(WorkerRecord& worker, Time now) {
  const bool back = worker.state == WorkerState::lost;
  worker.state = WorkerState::active;
  worker.last_heard = now;
  return back;
}

void WorkerRegistry::lose(WorkerRecord& worker) {
  if (worker.state == WorkerState::lost) return;
  worker.state = WorkerState::lost;
  worker.jobs.clear();
  worker.foreign = 0;
}

void WorkerRegistry::set_key_aside(const std::string& key, const std::string& cause) {
  blame_[key].set_aside = cause;
}

int WorkerRegistry::blame(WorkerRecord& worker) {
  ++worker.failures;
  return worker.sender.key.empty() ? worker.failures : ++blame_[worker.sender.key].failures;
}

int WorkerRegistry::blamed(const WorkerRecord& worker) const {
  const auto it = blame_.find(worker.sender.key);
  return it == blame_.end() ? worker.failures : std::max(worker.failures, it->second.failures);
}

std::vector<WorkerRecord*> WorkerRegistry::with_key(const std::string& key) {
  std::vector<WorkerRecord*> result;
  for (auto& [id, worker] : workers_) {
    if (worker.sender.key == key) result.push_back(&worker);
  }
  return result;
}

void WorkerRegistry::set_aside(WorkerId worker, const std::string& cause) {
  set_aside_.emplace(worker, cause);
}

WorkerRegistry::Silence WorkerRegistry::check(Time now) {
  Silence silence;
  for (auto it = workers_.begin(); it != workers_.end();) {
    WorkerRecord& worker = it->second;
    const Time age = now - worker.last_heard;
    if (worker.state == WorkerState::lost) {
      if (age >= kForgetAfter) {
        by_peer_.erase(worker.peer);
        it = workers_.erase(it);
        continue;
      }
    } else if (age >= options_.lost_after) {
      silence.lost.push_back(&worker);
    } else if (age >= options_.suspect_after && worker.state == WorkerState::active) {
      worker.state = WorkerState::suspect;
      silence.suspects.push_back(&worker);
    }
    ++it;
  }
  return silence;
}

void WorkerRegistry::forgive(Time silence, Time now) {
  for (auto& [id, worker] : workers_) {
    worker.last_heard = std::min(now, worker.last_heard + silence);
    worker.got_on = std::min(now, worker.got_on + silence);
  }
}

std::vector<WorkerRecord*> WorkerRegistry::present() {
  std::vector<WorkerRecord*> result;
  for (auto& [id, worker] : workers_) {
    if (worker.state != WorkerState::lost) result.push_back(&worker);
  }
  return result;
}

uint32_t WorkerRegistry::present_threads() const {
  uint32_t threads = 0;
  for (const auto& [id, worker] : workers_) {
    if (worker.state != WorkerState::lost) threads += std::min(worker.hello.threads(), kMaxThreads);
  }
  return threads;
}

int WorkerRegistry::present_count() const {
  return static_cast<int>(std::count_if(workers_.begin(), workers_.end(), [](const auto& entry) {
    return entry.second.state != WorkerState::lost;
  }));
}

}  // namespace tessera
