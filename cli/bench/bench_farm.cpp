#include "cli/bench/bench_farm.h"

#include <fmt/format.h>
#include <signal.h>
#include <stdlib.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/plural.h"
#include "base/process.h"
#include "base/program_folder.h"
#include "base/temporary_folder.h"
#include "bench/error/statistics.h"
#include "cli/bench/bench_first_tile.h"
#include "cli/bench/bench_scene_transfer.h"
#include "cli/bench/bench_workers.h"
#include "cli/bench/timed_process.h"
#include "coordinator/coordinator.h"
#include "coordinator/render_loop.h"
#include "proto/transport/zmq_transport.h"
#include "proto/wire/frame.h"
#include "proto/wire/scene_codec.h"
#include "scenes/generate/generate_scene.h"

namespace tessera {
namespace {

using nlohmann::json;

std::string write_spheres(const TemporaryFolder& folder, int side) {
  const LoadedScene spheres = generate_scene(fmt::format("spheres:{}", side));
  std::string path = folder.file(fmt::format("spheres-{}.tesserab", side));
  write_scene_file(path, spheres.scene, spheres.blobs);
  return path;
}

json paired_row(const std::string& measure, double limit, int repeats,
                const std::function<double()>& ours, const std::function<double()>& reference) {
  ours();  // the first run pays for cold caches
  reference();
  std::vector<double> our_seconds, reference_seconds, ratios;
  for (int i = 0; i < repeats; ++i) {
    our_seconds.push_back(ours());
    reference_seconds.push_back(reference());
    ratios.push_back(our_seconds.back() / reference_seconds.back());
  }
  return {{"measure", measure},
          {"seconds", median(our_seconds)},
          {"reference_seconds", median(reference_seconds)},
          {"ratio", median(ratios)},
          {"limit", limit}};
}

json processes_row(const BenchFarmOptions& options, const TemporaryFolder& folder, int samples) {
  const std::string scene = options.scene.empty() ? write_spheres(folder, 12) : options.scene;
  const auto render = [&](int workers, int threads) {
    return timed_process({program_path(), "render", scene, "--quiet", "-o",
                          folder.file("frame.png"), "--size", "1920x1080", "--spp",
                          std::to_string(samples), "--workers", std::to_string(workers),
                          "--threads", std::to_string(threads)});
  };
  return paired_row(
      fmt::format("1080p frame, {}: {} against {}", counted(samples, "sample"),
                  counted(options.workers, "worker"), counted(options.workers, "thread")),
      1.03, options.repeats, [&] { return render(options.workers, 1); },
      [&] { return render(0, options.workers); });
}

json one_sphere_row(const BenchFarmOptions& options, const TemporaryFolder& folder) {
  const std::string scene = write_spheres(folder, 1);
  return paired_row(
      fmt::format("one sphere, 64x64, {} against oiiotool --version",
                  counted(options.workers, "worker")),
      1.15, options.repeats * 4,
      [&] {
        return timed_process({program_path(), "render", scene, "--quiet", "-o",
                              folder.file("one.png"), "--size", "64x64", "--workers",
                              std::to_string(options.workers)});
      },
      [] {
        return timed_process({"oiiotool", "--version"});
      });
}

/// Seconds from the start of a worker process to its hello, which grants credit for tiles.
double seconds_to_hello(const TemporaryFolder& folder) {
  const auto server = bind_server("ipc://" + folder.file("socket"));
  const auto start = std::chrono::steady_clock::now();
  const pid_t pid = start_process(program_path(),
                                  {program_path(), "worker", "--connect", server->endpoint(),
                                   "--threads", "1", "--parent", std::to_string(getpid())},
                                  {.discards_output = true});
  std::chrono::duration<double> taken{};
  for (bool ready = false; !ready;) {
    server->wait(std::chrono::milliseconds(100));
    taken = std::chrono::steady_clock::now() - start;
    if (taken > std::chrono::seconds(10)) throw render_error("a worker said no hello in 10 s");
    while (const auto message = server->receive()) {
      const auto envelope = decode(message->bytes, kMaxFrame);
      ready = ready || (envelope && envelope->has_hello() && envelope->hello().credit() > 0);
    }
  }
  kill(pid, SIGKILL);
  wait_for_process(pid);
  return taken.count();
}

json worker_row(const BenchFarmOptions& options, const TemporaryFolder& folder) {
  std::vector<double> seconds;
  for (int i = 0; i < options.repeats * 4; ++i) seconds.push_back(seconds_to_hello(folder));
  return {{"measure", "a worker is ready after its start"},
          {"seconds", median(seconds)},
          {"limit", 0.03}};
}

}  // namespace

const std::vector<std::string>& bench_farm_kinds() {
  static const std::vector<std::string> kinds{"frame", "sphere", "worker", "tile", "scene"};
  return kinds;
}

json bench_farm(const BenchFarmOptions& options) {
  const TemporaryFolder folder("tessera-bench");
  const std::vector<std::pair<std::string, std::function<json()>>> kinds{
      {"frame", [&] { return processes_row(options, folder, 16); }},
      {"frame", [&] { return processes_row(options, folder, 4); }},
      {"sphere", [&] { return one_sphere_row(options, folder); }},
      {"worker", [&] { return worker_row(options, folder); }},
      {"tile", [&] { return first_tile_row(options, folder.path()); }},
      {"scene", [&] { return scene_transfer_row(options, "tcp://127.0.0.1:*"); }},
      {"scene", [&] { return scene_transfer_row(options, "ipc://" + folder.file("transfer")); }}};
  json rows = json::array();
  for (const auto& [kind, row] : kinds) {
    if (options.only.empty() || options.only == kind) rows.push_back(row());
  }
  for (json& row : rows) {
    const double measured = row[row.contains("ratio") ? "ratio" : "seconds"];
    row["beyond_limit"] = measured > row["limit"].get<double>();
  }
  return rows;
}

}  // namespace tessera
