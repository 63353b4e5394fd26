// How long a frame takes on a farm of played workers of one thread each, under a simulated clock:
// what scheduling costs, whatever machine this runs on.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "coordinator/coordinator.h"
#include "job/tile_grid.h"
#include "proto/wire/pixels.h"
#include "tests/farm/frame_names.h"
#include "tests/farm/played_hello.h"

namespace tessera::testing {
namespace {

using std::chrono::hours;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr int kTile = 16;
/// One way between coordinator and worker.
constexpr Time kLatency = microseconds(200);

Time time_of(double count) { return Time(static_cast<int64_t>(count * 1e9)); }

class Farm {
 public:
  using Cost = std::function<double(int x, int y)>;  ///< seconds of the tile in that cell

  Farm(CoordinatorOptions options, std::vector<double> speeds, Cost cost)
      : coordinator_(std::move(options)), cost_(std::move(cost)) {
    spdlog::set_level(spdlog::level::off);
    for (size_t i = 0; i < speeds.size(); ++i) workers_[i + 1].speed = speeds[i];
  }

  /// Seconds from the first assignment to the end of a frame of `side` x `side` tiles.
  double render(int side) {
    JobSpec job;
    job.frame.set_width(static_cast<uint32_t>(side * kTile));
    job.frame.set_height(static_cast<uint32_t>(side * kTile));
    job.frame.set_samples_per_pixel(1);
    job.frame.set_seed(++frames_);
    job.crop = {0, 0, side * kTile, side * kTile};
    job.tile_size = kTile;
    for (auto& [id, worker] : workers_) {
      if (frames_ == 1) say(id, played_hello(id));
    }
    const uint64_t id = coordinator_.submit(std::move(job), now_);
    deliver();
    const Time start = now_;
    next_heart_ = now_ + seconds(1);
    while (true) {
      if (const auto result = coordinator_.take_result(id)) {
        report = result->report;
        return to_seconds(now_ - start);
      }
      step();
    }
  }

  void run_until(Time time) {
    at(time, [] {});
    while (now_ < time) step();
  }

  /// From now on.
  void set_speed(uint64_t id, double speed) { workers_.at(id).speed = speed; }
  void at(Time time, std::function<void()> act) { events_.push({time, ++order_, std::move(act)}); }
  /// It says and does nothing more.
  void stop(uint64_t id) { workers_.at(id).stopped = true; }
  Time now() const { return now_; }
  void cancel() {
    coordinator_.interrupt(frame_, now_);
    deliver();
  }
  size_t running() const {
    return static_cast<size_t>(std::count_if(workers_.begin(), workers_.end(), [](const auto& w) {
      return w.second.running.has_value() || !w.second.queue.empty();
    }));
  }

  JobReport report;
  /// Who was given which tile, and when.
  struct Given {
    uint64_t worker;
    uint32_t tile;
    Time time;
  };
  std::vector<Given> given;

 private:
  struct Worker {
    double speed = 1;
    bool stopped = false;
    std::deque<v1::Assign> queue;
    std::optional<v1::Assign> running;
    Time began{};
    uint64_t run = 0;  ///< counts, so that an end is known to be of a run that was cancelled
  };
  struct Event {
    Time time;
    uint64_t order;
    std::function<void()> act;
    bool operator<(const Event& other) const {
      return std::pair(time, order) > std::pair(other.time, other.order);
    }
  };

  double seconds_of(const v1::Assign& assign) const {
    const auto& r = assign.rect();
    return cost_(r.x0() / kTile, r.y0() / kTile) * (r.y1() - r.y0()) / kTile;
  }

  void step() {
    Time next = std::min(coordinator_.next_deadline(), next_heart_);
    if (!events_.empty()) next = std::min(next, events_.top().time);
    now_ = std::max(now_, next);
    if (!events_.empty() && events_.top().time <= now_) {
      const auto act = events_.top().act;
      events_.pop();
      act();
    } else if (now_ >= next_heart_) {
      next_heart_ += seconds(1);
      for (auto& [id, worker] : workers_) beat(id, worker);
    } else {
      coordinator_.on_tick(now_);
      deliver();
    }
  }

  void say(uint64_t id, v1::Envelope message) {
    names_.complete(message);
    at(now_ + kLatency, [this, id, message] {
      coordinator_.on_message(Channel::control, std::to_string(id), message, now_);
      deliver();
    });
  }

  void deliver() {
    for (OutgoingMessage& out : coordinator_.take_outgoing()) {
      const uint64_t id = std::stoull(out.peer);
      if (out.message.has_assign()) {
        given.push_back({id, out.message.assign().tile(), now_});
      }
      at(now_ + kLatency, [this, id, message = out.message] { hear(id, message); });
    }
  }

  void hear(uint64_t id, const v1::Envelope& message) {
    Worker& worker = workers_.at(id);
    if (worker.stopped) return;
    names_.note(message);
    if (message.has_job_start()) {
      frame_ = message.job_start().job();
      v1::Envelope ready;
      ready.mutable_scene_ready()->set_session(1);
      ready.mutable_scene_ready()->set_job(frame_);
      say(id, ready);
    } else if (message.has_assign()) {
      worker.queue.push_back(message.assign());
      begin(id, worker);
    } else if (message.has_cancel_tile()) {
      const v1::CancelTile& cancel = message.cancel_tile();
      std::erase_if(worker.queue,
                    [&](const auto& assign) { return assign.lease() == cancel.lease(); });
      const bool runs = worker.running && worker.running->lease() == cancel.lease();
      if (runs && !cancel.unless_started()) {
        worker.running.reset();
        beat(id, worker);
      }
      begin(id, worker);
    } else if (message.has_cancel_job()) {
      worker.queue.clear();
      worker.running.reset();
      beat(id, worker);
    }
  }

  void begin(uint64_t id, Worker& worker) {
    if (worker.running || worker.queue.empty()) return;
    worker.running = std::move(worker.queue.front());
    worker.queue.pop_front();
    worker.began = now_;
    const uint64_t run = ++worker.run;
    at(now_ + time_of(seconds_of(*worker.running) / worker.speed), [this, id, run] {
      Worker& done = workers_.at(id);
      if (done.stopped || done.run != run || !done.running) return;
      say(id, band(*done.running, time_of(seconds_of(*done.running) / done.speed)));
      done.running.reset();
      begin(id, done);
    });
  }

  static v1::Envelope band(const v1::Assign& assign, Time took) {
    const int rows = assign.rect().y1() - assign.rect().y0();
    const std::vector<float> values(static_cast<size_t>(rows) * kTile * 3, 0.5f);
    v1::Envelope message;
    v1::TileBand& band = *message.mutable_tile_band();
    band = encode_bands(values, kTile, assign.rect().y0(), false)[0];
    band.set_session(1);
    band.set_job(assign.job());
    band.set_lease(assign.lease());
    band.set_tile(assign.tile());
    band.set_trace_microseconds(static_cast<uint64_t>(took.count() / 1000));
    (*band.mutable_counters()->mutable_values())["pixels"] = static_cast<uint64_t>(rows) * kTile;
    return message;
  }

  void beat(uint64_t id, Worker& worker) {
    if (worker.stopped) return;
    v1::Envelope message;
    v1::Heartbeat& heart = *message.mutable_heartbeat();
    heart.set_session(1);
    heart.add_jobs()->set_job(frame_);
    heart.mutable_jobs(0)->set_ready(true);
    const auto list = [&](const v1::Assign& assign, bool started) {
      auto& progress = *heart.add_progress();
      progress.set_job(assign.job());
      progress.set_lease(assign.lease());
      progress.set_started(started);
      progress.set_work_done(started ? static_cast<uint64_t>((now_ - worker.began).count()) : 0);
    };
    if (worker.running) list(*worker.running, true);
    for (const v1::Assign& assign : worker.queue) list(assign, false);
    say(id, message);
  }

  Coordinator coordinator_;
  FrameNames names_;
  Cost cost_;
  std::map<uint64_t, Worker> workers_;
  std::priority_queue<Event> events_;
  Time now_ = seconds(1), next_heart_{};
  uint64_t order_ = 0, frame_ = 0;
  uint32_t frames_ = 0;
};

CoordinatorOptions sound() {
  CoordinatorOptions options;
  options.opening = "a bench of farms";
  return options;
}

/// Neither second copies nor parts.
CoordinatorOptions plain() {
  CoordinatorOptions options = sound();
  options.speculate_after = options.smallest_part = hours(10);
  return options;
}

double total(int side, const Farm::Cost& cost) {
  double sum = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) sum += cost(x, y);
  }
  return sum;
}

double even(int, int) { return 0.02; }
/// A tenth of the frame, below and on the right, takes ten times as long as the rest.
double uneven(int x, int y) { return x >= 22 && y >= 22 ? 0.1 : 0.01; }
constexpr int kSide = 32;

TEST(Makespan, EightEvenWorkersWasteNothing) {
  Farm farm(sound(), std::vector<double>(8, 1), even);
  EXPECT_LT(farm.render(kSide), 1.02 * total(kSide, even) / 8);
  EXPECT_EQ(farm.report.tiles_done, farm.report.tiles_total);
  EXPECT_EQ(farm.report.counters.at("pixels"), uint64_t{kSide} * kSide * kTile * kTile);
}

TEST(Makespan, CostlyTilesAtTheEndOfTheGridComeFirst) {
  Farm farm(sound(), std::vector<double>(8, 1), uneven);
  const double ideal = total(kSide, uneven) / 8;
  EXPECT_LT(farm.render(kSide), 1.02 * ideal);
  // The next frame is told by this one, from its first tile on.
  const size_t before = farm.given.size();
  EXPECT_LT(farm.render(kSide), 1.02 * ideal);
  const std::vector<PixelRect> tiles = cut_tiles({0, 0, kSide * kTile, kSide * kTile}, kTile);
  for (size_t i = before; i < before + 100; ++i) {
    const PixelRect& tile = tiles[farm.given[i].tile];
    EXPECT_GT(uneven(tile.x0 / kTile, tile.y0 / kTile), 0.05) << i;
  }
}

TEST(Makespan, OneOfEightThatIsTenTimesSlowerCostsLessThanATenth) {
  const std::vector<double> speeds{1, 1, 1, 1, 1, 1, 1, 0.1};
  for (const Farm::Cost& cost : {Farm::Cost(even), Farm::Cost(uneven)}) {
    const double ideal = total(kSide, cost) / 7.1;
    Farm farm(sound(), speeds, cost);
    EXPECT_LT(farm.render(kSide), 1.1 * ideal);
  }
  // The figure is owed to what is done about it: without, it is missed.
  Farm without(plain(), speeds, uneven);
  EXPECT_GT(without.render(kSide), 1.1 * total(kSide, uneven) / 7.1);
}

TEST(Makespan, OneThatSlowsDownHalfWayCostsLessThanATenth) {
  Farm farm(sound(), std::vector<double>(8, 1), even);
  const double whole = total(kSide, even);
  const double half = whole / 16;
  farm.at(farm.now() + time_of(half), [&farm] { farm.set_speed(8, 0.1); });
  const double ideal = half + (whole - 8 * half) / 7.1;
  EXPECT_LT(farm.render(kSide), 1.1 * ideal);
}

TEST(Makespan, FewLargeTilesAreSharedByAll) {
  // Nine tiles of a second each for eight workers: two rounds, were they not split.
  const auto large = [](int, int) { return 1.0; };
  Farm split(sound(), std::vector<double>(8, 1), large);
  split.render(3);
  Farm second(sound(), std::vector<double>(8, 1), large);
  second.render(3);
  const double told = second.render(3);
  EXPECT_LT(told, 1.3);
  EXPECT_GT(second.report.split, 0u);
  EXPECT_EQ(second.report.counters.at("pixels"), 9u * kTile * kTile);
  Farm whole(plain(), std::vector<double>(8, 1), large);
  EXPECT_GE(whole.render(3), 2.0);
}

TEST(Makespan, AWorkerThatFallsSilentIsNoticedInThreeSecondsAndItsTilesAreReissuedInThreeAndAHalf) {
  const auto slow = [](int, int) { return 0.5; };
  for (int offset = 0; offset < 1000; offset += 125) {
    Farm farm(sound(), std::vector<double>(4, 1), slow);
    const Time silent = farm.now() + milliseconds(2000 + offset);
    std::vector<uint32_t> held;
    farm.at(silent, [&] {
      farm.stop(2);
      // What it was given last.
      for (auto it = farm.given.rbegin(); it != farm.given.rend() && held.size() < 2; ++it) {
        if (it->worker == 2) held.push_back(it->tile);
      }
    });
    farm.render(16);
    ASSERT_EQ(held.size(), 2u);
    for (const uint32_t tile : held) {
      const auto again = std::find_if(farm.given.begin(), farm.given.end(), [&](const auto& given) {
        return given.tile == tile && given.worker != 2;
      });
      ASSERT_NE(again, farm.given.end());
      EXPECT_LT(to_seconds(again->time - silent), 3.5) << "silent " << offset << " ms later";
    }
  }
}

TEST(Makespan, ACancelledJobLeavesNobodyAtWorkAfterOneMessage) {
  Farm farm(sound(), std::vector<double>(8, 1), [](int, int) { return 10.0; });
  const Time when = farm.now() + seconds(3);
  size_t busy = 0;
  farm.at(when, [&] {
    busy = farm.running();
    farm.cancel();
  });
  farm.render(8);
  EXPECT_EQ(busy, 8u);
  EXPECT_EQ(farm.report.end, JobReport::End::interrupted);
  farm.run_until(when + kLatency + microseconds(1));
  EXPECT_EQ(farm.running(), 0u);
}

}  // namespace
}  // namespace tessera::testing
