#include "cli/bench/bench_first_tile.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "base/error.h"
#include "base/monotonic.h"
#include "base/plural.h"
#include "base/process.h"
#include "base/program_folder.h"
#include "bench/error/statistics.h"
#include "cli/bench/bench_workers.h"
#include "coordinator/render_loop.h"
#include "coordinator/store/sqlite_job_store.h"
#include "coordinator/web/farm_page.h"
#include "coordinator/web/png_file.h"
#include "proto/transport/zmq_transport.h"

namespace tessera {
namespace {

constexpr Time kPatience = std::chrono::seconds(60);

void write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw render_error(fmt::format("'{}' cannot be written", path));
}

/// A hilly field of some 100,000 triangles under a picture of 1024x1024, as files that come from
/// elsewhere.
std::string write_hills(const std::string& folder) {
  constexpr int kSide = 224, kTexels = 1024;
  std::string corners, faces;
  for (int j = 0; j <= kSide; ++j) {
    for (int i = 0; i <= kSide; ++i) {
      const double u = i / double{kSide}, v = j / double{kSide};
      corners += fmt::format("v {:.5f} {:.5f} {:.5f}\nvt {:.5f} {:.5f}\n", 2 * u - 1,
                             0.15 * std::sin(14 * u) * std::cos(18 * v), 2 * v - 1, u, v);
      if (i == kSide || j == kSide) continue;
      const int a = j * (kSide + 1) + i + 1, b = a + 1, c = a + kSide + 1, d = c + 1;
      faces += fmt::format("f {0}/{0} {2}/{2} {3}/{3}\nf {0}/{0} {3}/{3} {1}/{1}\n", a, b, c, d);
    }
  }
  PreviewImage texture{kTexels, kTexels, {}, 0, {}};
  for (int y = 0; y < kTexels; ++y) {
    for (int x = 0; x < kTexels; ++x) {
      for (const int value : {x * y / 37, x ^ y, x + 3 * y}) {
        texture.rgb.push_back(static_cast<uint8_t>(value & 255));
      }
    }
  }
  write_file(folder + "/hills.png", png_file(texture));
  write_file(folder + "/hills.mtl", "newmtl ground\nKd 1 1 1\nmap_Kd hills.png\n");
  write_file(folder + "/hills.obj", "mtllib hills.mtl\nusemtl ground\n" + corners + faces);
  return folder + "/hills.obj";
}

/// The answer to a GET of the page's server at 127.0.0.1:PORT.
std::string fetch(const std::string& address, const std::string& path) {
  const int line = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  const std::string request =
      fmt::format("GET /api/v1/{} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n", path);
  std::string answer;
  if (connect(line, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 &&
      send(line, request.data(), request.size(), MSG_NOSIGNAL) > 0) {
    std::vector<char> part(1 << 16);
    for (ssize_t count = 0; (count = recv(line, part.data(), part.size(), 0)) > 0;) {
      answer.append(part.data(), static_cast<size_t>(count));
    }
  }
  close(line);
  return answer;
}

/// How many tiles a picture has, by its tag "JOB-FRAME-TILES-...".
int tiles_pictured(const std::string& answer) {
  int job = 0, frame = 0, tiles = 0;
  const size_t tag = answer.find("ETag: ");
  if (!answer.starts_with("HTTP/1.1 200") || tag == std::string::npos) return 0;
  return std::sscanf(&answer[tag], "ETag: \"%d-%d-%d-", &job, &frame, &tiles) == 3 ? tiles : 0;
}

void wait_until(const std::function<bool()>& come, const char* what) {
  const Time end = monotonic_now() + kPatience;
  while (!come()) {
    if (monotonic_now() > end) throw render_error(fmt::format("{} in 60 s", what));
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

/// What `tessera serve --store --http` is, in a thread.
class PagedFarm {
 public:
  explicit PagedFarm(const std::string& folder)
      : page_({.address = "127.0.0.1:0", .token_file = {}, .has_keys = false, .stopping = &stop_}),
        loop_(bind_server("tcp://127.0.0.1:*"), {},
              std::make_shared<SqliteJobStore>(folder + "/store")) {
    loop_.observe([this](Coordinator& coordinator, Time now) { page_.look(coordinator, now); },
                  std::chrono::milliseconds(20));
    thread_ = std::thread([this] { loop_.serve(stop_); });
  }
  ~PagedFarm() {
    stop_ = true;
    thread_.join();
  }
  PagedFarm(const PagedFarm&) = delete;
  PagedFarm& operator=(const PagedFarm&) = delete;
  std::string endpoint() const { return loop_.endpoint(); }
  std::string address() const { return page_.address(); }

 private:
  std::atomic<bool> stop_{false};
  FarmPage page_;
  RenderLoop loop_;
  std::thread thread_;
};

}  // namespace

nlohmann::json first_tile_row(const BenchFarmOptions& options, const std::string& folder) {
  const std::string scene = options.scene.empty() ? write_hills(folder) : options.scene;
  const PagedFarm farm(folder);
  const BenchWorkers workers(farm.endpoint(), options.workers);
  std::vector<double> seconds;
  // The first one is the one by which the farm comes to know the scene.
  for (int job = 1; job <= 1 + 4 * options.repeats; ++job) {
    const Time start = monotonic_now();
    const pid_t submit =
        start_process(program_path(),
                      {program_path(), "submit", scene, "--quiet", "--connect", farm.endpoint(),
                       "--size", "1920x1080", "--spp", "4", "--seed", std::to_string(job)},
                      {.discards_output = true});
    wait_until(
        [&] {
          return tiles_pictured(fetch(farm.address(), fmt::format("jobs/{}/preview.png", job))) > 0;
        },
        "no picture of a job came");
    if (job > 1) seconds.push_back(to_seconds(monotonic_now() - start));
    wait_for_process(submit);
    wait_until(
        [&] {
          return fetch(farm.address(), fmt::format("jobs/{}", job)).find("\"state\":\"done\"") !=
                 std::string::npos;
        },
        "a job did not end");
  }
  return {{"measure", fmt::format("first tile on the page after submit, scene known, {}",
                                  counted(options.workers, "worker"))},
          {"seconds", median(seconds)},
          {"slowest_seconds", *std::max_element(seconds.begin(), seconds.end())},
          {"limit", 0.3}};
}

}  // namespace tessera
