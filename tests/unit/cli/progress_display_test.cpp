#include "cli/progress_display.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>

namespace tessera {
namespace {

using namespace std::chrono_literals;

JobProgress half_done() {
  JobProgress progress;
  progress.tiles_done = 21;
  progress.tiles_total = 42;
  progress.workers = 4;
  progress.remaining_seconds = 83;
  return progress;
}

TEST(ProgressDisplay, TellsTilesWorkersAndTimeLeft) {
  EXPECT_EQ(progress_text(half_done()), " 50 %  21/42 tiles  4 workers  ETA 1:23");
  EXPECT_EQ(progress_bar(half_done(), "", 100),
            "[============>           ]  50 %  21/42 tiles  4 workers  ETA 1:23");
}

TEST(ProgressDisplay, LeavesOutWhatIsNotKnown) {
  JobProgress progress = half_done();
  progress.workers = 0;
  progress.remaining_seconds = -1;
  EXPECT_EQ(progress_text(progress), " 50 %  21/42 tiles");
  EXPECT_EQ(progress_text({}), "  0 %");
}

TEST(ProgressDisplay, TellsWhatItWaitsFor) {
  JobProgress progress;
  progress.waiting_for = "the coordinator at tcp://127.0.0.1:1";
  EXPECT_EQ(progress_text(progress), "  0 %  waiting for the coordinator at tcp://127.0.0.1:1");
  progress.tiles_total = 42;
  progress.waiting_for = "workers";
  EXPECT_EQ(progress_text(progress), "  0 %  0/42 tiles  waiting for workers");
}

TEST(ProgressDisplay, AFullBarHasNoHead) {
  JobProgress progress = half_done();
  progress.tiles_done = 42;
  progress.workers = 1;
  EXPECT_EQ(progress_bar(progress, "", 100),
            "[========================] 100 %  42/42 tiles  1 worker");
}

TEST(ProgressDisplay, TheBarIsFirstToBecomeShorterThenTheLastPartsGo) {
  const auto in = [](size_t columns) { return progress_bar(half_done(), "frame 7  ", columns); };
  EXPECT_EQ(in(77), "frame 7  [============>           ]  50 %  21/42 tiles  4 workers  ETA 1:23");
  EXPECT_EQ(in(60), "frame 7  [====>    ]  50 %  21/42 tiles  4 workers  ETA 1:23");
  EXPECT_EQ(in(54), "frame 7   50 %  21/42 tiles  4 workers  ETA 1:23");
  EXPECT_EQ(in(47), "frame 7   50 %  21/42 tiles  4 workers");
  EXPECT_EQ(in(30), "frame 7   50 %  21/42 tiles");
  EXPECT_EQ(in(20), "frame 7   50 %");
  EXPECT_EQ(in(9), "frame 7 ");
  EXPECT_EQ(in(3), "fra");
  for (size_t columns = 1; columns < 90; ++columns) EXPECT_LE(in(columns).size(), columns);
}

TEST(ProgressDisplay, Durations) {
  EXPECT_EQ(duration_text(0.424), "0.42 s");
  EXPECT_EQ(duration_text(12.34), "12.3 s");
  EXPECT_EQ(duration_text(125.2), "2:05");
  EXPECT_EQ(duration_text(3725), "1:02:05");
}

/// What a display in this style writes of a frame that takes so long, looked at every millisecond.
std::string written_by(ProgressStyle style, std::chrono::milliseconds length) {
  char* text = nullptr;
  size_t size = 0;
  std::FILE* stream = open_memstream(&text, &size);
  {
    const Time begin = std::chrono::hours(1);
    ProgressDisplay display(style, stream, "", begin);
    JobProgress progress;
    progress.tiles_total = 1000;
    progress.remaining_seconds = -1;
    for (std::chrono::milliseconds now{0}; now <= length; ++now) {
      progress.tiles_done = static_cast<uint64_t>(1000 * now / length);
      display.show(progress, begin + now);
    }
  }
  std::fclose(stream);
  std::string result(text, size);
  std::free(text);
  return result;
}

TEST(ProgressDisplay, AFastFrameWritesNothing) {
  for (const auto style : {ProgressStyle::silent, ProgressStyle::lines, ProgressStyle::bar}) {
    EXPECT_EQ(written_by(style, 99ms), "");
  }
}

TEST(ProgressDisplay, WritesALineEveryTwoSeconds) {
  EXPECT_EQ(std::ranges::count(written_by(ProgressStyle::lines, 100s), '\n'), 50);
  EXPECT_EQ(written_by(ProgressStyle::silent, 100s), "");
}

TEST(ProgressDisplay, WritesALineAtATenthButNotWithinASecondOfTheLast) {
  EXPECT_EQ(written_by(ProgressStyle::lines, 999ms), "");
  EXPECT_EQ(written_by(ProgressStyle::lines, 4s),
            " 25 %  250/1000 tiles\n 50 %  500/1000 tiles\n 75 %  750/1000 tiles\n"
            "100 %  1000/1000 tiles\n");
  EXPECT_EQ(std::ranges::count(written_by(ProgressStyle::lines, 15s), '\n'), 10);
}

TEST(ProgressDisplay, DrawsTheBarTenTimesASecond) {
  const std::string text = written_by(ProgressStyle::bar, 10s);
  EXPECT_EQ(std::ranges::count(text, '\r'), 100 + 1) << "the last wipes it";
}

}  // namespace
}  // namespace tessera
