#include "coordinator/web/metrics_text.h"

#include <fmt/format.h>

#include <array>
#include <iterator>
#include <map>
#include <string_view>
#include <vector>

#include "base/version.h"

namespace tessera {
namespace {

class Metrics {
 public:
  struct Sample {
    std::string labels;  ///< {name="value"}, or nothing
    double value = 0;
  };

  void add(std::string_view name, std::string_view type, std::string_view help,
           const std::vector<Sample>& samples) {
    write("# HELP tessera_{} {}\n# TYPE tessera_{} {}\n", name, help, name, type);
    for (const Sample& sample : samples) line(name, sample.labels, sample.value);
  }
  void gauge(std::string_view name, std::string_view help, double value) {
    add(name, "gauge", help, {{"", value}});
  }
  void counter(std::string_view name, std::string_view help, double value) {
    add(name, "counter", help, {{"", value}});
  }
  void histogram(std::string_view name, std::string_view help, const SecondsHistogram& times) {
    add(name, "histogram", help, {});
    double below = 0;
    for (size_t i = 0; i < times.counts.size(); ++i) {
      below += static_cast<double>(times.counts[i]);
      const std::string bound = i < SecondsHistogram::kBounds.size()
                                    ? fmt::format("{}", SecondsHistogram::kBounds[i])
                                    : "+Inf";
      line(fmt::format("{}_bucket", name), fmt::format("{{le=\"{}\"}}", bound), below);
    }
    line(fmt::format("{}_sum", name), "", times.sum);
    line(fmt::format("{}_count", name), "", below);
  }
  void line(std::string_view name, std::string_view labels, double value) {
    write("tessera_{}{} {}\n", name, labels, value);
  }
  std::string take() { return std::move(text_); }

 private:
  template <typename... Values>
  void write(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }

  std::string text_;
};

double number(uint64_t value) { return static_cast<double>(value); }

void add_jobs(Metrics& metrics, const FarmSnapshot& snapshot) {
  constexpr std::array kStates = {"queued", "running", "paused",   "held",
                                  "done",   "failed",  "cancelled"};
  std::array<double, kStates.size()> jobs{};
  double queue = 0;
  for (const FarmSnapshot::Job& job : snapshot.jobs) {
    ++jobs[static_cast<size_t>(job.state)];
    // Held ones count: what they lack may be another worker.
    const bool open = job.state == FarmSnapshot::JobState::queued ||
                      job.state == FarmSnapshot::JobState::running ||
                      job.state == FarmSnapshot::JobState::held;
    if (open) queue += number(job.tiles_total - std::min(job.tiles_done, job.tiles_total));
  }
  std::vector<Metrics::Sample> samples;
  for (size_t i = 0; i < kStates.size(); ++i) {
    samples.push_back({fmt::format("{{state=\"{}\"}}", kStates[i]), jobs[i]});
  }
  metrics.add("jobs", "gauge", "Jobs that the coordinator knows, by state.", samples);
  metrics.gauge("queue_tiles", "Tiles of queued, held and running jobs that are not done.", queue);
  metrics.counter("jobs_accepted_total", "Jobs that clients submitted.",
                  number(snapshot.counters.jobs_accepted));
}

void add_workers(Metrics& metrics, const FarmSnapshot& snapshot) {
  constexpr std::array kStates = {"active", "suspect", "lost"};
  std::array<double, kStates.size()> workers{};
  double threads = 0, credit = 0, held = 0, bytes = 0;
  for (const FarmSnapshot::Worker& worker : snapshot.workers) {
    ++workers[static_cast<size_t>(worker.state)];
    held += number(worker.tiles_held);
    if (worker.state == FarmSnapshot::WorkerState::lost) continue;
    threads += worker.threads;
    credit += worker.credit;
    bytes += number(worker.resident_bytes);
  }
  std::vector<Metrics::Sample> samples;
  for (size_t i = 0; i < kStates.size(); ++i) {
    samples.push_back({fmt::format("{{state=\"{}\"}}", kStates[i]), workers[i]});
  }
  metrics.add("workers", "gauge", "Workers by state; lost ones are forgotten in time.", samples);
  metrics.gauge("worker_threads", "Threads of the workers that are there.", threads);
  metrics.gauge("worker_credit_tiles", "Tiles that they take at one time.", credit);
  metrics.gauge("tiles_in_flight", "Tiles that workers hold, second copies included.", held);
  metrics.gauge("worker_resident_bytes", "Memory of the workers' processes, sum.", bytes);
  const FarmSnapshot::Counters& counters = snapshot.counters;
  metrics.counter("workers_seen_total", "Workers that have come.", number(counters.workers_seen));
  metrics.counter("workers_lost_total", "Workers that vanished or crashed.",
                  number(counters.workers_lost));
  metrics.counter("workers_set_aside_total", "Workers that failed tiles or lied.",
                  number(counters.workers_set_aside));
}

void add_tiles(Metrics& metrics, const FarmSnapshot::Counters& counters) {
  metrics.add("tiles_total", "counter", "Tiles that ended, by how.",
              {{"{state=\"done\"}", number(counters.tiles_done)},
               {"{state=\"restored\"}", number(counters.tiles_restored)},
               {"{state=\"given_up\"}", number(counters.tiles_given_up)}});
  metrics.counter("tile_retries_total", "Assignments that replaced one that came to nothing.",
                  number(counters.retries));
  metrics.counter("tile_copies_total", "Second copies of tiles that took long.",
                  number(counters.speculative));
  metrics.counter("tile_duplicates_total", "Results for tiles that were done already.",
                  number(counters.duplicates));
  metrics.counter("tile_mismatches_total", "Results that differed from another worker's.",
                  number(counters.mismatches));
  metrics.histogram("tile_seconds", "From the assignment of a tile to its completion.",
                    counters.tile_seconds);
  metrics.histogram("store_commit_seconds", "Of each write of tiles, jobs and blobs to the store.",
                    counters.commit_seconds);
  metrics.add("wire_bytes_total", "counter", "Bytes of blobs sent to workers, and of pixels back.",
              {{"{kind=\"scene\"}", number(counters.bytes_scene)},
               {"{kind=\"result\"}", number(counters.bytes_results)}});
}

}  // namespace

std::string metrics_text(const FarmSnapshot& snapshot, const FarmMonitor::Work& work,
                         const WebCounts& web, const ProcessUsage& usage) {
  Metrics metrics;
  metrics.add("build_info", "gauge", "Always 1.",
              {{fmt::format("{{version=\"{}\"}}", kVersion), 1}});
  metrics.gauge("uptime_seconds", "Since the coordinator was started.", snapshot.uptime_seconds);
  metrics.gauge("store_trouble", "1 where no tile is given out since the store takes none.",
                snapshot.store_trouble.empty() ? 0 : 1);
  add_jobs(metrics, snapshot);
  add_workers(metrics, snapshot);
  add_tiles(metrics, snapshot.counters);
  metrics.gauge("coordinator_resident_bytes", "Memory of the coordinator's process.",
                number(usage.resident_bytes));
  metrics.counter("coordinator_cpu_seconds_total", "Processor time of the coordinator's process.",
                  usage.cpu_seconds);
  metrics.gauge("coordinator_open_files", "Descriptors of the coordinator's process.",
                number(usage.open_files));
  metrics.counter("web_requests_total", "Requests that the page's server answered.",
                  number(web.requests));
  metrics.counter("web_snapshots_total", "Snapshots that the coordinator made for who watches.",
                  number(work.snapshots));
  metrics.counter("web_previews_total", "Previews that the coordinator made for who watches.",
                  number(work.previews));
  metrics.counter("web_previews_encoded_total", "Of these, encoded as PNG.",
                  number(web.previews_encoded));
  return metrics.take();
}

}  // namespace tessera
