// How fast one core gives out tiles: the real Coordinator, with so many workers that are played, no
// sockets, no tracing.
//   farm_scheduler_bench [WORKERS [TILES]]
#include <malloc.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <string>
#include <vector>

#include "base/process_usage.h"
#include "coordinator/coordinator.h"
#include "proto/wire/pixels.h"
#include "tests/farm/frame_names.h"
#include "tests/farm/played_hello.h"

namespace tessera {
namespace {

/// Seconds that this thread has computed: others on the machine do not count.
double computed() { return std::chrono::duration<double>(thread_time()).count(); }

constexpr int kTile = 8;

class Bench {
 public:
  Bench(uint64_t workers, int tiles) : workers_(workers) {
    const size_t before = mallinfo2().uordblks;
    for (uint64_t id = 1; id <= workers; ++id) say(id, testing::played_hello(id));
    JobSpec job;
    constexpr int kColumns = 512;
    const int width = kColumns * kTile, height = (tiles + kColumns - 1) / kColumns * kTile;
    job.frame.set_width(static_cast<uint32_t>(width));
    job.frame.set_height(static_cast<uint32_t>(height));
    job.frame.set_samples_per_pixel(1);
    job.crop = {0, 0, width, height};
    job.tile_size = kTile;
    const size_t without_job = mallinfo2().uordblks;
    id_ = coordinator_.submit(std::move(job), now_);
    collect();
    for (uint64_t id = 1; id <= workers; ++id) {
      v1::Envelope message;
      message.mutable_scene_ready()->set_session(1);
      message.mutable_scene_ready()->set_job(frame_);
      say(id, message);
    }
    worker_bytes_ = without_job - before;
  }

  void run() {
    while (!assigned_.empty() && !coordinator_.take_result(id_)) {
      const auto [worker, assign] = std::move(assigned_.front());
      assigned_.pop_front();
      const size_t before = given_;
      const double seconds = say(worker, band(assign));
      if (given_ > before) latencies_.push_back(seconds);
      now_ += std::chrono::microseconds(10);
      if (now_ >= next_tick_) tick();
    }
  }

  void print() {
    std::sort(latencies_.begin(), latencies_.end());
    const auto at = [this](double share) {
      const auto place = static_cast<size_t>(share * static_cast<double>(latencies_.size() - 1));
      return latencies_.empty() ? 0 : latencies_[place] * 1e6;
    };
    std::printf(
        "{\"workers\": %llu, \"assignments\": %zu, \"assignments_per_second\": %.0f, "
        "\"median_microseconds\": %.1f, \"p99_microseconds\": %.1f, \"most_microseconds\": %.1f, "
        "\"bytes_per_worker\": %zu}\n",
        static_cast<unsigned long long>(workers_), given_, static_cast<double>(given_) / spent_,
        at(0.5), at(0.99), at(1), worker_bytes_ / workers_);
  }

 private:
  static v1::Envelope band(const v1::Assign& assign) {
    const int rows = assign.rect().y1() - assign.rect().y0();
    const std::vector<float> values(static_cast<size_t>(rows) * kTile * 3, 0.5f);
    v1::Envelope message;
    v1::TileBand& band = *message.mutable_tile_band();
    band = encode_bands(values, kTile, assign.rect().y0(), false)[0];
    band.set_session(1);
    band.set_job(assign.job());
    band.set_lease(assign.lease());
    band.set_tile(assign.tile());
    band.set_trace_microseconds(5000 + 100 * (assign.tile() % 50));
    (*band.mutable_counters()->mutable_values())["rays_primary"] = 64;
    return message;
  }

  /// Seconds that the coordinator took.
  double say(uint64_t worker, v1::Envelope message) {
    names_.complete(message);
    const double start = computed();
    coordinator_.on_message(Channel::control, std::to_string(worker), message, now_);
    collect();
    const double seconds = computed() - start;
    spent_ += seconds;
    return seconds;
  }

  void collect() {
    for (OutgoingMessage& out : coordinator_.take_outgoing()) {
      names_.note(out.message);
      if (out.message.has_job_start()) frame_ = out.message.job_start().job();
      if (!out.message.has_assign()) continue;
      ++given_;
      assigned_.emplace_back(std::stoull(out.peer), std::move(*out.message.mutable_assign()));
    }
  }

  void tick() {
    const double start = computed();
    coordinator_.on_tick(now_);
    collect();
    spent_ += computed() - start;
    next_tick_ = now_ + std::chrono::milliseconds(100);
    // Each worker's heart beats once a second.
    std::vector<v1::Heartbeat> hearts(workers_);
    for (const auto& [worker, assign] : assigned_) {
      auto& progress = *hearts[worker - 1].add_progress();
      progress.set_job(assign.job());
      progress.set_lease(assign.lease());
      progress.set_work_done(++work_);
    }
    for (uint64_t id = 1 + ticks_++ % 10; id <= workers_; id += 10) {
      v1::Envelope message;
      v1::Heartbeat& heart = *message.mutable_heartbeat();
      heart = std::move(hearts[id - 1]);
      heart.set_session(1);
      heart.add_jobs()->set_job(frame_);
      heart.mutable_jobs(0)->set_ready(true);
      say(id, message);
    }
  }

  uint64_t workers_;
  Coordinator coordinator_{CoordinatorOptions{}};
  testing::FrameNames names_;
  uint64_t id_ = 0, frame_ = 0, work_ = 0, ticks_ = 0;
  Time now_ = std::chrono::seconds(1), next_tick_ = now_;
  std::deque<std::pair<uint64_t, v1::Assign>> assigned_;
  size_t given_ = 0, worker_bytes_ = 0;
  double spent_ = 0;
  std::vector<double> latencies_;
};

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::off);
  const uint64_t workers = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 5000;
  const int tiles = argc > 2 ? std::atoi(argv[2]) : 200000;
  if (workers == 0 || tiles <= 0) return 2;
  tessera::Bench bench(workers, tiles);
  bench.run();
  bench.print();
  return 0;
}
