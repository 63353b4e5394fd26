#include "studio/studio_monitor.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "coordinator/coordinator.h"
#include "studio/page_answer.h"

namespace tessera {
namespace {

using Json = nlohmann::json;

constexpr double kPercent = 100;

/// The process of a worker "HOST:PROCESS" of this machine; 0 where it is of another.
int local_process(const std::string& worker) {
  static const std::string host = [] {
    std::array<char, 256> name{};
    return gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : "";
  }();
  const size_t colon = worker.rfind(':');
  if (colon == std::string::npos || worker.substr(0, colon) != host) return 0;
  int process = 0;
  std::from_chars(worker.data() + colon + 1, worker.data() + worker.size(), process);
  return process;
}

std::string_view name_of(FarmSnapshot::WorkerState state) {
  switch (state) {
    case FarmSnapshot::WorkerState::active:
      return "active";
    case FarmSnapshot::WorkerState::suspect:
      return "silent";
    case FarmSnapshot::WorkerState::lost:
      break;
  }
  return "lost";
}

double rate(double before, double after, double seconds) {
  return seconds > 0 ? std::max(0.0, after - before) / seconds : 0;
}

}  // namespace

void EditLatency::note_texts(uint64_t revision, Time now) {
  texts_.try_emplace(revision, now);
  // Comments change no picture, so that some are waited for in vain.
  if (texts_.size() > kKept) texts_.erase(texts_.begin());
}

void EditLatency::note_pass(uint32_t serial, uint64_t revision) {
  if (texts_.contains(revision)) passes_[serial] = revision;
}

void EditLatency::note_pixels(uint32_t serial, Time now) {
  const auto pass = passes_.find(serial);
  if (pass == passes_.end()) return;
  if (const auto text = texts_.find(pass->second); text != texts_.end()) {
    seconds_.push_back(to_seconds(now - text->second));
    if (seconds_.size() > kKept) seconds_.pop_front();
    // Pixels of what was typed before come no more.
    texts_.erase(texts_.begin(), std::next(text));
  }
  passes_.erase(passes_.begin(), std::next(pass));
}

std::optional<double> EditLatency::quantile(double share) const {
  if (seconds_.empty()) return std::nullopt;
  std::vector<double> sorted(seconds_.begin(), seconds_.end());
  std::sort(sorted.begin(), sorted.end());
  const double last = static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<size_t>(std::lround(share * last))];
}

std::vector<SendText> StudioMonitor::look(const Coordinator& coordinator,
                                          const std::vector<ClientId>& connected, Time now) {
  std::vector<SendText> messages;
  if (connected.empty()) {
    logged_.clear();
    last_.reset();
    return messages;
  }
  if (now >= next_log_) {
    next_log_ = now + kBetweenLogs;
    add_log(connected, messages);
  }
  if (last_ && now < next_sample_) return messages;
  next_sample_ = now + kBetweenSamples;
  const FarmSnapshot farm = coordinator.snapshot(now);
  Sample sample{.at = now,
                .counters = farm.counters,
                .machine = machine_usage(),
                .program_seconds = process_usage().cpu_seconds};
  for (const FarmSnapshot::Worker& worker : farm.workers) {
    if (const int process = local_process(worker.name); process > 0)
      sample.workers[worker.name] = cpu_seconds_of(process);
    sample.tiles[worker.id] = {worker.tiles_done, worker.tile_seconds};
  }
  if (last_) {
    const Json measured = metrics(farm, sample), list = workers(farm, sample);
    for (const ClientId client : connected) {
      messages.push_back(page_answer(client, "workers", {{"list", list}}));
      messages.push_back(page_answer(client, "metrics", measured));
    }
  }
  last_ = std::move(sample);
  return messages;
}

Json StudioMonitor::workers(const FarmSnapshot& farm, const Sample& sample) const {
  Json list = Json::array();
  const double seconds = to_seconds(sample.at - last_->at);
  for (const FarmSnapshot::Worker& worker : farm.workers) {
    Json json{{"id", worker.id},
              {"name", worker.name},
              {"state", name_of(worker.state)},
              {"threads", worker.threads},
              {"tiles", worker.tiles_done},
              {"tiles_held", worker.tiles_held},
              {"tile_seconds", worker.tile_seconds},
              {"memory", worker.resident_bytes},
              {"failures", worker.failures},
              {"connected", worker.connected_seconds}};
    const auto now = sample.workers.find(worker.name), before = last_->workers.find(worker.name);
    if (now != sample.workers.end() && before != last_->workers.end()) {
      const double cores = rate(before->second, now->second, seconds);
      json["use"] = std::min(1.0, cores / std::max(1U, worker.threads));
    }
    list.push_back(std::move(json));
  }
  return list;
}

Json StudioMonitor::metrics(const FarmSnapshot& farm, const Sample& sample) const {
  const Sample& before = *last_;
  const double seconds = to_seconds(sample.at - before.at);
  const double cores = std::max(
      1.0, (sample.machine.all_seconds - before.machine.all_seconds) / std::max(seconds, 1e-3));
  double workers = 0;
  uint64_t memory = process_usage().resident_bytes, worker_memory = 0, threads = 0;
  for (const auto& [name, used] : sample.workers) {
    if (const auto old = before.workers.find(name); old != before.workers.end())
      workers += rate(old->second, used, seconds);
  }
  for (const FarmSnapshot::Worker& worker : farm.workers) {
    if (worker.state == FarmSnapshot::WorkerState::lost) continue;
    worker_memory += worker.resident_bytes;
    threads += worker.threads;
  }
  const auto count = [](uint64_t number) { return static_cast<double>(number); };
  Json json{
      {"rays_per_second", rate(count(before.counters.rays), count(sample.counters.rays), seconds)},
      {"tiles_per_second",
       rate(count(before.counters.tiles_done), count(sample.counters.tiles_done), seconds)},
      {"cpu_program",
       kPercent * rate(before.program_seconds, sample.program_seconds, seconds) / cores},
      {"cpu_workers", kPercent * workers / cores},
      {"cpu_machine",
       kPercent * rate(before.machine.busy_seconds, sample.machine.busy_seconds, seconds) / cores},
      {"memory", memory + worker_memory},
      {"memory_machine", sample.machine.used_bytes},
      {"memory_machine_total", sample.machine.memory_bytes},
      {"worker_use", kPercent * std::min(1.0, workers / std::max(1.0, count(threads)))}};
  Json bounds = Json::array(), counts = Json::array();
  for (const double bound : SecondsHistogram::kBounds) bounds.push_back(bound);
  for (size_t i = 0; i < sample.counters.tile_seconds.counts.size(); ++i) {
    counts.push_back(sample.counters.tile_seconds.counts[i] -
                     before.counters.tile_seconds.counts[i]);
  }
  json["tile_times"] = {{"bounds", std::move(bounds)}, {"counts", std::move(counts)}};
  if (const auto median = latency_.quantile(0.5)) json["latency_median"] = *median;
  if (const auto most = latency_.quantile(0.95)) json["latency_p95"] = *most;
  return json;
}

void StudioMonitor::add_log(const std::vector<ClientId>& connected,
                            std::vector<SendText>& messages) {
  if (!log_) return;
  std::erase_if(logged_, [&](const auto& entry) {
    return std::find(connected.begin(), connected.end(), entry.first) == connected.end();
  });
  for (const ClientId client : connected) {
    uint64_t& last = logged_[client];
    Json lines = Json::array();
    for (const LogRing::Line& line : log_->after(last)) {
      last = line.number;
      lines.push_back({{"at", line.milliseconds}, {"level", line.level}, {"text", line.text}});
    }
    if (!lines.empty())
      messages.push_back(page_answer(client, "log", {{"lines", std::move(lines)}}));
  }
}

}  // namespace tessera
