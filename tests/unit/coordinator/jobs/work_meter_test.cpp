#include "coordinator/jobs/work_meter.h"

#include <gtest/gtest.h>

#include <random>

namespace tessera {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(WorkMeter, TimeInWhichNobodyWorksDoesNotCount) {
  WorkMeter meter(100);
  meter.account(seconds(5000), false, 0);
  meter.account(seconds(5010), true, 0);
  EXPECT_EQ(meter.seconds(seconds(5012), true), 112);
  EXPECT_EQ(meter.seconds(seconds(5012), false), 110);
  meter.account(seconds(9000), false, 40);
  EXPECT_EQ(meter.remaining_seconds(40, 40, 80, 2), 10);
}

TEST(WorkMeter, TellsNothingBeforeItKnows) {
  WorkMeter meter;
  EXPECT_LT(meter.remaining_seconds(0, 100, 100, 4), 0);
  meter.account(seconds(1), false, 40);
  EXPECT_LT(meter.remaining_seconds(40, 60, 100, 4), 0) << "all of them in no time";
}

/// A job of a random number of tiles, with all that may happen to it.
class History {
 public:
  explicit History(uint64_t seed) : random_(seed) {
    tiles_ = 40 + draw(2000);
    threads_ = 1 + draw(std::max<uint64_t>(1, tiles_ / 40));
    tile_ = milliseconds(10 + draw(5000));
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
          meter_.account(now_, false, 0);
          traced_ = steady_ = 0;
          break;
        case 2:
          // Workers come or go, or the tiles are of another kind.
          tile_ = milliseconds(10 + draw(5000));
          steady_ = 0;
          break;
        case 3:
          // What was traced comes to nothing.
          work(tile_ / threads_);
          steady_ = 0;
          break;
        default:
          break;
      }
      work(tile_ / threads_);
      ++done_;
      ++traced_;
      ++steady_;
      if (10 * steady_ > tiles_) check();
    }
    EXPECT_NEAR(meter_.seconds(now_, false), to_seconds(worked_), 1e-6);
  }

 private:
  uint64_t draw(uint64_t below) { return random_() % below; }
  double left() { return meter_.remaining_seconds(traced_, tiles_ - done_, tiles_, threads_); }
  void work(Time time) {
    meter_.account(now_, true, traced_);
    now_ += time;
    worked_ += time;
    meter_.account(now_, true, traced_);
  }
  void wait() {
    const double before = left();
    for (int i = 0; i < 3; ++i) {
      now_ += seconds(draw(100'000));
      meter_.account(now_, false, traced_);
      ASSERT_EQ(left(), before);
    }
  }
  void check() {
    const double told = left();
    const double right = to_seconds(tile_ / threads_) * static_cast<double>(tiles_ - done_);
    if (told < 0) return;
    ASSERT_LE(told, 2 * right + 1e-9) << done_ << " of " << tiles_;
    ASSERT_GE(2 * told + 1e-9, right) << done_ << " of " << tiles_;
  }

  std::mt19937_64 random_;
  WorkMeter meter_;
  Time now_{}, worked_{}, tile_{};
  uint64_t tiles_ = 0, threads_ = 1, done_ = 0, traced_ = 0, steady_ = 0;
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
