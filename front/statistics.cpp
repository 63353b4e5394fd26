#include "front/statistics.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "base/version.h"
#include "renderer/scene/read_settings.h"

namespace tessera {
namespace {

using json = nlohmann::ordered_json;

uint64_t counter(const CounterMap& counters, const char* name) {
  const auto found = counters.find(name);
  return found == counters.end() ? 0 : found->second;
}

/// The largest resident set of this process so far.
uint64_t peak_memory_bytes() {
  rusage self{};
  getrusage(RUSAGE_SELF, &self);
  constexpr uint64_t kKibi = 1024;
  return static_cast<uint64_t>(self.ru_maxrss) * kKibi;
}

json rays_json(const CounterMap& counters) {
  json rays;
  uint64_t total = 0;
  for (const char* kind : {"primary", "shadow", "reflection", "refraction"}) {
    const uint64_t count = counter(counters, fmt::format("rays_{}", kind).c_str());
    rays[kind] = count;
    total += count;
  }
  rays["total"] = total;
  return rays;
}

/// Work that was not done: every counter that does not count work.
json skips_json(const CounterMap& counters) {
  constexpr std::array<std::string_view, 10> kWork{
      "rays_primary",           "rays_shadow", "rays_reflection",
      "rays_refraction",        "hits",        "node_visits",
      "primitive_tests",        "samples",     "nan_samples",
      "samples_beside_the_tile"};
  json skips = json::object();
  for (const auto& [name, count] : counters) {
    if (std::find(kWork.begin(), kWork.end(), name) == kWork.end()) skips[name] = count;
  }
  return skips;
}

/// What `auto` came to; null where nobody built the scene, as all tiles were kept from before.
json integrator_chosen(const FrameStatistics& statistics) {
  if (statistics.frame.integrator() != "auto") return statistics.frame.integrator();
  const CounterMap& built = statistics.report.build_counters;
  if (built.count(kAutoChosePath) == 0) return nullptr;
  return counter(built, kAutoChosePath) == 1 ? "path" : "whitted";
}

}  // namespace

json statistics_json(const FrameStatistics& statistics) {
  const JobReport& report = statistics.report;
  const v1::FrameSettings& frame = statistics.frame;
  json result;
  result["version"] = kVersion;
  result["scene"] = statistics.scene_digest;
  result["width"] = statistics.width;
  result["height"] = statistics.height;
  result["samples_per_pixel"] = frame.samples_per_pixel();
  result["seed"] = frame.seed();
  result["integrator"] = frame.integrator();
  result["integrator_chosen"] = integrator_chosen(statistics);
  result["accelerator"] = frame.accelerator();
  result["seconds"] = {{"parse", statistics.seconds.parse}, {"build", report.build_seconds},
                       {"trace", report.trace_seconds},     {"assemble", report.assemble_seconds},
                       {"write", statistics.seconds.write}, {"total", statistics.seconds.total}};
  result["rays"] = rays_json(report.counters);
  for (const char* name : {"hits", "node_visits", "primitive_tests", "samples", "nan_samples",
                           "samples_beside_the_tile"}) {
    result[name] = counter(report.counters, name);
  }
  result["skips"] = skips_json(report.counters);
  result["built"] = json::object();
  for (const auto& [name, value] : report.build_counters) result["built"][name] = value;
  result["tiles"] = {{"total", report.tiles_total},
                     {"done", report.tiles_done},
                     {"restored", report.tiles_restored},
                     {"failed", report.holes.size()},
                     {"filled", report.filled},
                     {"split", report.split},
                     {"moved", report.moved},
                     {"retries", report.retries},
                     {"speculative", report.speculative},
                     {"duplicates", report.duplicates},
                     {"mismatches", report.mismatches},
                     {"verified", report.verified},
                     {"unverified", report.unverified},
                     {"retraced", report.retraced}};
  result["workers"] = {
      {"seen", report.workers_seen}, {"lost", report.workers_lost}, {"set_aside", report.liars}};
  result["bytes_shipped"] = report.bytes_scene + report.bytes_results;
  result["bytes"] = {{"scene", report.bytes_scene}, {"results", report.bytes_results}};
  result["peak_memory_bytes"] = std::max(peak_memory_bytes(), statistics.peak_worker_bytes);
  result["pixels_sha256"] = statistics.pixels_sha256;
  return result;
}

}  // namespace tessera
