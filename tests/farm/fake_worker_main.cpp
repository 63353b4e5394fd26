// A real worker process that traces the fake renderer: what LocalWorkers starts in tests.
#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <thread>

#include "base/process.h"
#include "proto/transport/zmq_transport.h"
#include "tests/farm/fake_renderer.h"
#include "worker/run_worker.h"

namespace {

using namespace tessera;

/// Takes its time, so that tests can do something to it meanwhile. Tile row 0 may be deadly, and a
/// pixel of each tile a lie.
class SlowRenderer : public TileRenderer {
 public:
  SlowRenderer(uint32_t seed, int milliseconds, bool deadly, bool lies)
      : fake_(seed), milliseconds_(milliseconds), deadly_(deadly), lies_(lies) {}
  std::optional<TilePixels> render(const RenderTask& task, TileProgress& progress) const override {
    if (deadly_ && task.rect.x0 == 0 && task.rect.y0 == 0) std::abort();
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds_));
    auto pixels = fake_.render(task, progress);
    if (pixels && lies_) pixels->values[pixels->values.size() / 2] += 1;
    return pixels;
  }
  CounterMap build_counters() const override { return {}; }

 private:
  tessera::testing::FakeRenderer fake_;
  int milliseconds_;
  bool deadly_, lies_;
};

}  // namespace

int main(int argc, char** argv) {
  std::map<std::string, std::string> options;
  for (int i = 2; i + 1 < argc; i += 2) options[argv[i]] = argv[i + 1];
  if (options.contains("--fail")) return 9;
  if (!die_with_parent(std::atoi(options["--parent"].c_str()))) return 8;
  // The first to come stops before its hello.
  if (options.contains("--stop-once") && !std::filesystem::exists(options["--stop-once"])) {
    std::ofstream(options["--stop-once"]) << getpid();
    raise(SIGSTOP);
  }
  lower_priority(std::atoi(options["--nice"].c_str()));
  if (options.contains("--stop-always")) raise(SIGSTOP);
  WorkerOptions worker;
  worker.threads = std::atoi(options["--threads"].c_str());
  const int pause = std::atoi(options["--pause"].c_str());
  // The first to come lies.
  bool lies = false;
  if (options.contains("--lie-once")) {
    const int file = open(options["--lie-once"].c_str(), O_CREAT | O_EXCL | O_WRONLY, 0600);
    lies = file >= 0;
    if (lies) close(file);
  }
  const bool deadly = options.contains("--deadly");
  const bool crashes = options.contains("--crash-building");
  worker.make_renderer = [=](const v1::Scene&, const BlobStore&, const v1::FrameSettings& frame,
                             int) {
    if (crashes) std::abort();
    return std::make_shared<SlowRenderer>(frame.seed(), pause, deadly, lies);
  };
  const auto transport = connect_client(options["--connect"]);
  const std::atomic<bool> never{false};
  return static_cast<int>(run_worker(*transport, worker, never).exit_code);
}
