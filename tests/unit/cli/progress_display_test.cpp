#include "cli/progress_display.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace tessera {
namespace {

JobProgress half_done() {
  JobProgress progress;
  progress.tiles_done = 21;
  progress.tiles_total = 42;
  progress.workers = 4;
  progress.remaining_seconds = 83;
  return progress;
}

TEST(ProgressDisplay, TellsTilesWorkersAndTimeLeft) {
  EXPECT_EQ(progress_text(half_done(), false), " 50 %  21/42 tiles  4 workers  ETA 1:23");
  EXPECT_EQ(progress_text(half_done(), true),
            "[============>           ]  50 %  21/42 tiles  4 workers  ETA 1:23");
}

TEST(ProgressDisplay, LeavesOutWhatIsNotKnown) {
  JobProgress progress = half_done();
  progress.workers = 0;
  progress.remaining_seconds = -1;
  EXPECT_EQ(progress_text(progress, false), " 50 %  21/42 tiles");
  EXPECT_EQ(progress_text({}, false), "  0 %");
}

TEST(ProgressDisplay, TellsWhatItWaitsFor) {
  JobProgress progress;
  progress.waiting_for = "the coordinator at tcp://127.0.0.1:1";
  EXPECT_EQ(progress_text(progress, false),
            "  0 %  waiting for the coordinator at tcp://127.0.0.1:1");
  progress.tiles_total = 42;
  progress.waiting_for = "workers";
  EXPECT_EQ(progress_text(progress, false), "  0 %  0/42 tiles  waiting for workers");
}

TEST(ProgressDisplay, AFullBarHasNoHead) {
  JobProgress progress = half_done();
  progress.tiles_done = 42;
  progress.workers = 1;
  EXPECT_EQ(progress_text(progress, true),
            "[========================] 100 %  42/42 tiles  1 worker");
}

TEST(ProgressDisplay, Durations) {
  EXPECT_EQ(duration_text(0.424), "0.42 s");
  EXPECT_EQ(duration_text(12.34), "12.3 s");
  EXPECT_EQ(duration_text(125.2), "2:05");
  EXPECT_EQ(duration_text(3725), "1:02:05");
}

/// What a display in this style writes for a fast frame of many tiles.
std::string written_by(ProgressStyle style) {
  char* text = nullptr;
  size_t size = 0;
  std::FILE* stream = open_memstream(&text, &size);
  {
    ProgressDisplay display(style, stream, "");
    JobProgress progress = half_done();
    for (progress.tiles_done = 0; progress.tiles_done <= 42; ++progress.tiles_done) {
      display.show(progress);
    }
  }
  std::fclose(stream);
  std::string result(text, size);
  std::free(text);
  return result;
}

TEST(ProgressDisplay, AFastFrameWritesNothing) {
  EXPECT_EQ(written_by(ProgressStyle::silent), "");
  EXPECT_EQ(written_by(ProgressStyle::lines), "");
  EXPECT_EQ(written_by(ProgressStyle::bar), "");
}

}  // namespace
}  // namespace tessera
