#include "coordinator/jobs/work_meter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

namespace tessera {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(WorkMeter, TimeInWhichNobodyWorksDoesNotCount) {
  WorkMeter meter(100);
  meter.account(seconds(5000), 0, {}, 80);
  meter.account(seconds(5010), 1, {}, 80);
  EXPECT_EQ(meter.seconds(seconds(5012), true), 112);
  EXPECT_EQ(meter.seconds(seconds(5012), false), 110);
  meter.account(seconds(9000), 0, {.tiles = 40}, 80);
  EXPECT_EQ(meter.remaining_seconds({.tiles = 40}, {.tiles = 40}, 80, 2, 1), 10);
}

TEST(WorkMeter, TellsNothingBeforeItKnows) {
  WorkMeter meter;
  EXPECT_LT(meter.remaining_seconds({}, {.tiles = 100}, 100, 4, 1), 0);
  meter.account(seconds(1), 0, {.tiles = 40}, 100);
  EXPECT_LT(meter.remaining_seconds({.tiles = 40}, {.tiles = 60}, 100, 4, 1), 0)
      << "all of them in no time";
}

TEST(WorkMeter, DoesNotGuessFromTheFirstTiles) {
  const auto left_after = [](Time worked, uint64_t traced, uint64_t left) {
    WorkMeter meter;
    meter.account(worked, 1, {}, traced + left);
    meter.account(worked, 1, {.tiles = traced}, traced + left);
    return meter.remaining_seconds({.tiles = traced}, {.tiles = left}, traced + left, 1, 1);
  };
  EXPECT_LT(left_after(seconds(1), 1, 509), 0);
  EXPECT_LT(left_after(seconds(1), 31, 479), 0);
  EXPECT_EQ(left_after(seconds(2), 32, 480), 30);
  EXPECT_LT(left_after(seconds(1), 1, 4), 0);
  EXPECT_EQ(left_after(seconds(1), 1, 3), 3) << "a quarter of a few";
  EXPECT_EQ(left_after(seconds(1), 4, 0), 0);
}

TEST(WorkMeter, WhatIsLeftCountsByWhatItTakes) {
  WorkMeter meter;
  // Two threads: the costly half first.
  meter.account(seconds(100), 2, {}, 100);
  const TileWork traced{.tiles = 50, .seconds = 200};
  meter.account(seconds(100), 2, traced, 100);
  EXPECT_EQ(meter.remaining_seconds(traced, {.tiles = 50, .seconds = 20}, 100, 2, 2), 10);
}

/// A job of a random number of tiles, with all that may happen to it.
class History {
 public:
  explicit History(uint64_t seed) : random_(seed) {
    tiles_ = 40 + draw(draw(20) == 0 ? 100'000 : 2000);
    threads_ = some_threads();
    tile_ = milliseconds(10 + draw(5000));
    for (uint64_t i = 0; i < tiles_; ++i) costs_.push_back(1 << draw(7));
    // After one of sixteen, which tell of the others, costly ones come first.
    std::sort(costs_.begin() + static_cast<std::ptrdiff_t>(tiles_ / 16), costs_.end(),
              std::greater<>());
    if (draw(4) == 0) {
      costs_.assign(tiles_, 1);
      tells_costs_ = draw(2) == 0;
    }
    cost_left_ = std::accumulate(costs_.begin(), costs_.end(), int64_t{0});
  }

  void run() {
    while (done_ < tiles_) {
      switch (draw(tiles_ / 4)) {
        case 0:
          wait();
          break;
        case 1:
          // The coordinator is started anew.
          meter_ = WorkMeter(meter_.seconds(now_, false));
          meter_.account(now_, 0, {}, tiles_);
          traced_ = {};
          steady_ = 0;
          break;
        case 2:
          // Workers come or go, which is known at once.
          threads_ = some_threads();
          break;
        case 4:
          // The tiles are of another kind.
          tile_ = milliseconds(10 + draw(5000));
          steady_ = 0;
          break;
        case 3:
          // What was traced comes to nothing.
          work(tile_ * costs_[done_] / threads_);
          steady_ = 0;
          break;
        default:
          break;
      }
      work(tile_ * costs_[done_] / threads_);
      ++traced_.tiles;
      if (tells_costs_) traced_.seconds += to_seconds(tile_ * costs_[done_]);
      cost_left_ -= costs_[done_++];
      ++steady_;
      if (10 * steady_ > tiles_) check();
    }
    EXPECT_NEAR(meter_.seconds(now_, false), to_seconds(worked_), 1e-6);
  }

 private:
  uint64_t draw(uint64_t below) { return random_() % below; }
  uint64_t some_threads() { return 1 + draw(std::max<uint64_t>(1, tiles_ / 40)); }
  /// Of one thread, at the present rate.
  double seconds_left() const { return to_seconds(tile_ * cost_left_); }
  double left() {
    const TileWork left{tiles_ - done_, tells_costs_ ? seconds_left() : 0};
    return meter_.remaining_seconds(traced_, left, tiles_, threads_, threads_);
  }
  void work(Time time) {
    meter_.account(now_, threads_, traced_, tiles_);
    now_ += time;
    worked_ += time;
    meter_.account(now_, threads_, traced_, tiles_);
  }
  void wait() {
    const double before = left();
    for (int i = 0; i < 3; ++i) {
      now_ += seconds(draw(100'000));
      meter_.account(now_, 0, traced_, tiles_);
      ASSERT_EQ(left(), before);
    }
  }
  void check() {
    const double told = left();
    const double right = seconds_left() / static_cast<double>(threads_);
    if (told < 0) return;
    ASSERT_LE(told, 2 * right + 1e-9) << done_ << " of " << tiles_;
    ASSERT_GE(2 * told + 1e-9, right) << done_ << " of " << tiles_;
  }

  std::mt19937_64 random_;
  WorkMeter meter_;
  Time now_{}, worked_{}, tile_{};
  uint64_t tiles_ = 0, threads_ = 1, done_ = 0, steady_ = 0;
  std::vector<int64_t> costs_;  ///< of tiles in the order in which they are traced
  int64_t cost_left_ = 0;
  bool tells_costs_ = true;
  TileWork traced_;
};

TEST(WorkMeter, IsNeverMoreThanTwiceOffOnceATenthIsDoneAtASteadyRate) {
  for (uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    History(seed).run();
    if (::testing::Test::HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace tessera
