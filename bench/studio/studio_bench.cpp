#include "bench/studio/studio_bench.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <thread>

#include "base/error.h"
#include "base/temporary_folder.h"
#include "bench/studio/bench_rows.h"
#include "bench/studio/bench_scenes.h"

namespace tessera {

double milliseconds_since(Time begin) { return 1000 * to_seconds(monotonic_now() - begin); }

void pause(int milliseconds) {
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
}

nlohmann::json view_of(const std::string& file, int width, int height) {
  return {{"pane", 0}, {"file", file}, {"size", {width, height}}};
}

PageClient show(const StudioProcess& studio, const std::string& file, bool whole) {
  PageClient page(studio);
  page.receive({"welcome"});
  page.say("view", view_of(file));
  page.receive({"pixels"},
               [=](const nlohmann::json& each) { return !whole || each["is_last"] == true; });
  return page;
}

void bench_studio(const StudioBenchOptions& options,
                  const std::function<void(const StudioBenchRow&)>& add) {
  for (const char* name : {kHeavy, kFull, kLight}) {
    if (std::filesystem::is_regular_file(options.scenes / name)) continue;
    throw usage_error(
        fmt::format("there is no {} in '{}'; expected the folder of Tessera's samples", name,
                    options.scenes.string()));
  }
  const TemporaryFolder temporary("tessera-bench");
  for (const char* name : {"HOME", "XDG_STATE_HOME", "XDG_CONFIG_HOME"}) {
    setenv(name, temporary.path().c_str(), 1);
  }
  const std::filesystem::path folder = temporary.path() / "scenes";
  std::filesystem::copy(options.scenes, folder, std::filesystem::copy_options::recursive);
  write_bench_scenes(folder, options.triangles);
  const StudioProcess studio(folder, options.check);
  const StudioBench bench{options, folder, add, studio};
  add_view_rows(bench);
  add_lasting_rows(bench);
  if (!options.browser.empty()) add_browser_rows(bench);
}

}  // namespace tessera
