#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "base/error.h"
#include "bench/error/statistics.h"
#include "bench/studio/bench_rows.h"
#include "bench/studio/bench_scenes.h"
#include "bench/studio/script.h"

namespace tessera {
namespace {

using Json = nlohmann::json;

/// Milliseconds from a key to the first pixels of its version.
double time_key(PageClient& page, Script& script, int number) {
  page.forget();
  const Time begin = monotonic_now();
  script.type(number);
  page.receive({"pixels"}, of_version(script.version()));
  return milliseconds_since(begin);
}

void keys(const StudioBench& bench) {
  std::vector<double> all;
  std::map<std::string, std::vector<double>> spans;
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(bench.options.scenes))
    files.insert(entry.path().filename());
  for (const std::filesystem::path& file : files) {
    if (!std::set<std::string>{".tessera", ".crt", ".x3d", ".x3dv"}.contains(file.extension()))
      continue;
    PageClient page = show(bench.studio, file);
    Script script(page, file);
    if (!script.find_place(page.receive({"summary"})["digest"])) continue;
    std::vector<double> taken;
    for (int i = 0; i < bench.options.rounds; ++i) {
      taken.push_back(time_key(page, script, i));
      const Json job = page.receive({"job"}, [&](const Json& each) {
        return each.contains("ended") && of_version(script.version())(each);
      });
      for (const auto& [name, seconds] : job["times"].items())
        spans[name].push_back(1000 * seconds.get<double>());
      pause(150);
    }
    bench.add({"key to first pixels, " + file.string(),
               median(taken),
               "ms",
               {},
               {},
               fmt::format("p95 {:.0f}", percentile(taken, 0.95))});
    all.insert(all.end(), taken.begin(), taken.end());
  }
  if (all.empty()) {
    throw usage_error(fmt::format("{} has no scene whose numbers could be edited",
                                  bench.options.scenes.string()));
  }
  for (const auto& [name, taken] : spans) {
    bench.add({fmt::format("of that, {} (p50)", name),
               median(taken),
               "ms",
               {},
               {},
               fmt::format("p95 {:.1f}", percentile(taken, 0.95))});
  }
  bench.add({"key to first pixels, all scenes (p50)", median(all), "ms", 50});
  bench.add({"key to first pixels, all scenes (p95)", percentile(all, 0.95), "ms", 100});
}

void keys_beside_mesh(const StudioBench& bench) {
  PageClient page = show(bench.studio, kMesh);
  Script script(page, kMeshMaterials);
  script.take_place("Kd 0.5");
  std::string shown = page.receive({"summary"})["digest"];
  std::vector<double> taken;
  for (int i = 0; i < bench.options.rounds; ++i) {
    const Time begin = monotonic_now();
    script.type(i);
    // The version that is told is that of the scene's own file, which stays.
    shown = page.receive({"summary"},
                         [&](const Json& each) { return each["digest"] != shown; })["digest"];
    page.forget();
    const Json job = page.receive({"job"}, [](const Json& each) {
      return each["state"] == "tracing" && !each.contains("ended");
    });
    page.receive({"pixels"}, [&](const Json& each) { return each["serial"] >= job["serial"]; });
    taken.push_back(milliseconds_since(begin));
    pause(300);
  }
  bench.add({fmt::format("key in a .mtl beside {} triangles (p95)", bench.options.triangles),
             percentile(taken, 0.95),
             "ms",
             300,
             {},
             fmt::format("p50 {:.0f}", median(taken))});
}

/// Each picture asks for the next, as a hand that follows what it sees.
void orbit_in(const StudioBench& bench, const std::string& file) {
  PageClient page = show(bench.studio, file);
  std::vector<double> taken;
  int least = 1 << 16, most = 0;
  for (int i = 0; i < 4 * bench.options.rounds; ++i) {
    page.forget();
    Json view = view_of(file);
    view["moving"] = true;
    view["camera"] = {
        {"eye", {4 + 0.01 * i, -6, 3}}, {"target", {0, 0, 0}}, {"up", {0, 0, 1}}, {"fov", 40}};
    const Time begin = monotonic_now();
    page.say("view", view);
    const Json job = page.receive({"job"}, [](const Json& each) {
      return each["state"] == "tracing" && each.contains("serial") && !each.contains("ended");
    });
    const Json last = page.receive({"pixels"}, [&](const Json& each) {
      return each["serial"] >= job["serial"] && each["ends_pass"] == true;
    });
    taken.push_back(milliseconds_since(begin));
    const int side = std::max(last["width"].get<int>(), last["height"].get<int>());
    least = std::min(least, side);
    most = std::max(most, side);
  }
  taken.erase(taken.begin(),
              taken.begin() + bench.options.rounds);  // before it knows how fast it is
  const double mean =
      std::accumulate(taken.begin(), taken.end(), 0.0) / static_cast<double>(taken.size());
  bench.add({fmt::format("orbit of {}, movement to picture (p95)", file), percentile(taken, 0.95),
             "ms", 66});
  bench.add({fmt::format("orbit of {}, pictures", file),
             1000 / mean,
             "1/s",
             {},
             30,
             fmt::format("long side {} to {}", least, most)});
}

void orbit(const StudioBench& bench) {
  for (const char* file : {kLight, kEdited, kHeavy}) orbit_in(bench, file);
}

uint64_t nanoseconds_of_workers(const std::vector<int>& workers) {
  uint64_t sum = 0;
  for (const int worker : workers) sum += nanoseconds_of(worker);
  return sum;
}

void stop(const StudioBench& bench) {
  PageClient page = show(bench.studio, kHeavy);
  const std::vector<int> workers = bench.studio.workers();
  std::vector<double> taken;
  for (int i = 0; i < bench.options.rounds; ++i) {
    page.forget();
    Json view = view_of(kHeavy, 1920, 1080);
    view["overrides"] = {{"spp", 1024 + i}};
    page.say("view", view);
    page.receive({"job"}, [](const Json& each) {
      return each["state"] == "tracing" && !each.contains("ended");
    });
    pause(300);
    const Time begin = monotonic_now();
    Time last = begin;
    page.say("stop", {{"pane", 0}});
    for (uint64_t before = nanoseconds_of_workers(workers);
         monotonic_now() - last < std::chrono::milliseconds(100);) {
      const uint64_t now = nanoseconds_of_workers(workers);
      // What a poll of its socket takes is less than a tenth of the time between two looks.
      if (now - before > 200'000) last = monotonic_now();
      before = now;
      pause(2);
    }
    taken.push_back(1000 * to_seconds(last - begin));
  }
  bench.add({"stop, until no worker traces (p95)",
             percentile(taken, 0.95),
             "ms",
             20,
             {},
             fmt::format("p50 {:.0f}", median(taken))});
}

void pick(const StudioBench& bench) {
  PageClient page = show(bench.studio, kLight, true);
  std::vector<double> taken;
  for (int i = 0; i < 2 * bench.options.rounds; ++i) {
    const int x = 40 + (i * 67) % (kViewWidth - 80), y = 40 + (i * 41) % (kViewHeight - 80);
    const Time begin = monotonic_now();
    page.say("pick", {{"pane", 0}, {"x", x}, {"y", y}});
    page.receive({"picked"}, [&](const Json& each) { return each["x"] == x && each["y"] == y; });
    taken.push_back(milliseconds_since(begin));
  }
  bench.add({"pick (p95)",
             percentile(taken, 0.95),
             "ms",
             50,
             {},
             fmt::format("p50 {:.0f}", median(taken))});
}

/// Sets the radius of a ball again and again, as a hand that drags and follows what it sees.
void drag(const StudioBench& bench) {
  PageClient page = show(bench.studio, kDragged);
  page.say("open", {{"file", kDragged}});
  uint64_t version = page.receive({"document"})["version"];
  std::string entity;
  const Json outline = page.receive({"outline"});
  for (const Json& each : outline["entities"]) {
    if (each["kind"] == "shape") entity = each["id"];
  }
  if (entity.empty()) throw render_error("the outline of a scene with a shape has none");
  const Time begin = monotonic_now();
  const int moves = 4 * bench.options.rounds;
  for (int i = 0; i < moves; ++i) {
    page.forget();
    page.say("set", {{"file", kDragged},
                     {"base", version},
                     {"entity", entity},
                     {"field", "sphere.radius"},
                     {"text", fmt::format("{:.3f}", 0.51 + 0.01 * (i % 40))}});
    // The page's editor takes it up, as a step of its one history.
    const Json change = page.receive({"change"});
    page.say("edit", {{"file", kDragged}, {"base", version}, {"changes", change["changes"]}});
    ++version;
    page.receive({"pixels"}, of_version(version));
  }
  bench.add(
      {"property drag, pictures", moves / to_seconds(monotonic_now() - begin), "1/s", {}, 20});
}

}  // namespace

void add_view_rows(const StudioBench& bench) {
  bench.options.begin("keys");
  keys(bench);
  bench.options.begin("keys beside a mesh");
  keys_beside_mesh(bench);
  bench.options.begin("orbits");
  orbit(bench);
  bench.options.begin("stopping");
  stop(bench);
  bench.options.begin("picks");
  pick(bench);
  bench.options.begin("dragged properties");
  drag(bench);
}

}  // namespace tessera
