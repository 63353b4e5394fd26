#include "cli/bench/bench_scene_transfer.h"

#include <fmt/format.h>

#include <atomic>
#include <barrier>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "base/error.h"
#include "base/monotonic.h"
#include "base/plural.h"
#include "coordinator/render_loop.h"
#include "proto/transport/zmq_transport.h"
#include "scenes/generate/generate_scene.h"
#include "worker/run_worker.h"

namespace tessera {
namespace {

/// Workers that build nothing: each waits until all have the scene, and fails then.
class Receivers {
 public:
  Receivers(const std::string& endpoint, int count) : all_have_it_(count, NoteTime{&arrived_}) {
    for (int i = 0; i < count; ++i) threads_.emplace_back([this, endpoint] { receive(endpoint); });
  }
  ~Receivers() {
    stop_ = true;
    for (std::thread& thread : threads_) thread.join();
  }
  Receivers(const Receivers&) = delete;
  Receivers& operator=(const Receivers&) = delete;

  /// When the last scene had come to all.
  Time arrived() const { return arrived_; }

 private:
  struct NoteTime {
    std::atomic<Time>* when;
    void operator()() noexcept { *when = monotonic_now(); }
  };

  void receive(const std::string& endpoint) {
    const auto transport = connect_client(endpoint);
    WorkerOptions options;
    options.shares_memory = endpoint.starts_with("ipc://");
    options.make_renderer = [this](const auto&...) -> std::shared_ptr<const TileRenderer> {
      all_have_it_.arrive_and_wait();
      throw render_error("the scene has come");
    };
    run_worker(*transport, options, stop_);
  }

  std::atomic<Time> arrived_{};
  std::barrier<NoteTime> all_have_it_;
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

}  // namespace

nlohmann::json scene_transfer_row(const BenchFarmOptions& options, const std::string& endpoint) {
  const LoadedScene loaded = generate_scene(fmt::format("uvsphere:{}", options.rings));
  uint64_t bytes = 0;
  for (const auto& [digest, data] : loaded.blobs.all()) bytes += data->size();
  bytes *= static_cast<uint64_t>(options.workers);
  JobSpec job{.scene = loaded.scene, .blobs = loaded.blobs, .frame = {}, .crop = {0, 0, 8, 8}};
  job.frame.set_width(8);
  job.frame.set_height(8);
  job.frame.set_samples_per_pixel(1);
  const std::atomic<bool> never{false};
  RenderLoop loop(bind_server(endpoint), {});
  const Receivers receivers(loop.endpoint(), options.workers);
  const Time began = monotonic_now();
  loop.run(job, nullptr, never);
  const double seconds = to_seconds(receivers.arrived() - began);
  job.frame.set_seed(1);
  const JobResult again = loop.run(job, nullptr, never);
  loop.shut_down("it is measured");
  const double gigabytes = static_cast<double>(bytes) * 1e-9;
  const bool by_messages = endpoint.starts_with("tcp://");
  return {{"measure", fmt::format("a scene to {} by {}, {:.2f} GB in all, against 1 GB/s",
                                  counted(options.workers, "worker"),
                                  by_messages ? "TCP" : "shared memory", gigabytes)},
          {"seconds", seconds},
          {"reference_seconds", gigabytes},
          {"ratio", seconds / gigabytes},
          {"limit", 1.0},
          {"bytes_of_second_job", again.report.bytes_scene}};
}

}  // namespace tessera
