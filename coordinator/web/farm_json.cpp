#include "coordinator/web/farm_json.h"

#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "base/version.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

const char* name_of(FarmSnapshot::JobState state) {
  constexpr std::array kNames = {"queued", "running", "paused",   "held",
                                 "done",   "failed",  "cancelled"};
  return kNames[static_cast<size_t>(state)];
}

const char* name_of(FarmSnapshot::WorkerState state) {
  constexpr std::array kNames = {"active", "suspect", "lost"};
  return kNames[static_cast<size_t>(state)];
}

bool has_ended(FarmSnapshot::JobState state) {
  return state == FarmSnapshot::JobState::done || state == FarmSnapshot::JobState::failed ||
         state == FarmSnapshot::JobState::cancelled;
}

/// With no more digits than a page needs.
double rounded(double value) { return std::round(value * 1e4) / 1e4; }

Json to_json(const FarmSnapshot::Job& job) {
  Json json{{"id", job.id},
            {"name", job.name},
            {"state", name_of(job.state)},
            {"priority", job.priority},
            {"weight", job.weight},
            {"width", job.width},
            {"height", job.height},
            {"frames_done", job.frames_done},
            {"frames_total", job.frames_total},
            {"frames_running", job.frames_running},
            {"tiles_done", job.tiles_done},
            {"tiles_total", job.tiles_total},
            {"tiles_restored", job.tiles_restored},
            {"elapsed_seconds", rounded(job.elapsed_seconds)},
            {"remaining_seconds", nullptr},
            {"worker_seconds", rounded(job.worker_seconds)},
            {"exit_code", nullptr},
            {"waits_for", nullptr},
            {"failure", job.failure}};
  if (!job.waits_for.empty()) json["waits_for"] = job.waits_for;
  if (has_ended(job.state)) json["exit_code"] = job.exit_code;
  if (job.remaining_seconds >= 0) json["remaining_seconds"] = rounded(job.remaining_seconds);
  return json;
}

Json to_json(const FarmSnapshot::Worker& worker) {
  return {{"id", std::to_string(worker.id)},
          {"name", worker.name},
          {"state", name_of(worker.state)},
          {"threads", worker.threads},
          {"credit", worker.credit},
          {"tiles_held", worker.tiles_held},
          {"scenes", worker.scenes},
          {"tiles_done", worker.tiles_done},
          {"tile_seconds", rounded(worker.tile_seconds)},
          {"bytes_results", worker.bytes_results},
          {"resident_bytes", worker.resident_bytes},
          {"failures", worker.failures},
          {"silent_seconds", rounded(worker.silent_seconds)},
          {"connected_seconds", rounded(worker.connected_seconds)}};
}

Json to_json(const FarmSnapshot::Counters& counters) {
  return {{"tiles_done", counters.tiles_done},
          {"tiles_restored", counters.tiles_restored},
          {"tiles_given_up", counters.tiles_given_up},
          {"retries", counters.retries},
          {"speculative", counters.speculative},
          {"duplicates", counters.duplicates},
          {"mismatches", counters.mismatches},
          {"workers_seen", counters.workers_seen},
          {"workers_lost", counters.workers_lost},
          {"workers_set_aside", counters.workers_set_aside},
          {"bytes_scene", counters.bytes_scene},
          {"bytes_results", counters.bytes_results},
          {"jobs_accepted", counters.jobs_accepted},
          {"tile_seconds", rounded(counters.tile_seconds.sum)}};
}

template <typename Things>
Json list_of(const Things& things) {
  Json list = Json::array();
  for (const auto& thing : things) list.push_back(to_json(thing));
  return list;
}

}  // namespace

std::string jobs_json(const FarmSnapshot& snapshot) {
  return text_of({{"jobs", list_of(snapshot.jobs)}});
}

std::string workers_json(const FarmSnapshot& snapshot) {
  return text_of({{"workers", list_of(snapshot.workers)}});
}

std::string job_json(const FarmSnapshot::Job& job) { return text_of(to_json(job)); }

std::string farm_json(const FarmSnapshot& snapshot) {
  return text_of({{"version", kVersion},
                  {"farm", std::to_string(snapshot.farm)},
                  {"opening", snapshot.opening},
                  {"uptime_seconds", rounded(snapshot.uptime_seconds)},
                  {"store_trouble", snapshot.store_trouble},
                  {"counters", to_json(snapshot.counters)},
                  {"jobs", list_of(snapshot.jobs)},
                  {"workers", list_of(snapshot.workers)}});
}

std::string history_json(const std::vector<FarmSample>& history) {
  Json json;
  const auto column = [&](const char* name, auto member) {
    Json& values = json[name] = Json::array();
    for (const FarmSample& sample : history) {
      if constexpr (std::is_same_v<decltype(member), double FarmSample::*>) {
        values.push_back(rounded(sample.*member));
      } else {
        values.push_back(sample.*member);
      }
    }
  };
  column("at", &FarmSample::at);
  column("tiles_per_second", &FarmSample::tiles_per_second);
  column("result_bytes_per_second", &FarmSample::result_bytes_per_second);
  column("workers", &FarmSample::workers);
  column("threads", &FarmSample::threads);
  column("tiles_held", &FarmSample::tiles_held);
  column("coordinator_bytes", &FarmSample::coordinator_bytes);
  column("worker_bytes", &FarmSample::worker_bytes);
  return text_of(json);
}

std::string tiles_json(uint64_t job, uint32_t frame, const FrameShown& shown) {
  std::map<uint64_t, size_t> workers;
  Json names = Json::array();
  const auto place_of = [&](uint64_t worker) -> int64_t {
    if (worker == 0) return -1;
    const auto [it, is_new] = workers.try_emplace(worker, workers.size());
    if (is_new) names.push_back(std::to_string(worker));
    return static_cast<int64_t>(it->second);
  };
  Json rows = Json::array();
  for (size_t i = 0; i < shown.tiles.size(); ++i) {
    const TileSnapshot& tile = shown.tiles[i];
    const bool pictured = shown.pictured && i < shown.pictured->size() && (*shown.pictured)[i];
    rows.push_back({tile.rect.x0, tile.rect.y0, tile.rect.x1, tile.rect.y1,
                    static_cast<int>(tile.state), place_of(tile.worker), rounded(tile.seconds),
                    tile.copies, pictured ? 1 : 0});
  }
  Json preview;
  if (const PreviewImage* image = shown.preview.get()) {
    preview = {{"width", image->width},
               {"height", image->height},
               {"rect", {image->rect.x0, image->rect.y0, image->rect.x1, image->rect.y1}},
               {"tiles_done", image->tiles_done}};
  }
  return text_of(
      {{"job", job},
       {"frame", frame},
       {"number", shown.number},
       {"states", {"pending", "assigned", "done", "given_up"}},
       {"columns", {"x0", "y0", "x1", "y1", "state", "worker", "seconds", "copies", "pictured"}},
       {"workers", std::move(names)},
       {"preview", std::move(preview)},
       {"tiles", std::move(rows)}});
}

}  // namespace tessera
