#include "front/tracing_farm.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "base/process.h"
#include "client/run_remote_job.h"
#include "coordinator/coordinator.h"
#include "coordinator/local_workers.h"
#include "coordinator/render_loop.h"
#include "coordinator/tev/tev_viewer.h"
#include "proto/transport/memory_transport.h"
#include "proto/transport/zmq_transport.h"
#include "proto/wire/shared_memory.h"
#include "renderer/render/tile_renderer.h"
#include "worker/run_worker.h"

namespace tessera {
namespace {

constexpr char kFrameIsDone[] = "the frame is done";
/// What a worker gets to end by itself before it is told by signal.
constexpr std::chrono::milliseconds kGrace{100};
constexpr Time kBetweenObservations = std::chrono::milliseconds(50);

LocalWorkerOptions worker_options(const LocalFarmOptions& farm) {
  LocalWorkerOptions options;
  options.count = farm.workers;
  options.threads = farm.threads;
  if (farm.quiet) options.extra_arguments = {"--quiet"};
  return options;
}

CoordinatorOptions coordinator_options(int expected_workers, double verify = 0) {
  CoordinatorOptions options;
  options.verify = verify;
  options.expected_workers = expected_workers;
  return options;
}

/// The high-water mark of a process's resident set; 0 if it has ended.
uint64_t peak_bytes_of(pid_t process) {
  std::ifstream status(fmt::format("/proc/{}/status", process));
  for (std::string line; std::getline(status, line);) {
    unsigned long long kibibytes = 0;
    if (std::sscanf(line.c_str(), "VmHWM: %llu kB", &kibibytes) == 1) return kibibytes * 1024;
  }
  return 0;
}

/// Tells which tiles of the frame that is traced became done, each once.
class TileWatch {
 public:
  void set(TileCallback done) { done_ = std::move(done); }
  /// A frame begins, whatever became of the one before.
  void begin() {
    tiles_.clear();
    told_.clear();
  }

  void look(Coordinator& coordinator, Time now) {
    if (!done_) return;
    for (const auto& [job, frame] : coordinator.running_frames()) {
      const auto film = coordinator.film(job, frame);
      if (!film) continue;
      NewTiles news{film->rect, film->channels, film->values, {}};
      const auto tiles = coordinator.tiles(job, frame, now);
      told_.resize(tiles.size());
      tiles_.clear();
      for (size_t i = 0; i < tiles.size(); ++i) {
        tiles_.push_back(tiles[i].rect);
        const bool is_done = tiles[i].state == TileSnapshot::State::done;
        if (is_done && !told_[i]) news.tiles.push_back(tiles[i].rect);
        told_[i] = is_done;
      }
      if (!news.tiles.empty()) done_(news);
    }
  }
  /// Tells of those that were done after the last look.
  void finish(const JobResult& result) {
    if (!done_ || result.report.tiles_done == 0) return;
    const Film& film = result.film;
    const std::vector<PixelRect>& holes = result.report.holes;
    NewTiles news{film.rect(), film.channels(), film.values(), {}};
    for (size_t i = 0; i < tiles_.size(); ++i) {
      const bool is_hole = std::find(holes.begin(), holes.end(), tiles_[i]) != holes.end();
      if (!told_[i] && !is_hole) news.tiles.push_back(tiles_[i]);
    }
    if (tiles_.empty() && holes.empty()) news.tiles.push_back(film.rect());
    if (!news.tiles.empty()) done_(news);
  }

 private:
  TileCallback done_;
  std::vector<PixelRect> tiles_;
  std::vector<bool> told_;  ///< by tile
};

class LocalFarm : public TracingFarm {
 public:
  explicit LocalFarm(const LocalFarmOptions& options)
      : workers_(worker_options(options)),
        loop_(bind_server(workers_.endpoint()),
              coordinator_options(options.workers * options.threads, options.verify)) {
    const std::filesystem::path socket = workers_.endpoint().substr(std::strlen("ipc://"));
    if (options.made_sockets) {
      options.made_sockets(socket.parent_path(), {socket.string(), socket.string() + ".bulk"});
    }
    loop_.watch(&workers_);
    if (!options.tev.empty()) tev_.emplace(options.tev);
    loop_.observe(
        [this](Coordinator& coordinator, Time now) {
          if (tev_) tev_->look(coordinator, now);
          watch_.look(coordinator, now);
        },
        kBetweenObservations);
    workers_.start();
  }
  ~LocalFarm() override {
    dismiss();
    workers_.stop(kGrace);
  }

  JobResult run(JobSpec job, const ProgressCallback& progress,
                const std::atomic<bool>& stop) override {
    watch_.begin();
    JobResult result = loop_.run(std::move(job), progress, stop, tiles_);
    if (tev_) tev_->finish(result.film);
    watch_.finish(result);
    return result;
  }
  void keep_tiles(std::shared_ptr<TileStore> tiles) override { tiles_ = std::move(tiles); }
  bool attend() override {
    loop_.attend();
    return true;
  }
  void wake() override { loop_.wake(); }
  void watch_tiles(TileCallback done) override { watch_.set(std::move(done)); }
  void share(BlobStore& blobs) const override { share_large_blobs(blobs); }
  uint64_t peak_worker_bytes() const override {
    uint64_t peak = 0;
    for (const pid_t worker : workers_.processes()) peak = std::max(peak, peak_bytes_of(worker));
    return peak;
  }
  void dismiss() override {
    if (std::exchange(dismissed_, true)) return;
    loop_.shut_down(kFrameIsDone);
    // Those that were so late that the coordinator does not know them yet hear of it by signal.
    for (const pid_t worker : workers_.processes()) kill(worker, SIGTERM);
  }

 private:
  LocalWorkers workers_;
  std::optional<TevViewer> tev_;
  TileWatch watch_;
  RenderLoop loop_;
  std::shared_ptr<TileStore> tiles_;
  bool dismissed_ = false;
};

class InProcessFarm : public TracingFarm {
 public:
  /// A thread of this process is never gone, however long it waits for a core.
  static CoordinatorOptions in_process_options(int threads) {
    CoordinatorOptions options = coordinator_options(threads);
    options.lost_after = options.suspect_after = std::chrono::hours(24);
    return options;
  }

  explicit InProcessFarm(int threads)
      : loop_(network_.server(), in_process_options(threads)),
        worker_([this, threads, client = network_.client()] {
          WorkerOptions options;
          options.threads = threads;
          // Its coordinator is silent while this process reads the next frame, or writes the last.
          options.orphan_timeout = Time::max();
          options.make_renderer = [this](const auto&... scene) {
            return make_tile_renderer(scene..., Sharing{.arena = nullptr, .live = &trees_});
          };
          options.at_hand = [this](const Digest& digest) { return blob_at_hand(digest); };
          try {
            run_worker(*client, options, stop_);
          } catch (...) {
            failure_ = std::current_exception();
            has_failed_ = true;
          }
        }) {
    loop_.observe(
        [this](Coordinator& coordinator, Time now) {
          if (has_failed_) std::rethrow_exception(failure_);
          watch_.look(coordinator, now);
        },
        kBetweenObservations);
  }
  ~InProcessFarm() override {
    try {
      dismiss();
    } catch (const std::bad_alloc&) {
      stop_ = true;
    }
    worker_.join();
  }

  JobResult run(JobSpec job, const ProgressCallback& progress,
                const std::atomic<bool>& stop) override {
    {
      const std::lock_guard lock(mutex_);
      blobs_ = job.blobs;
    }
    watch_.begin();
    JobResult result = loop_.run(std::move(job), progress, stop, tiles_);
    watch_.finish(result);
    return result;
  }
  void dismiss() override {
    if (std::exchange(dismissed_, true)) return;
    // In this order: a worker that has left already would be told of as lost.
    loop_.shut_down(kFrameIsDone);
    stop_ = true;
    const std::lock_guard lock(mutex_);
    blobs_ = {};
  }
  void watch_tiles(TileCallback done) override { watch_.set(std::move(done)); }
  void keep_tiles(std::shared_ptr<TileStore> tiles) override { tiles_ = std::move(tiles); }
  bool attend() override {
    loop_.attend();
    return true;
  }
  void wake() override { loop_.wake(); }

 private:
  BlobData blob_at_hand(const Digest& digest) {
    const std::lock_guard lock(mutex_);
    return blobs_.find(digest);
  }

  std::mutex mutex_;
  BlobStore blobs_;  ///< of the job; the worker has them from here
  WeakCache trees_;
  MemoryNetwork network_;
  TileWatch watch_;
  RenderLoop loop_;
  std::shared_ptr<TileStore> tiles_;
  std::atomic<bool> stop_{false};
  std::exception_ptr failure_;  ///< what ended the worker, as where memory is short
  std::atomic<bool> has_failed_{false};
  bool dismissed_ = false;
  std::thread worker_;
};

class RemoteFarm : public TracingFarm {
 public:
  explicit RemoteFarm(const FarmConnection& connection)
      : endpoint_(connection.endpoint),
        patience_(connection.patience),
        transport_(connect(connection)) {}

  JobResult run(JobSpec job, const ProgressCallback& progress,
                const std::atomic<bool>& stop) override {
    return run_remote_job(*transport_, endpoint_, job, progress, stop, patience_, tiles_);
  }
  void watch_tiles(TileCallback done) override { tiles_ = std::move(done); }

 private:
  std::string endpoint_;
  Time patience_;
  std::unique_ptr<ClientTransport> transport_;
  TileCallback tiles_;
};

}  // namespace

std::unique_ptr<TracingFarm> start_local_workers(const LocalFarmOptions& options) {
  check_room_for_threads(kTransportThreads);
  return std::make_unique<LocalFarm>(options);
}

std::unique_ptr<TracingFarm> start_in_process(int threads) {
  check_room_for_threads(threads + 1);
  return std::make_unique<InProcessFarm>(threads);
}

std::unique_ptr<TracingFarm> connect_to_farm(const FarmConnection& connection) {
  check_room_for_threads(kTransportThreads);
  return std::make_unique<RemoteFarm>(connection);
}

}  // namespace tessera
