#include "studio/render_queue.h"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <vector>

namespace tessera {
namespace {

using Json = nlohmann::json;

/// A queue whose threads answer when a test has them do so.
class RenderQueueTest : public testing::Test {
 protected:
  void add(const std::string& file, std::optional<FrameRange> frames = {}) {
    page::Render wish;
    wish.file = file;
    wish.frames = frames;
    wish.outputs = {"out.png"};
    queue_.add(1, wish, {});
    tick();
  }
  void order(uint64_t job, page::RenderOrder::What what) {
    queue_.order(1, {job, what});
    tick();
  }
  /// Sorts what was ordered.
  void tick() {
    now_ += RenderQueue::kBetweenLists;
    queue_.tick(now_);
    for (StudioOrder& each : std::exchange(orders_, {})) {
      if (const auto* const read = std::get_if<ReadOrder>(&each)) reads_.push_back(*read);
      if (const auto* const trace = std::get_if<TraceFrame>(&each)) traces_.push_back(trace->job);
      if (const auto* const end = std::get_if<EndFrame>(&each)) ends_.push_back(*end);
      if (const auto* const finish = std::get_if<FinishFrame>(&each)) finishes_.push_back(*finish);
      if (std::holds_alternative<SendText>(each)) ++refused_;
    }
  }
  void read(bool is_right = true) {
    const ReadOrder order = reads_.back();
    auto reading = std::make_shared<SceneReading>();
    reading->file = order.file;
    reading->job = order.job;
    if (is_right) {
      reading->scene = std::make_shared<const FrameScene>();
    } else {
      reading->problems.push_back({.message = "a wrong word"});
    }
    queue_.take(std::move(reading));
    tick();
  }
  void trace(uint64_t job) {
    queue_.take(FrameEnd{.job = job,
                         .result = std::make_shared<JobResult>(
                             JobResult{.report = {}, .film = Film({0, 0, 1, 1})})});
    tick();
  }
  void finish(uint64_t job, const std::string& failure = "", const std::string& file = "out.png") {
    FrameFinished finished{.job = job, .written = {file}, .failure = failure};
    finished.picture = std::make_shared<const RenderedPicture>(
        RenderedPicture{.film = Film({0, 0, 1, 1}), .output = {}});
    queue_.take(finished);
    tick();
  }
  std::string state(uint64_t job) const {
    const Json list = queue_.list();
    for (const Json& each : list["list"]) {
      if (each["job"] == job) return each["state"];
    }
    return "";
  }

  using What = page::RenderOrder::What;
  Time now_{};
  StudioOrders orders_;
  RenderQueue queue_{orders_, "/folder", ""};
  std::vector<ReadOrder> reads_;
  std::vector<uint64_t> traces_;
  std::vector<EndFrame> ends_;
  std::vector<FinishFrame> finishes_;
  int refused_ = 0;
};

TEST_F(RenderQueueTest, OneIsReadTracedAndWrittenBeforeTheNextBegins) {
  add("a.tessera");
  add("b.tessera");
  ASSERT_EQ(reads_.size(), 1U);
  EXPECT_EQ(state(1), "reading");
  EXPECT_EQ(state(2), "queued");
  read();
  EXPECT_EQ(traces_, std::vector<uint64_t>{1});
  trace(1);
  ASSERT_EQ(finishes_.size(), 1U);
  EXPECT_EQ(finishes_[0].goal.names, std::vector<std::string>{"out.png"});
  EXPECT_FALSE(finishes_[0].goal.number);
  EXPECT_EQ(reads_.size(), 1U);
  finish(1);
  EXPECT_EQ(state(1), "done");
  EXPECT_TRUE(queue_.picture(1));
  EXPECT_EQ(reads_.size(), 2U);
  EXPECT_EQ(reads_[1].file, "b.tessera");
}

TEST_F(RenderQueueTest, NoFileIsWrittenTwiceByOnePicture) {
  page::Render wish;
  wish.file = "a.tessera";
  wish.outputs = {"out.png", "other.png", "out.png"};
  EXPECT_FALSE(queue_.accepts(1, wish));
  wish.outputs.pop_back();
  EXPECT_TRUE(queue_.accepts(1, wish));
}

TEST_F(RenderQueueTest, WhatIsOverTakesNoPlaceInTheQueue) {
  constexpr auto kMany = static_cast<uint64_t>(RenderQueue::kMostJobs + RenderQueue::kMostOver + 3);
  for (uint64_t job = 1; job <= kMany; ++job) {
    add("a.tessera");
    order(job, What::cancel);
    if (state(job) == "reading") read();
    ASSERT_EQ(state(job), "cancelled");
  }
  EXPECT_EQ(refused_, 0);
  EXPECT_EQ(queue_.list()["list"].size(), RenderQueue::kMostOver);
  for (size_t i = 0; i <= RenderQueue::kMostJobs; ++i) add("b.tessera");
  EXPECT_EQ(refused_, 1);
}

TEST_F(RenderQueueTest, FramesAreReadOneByOneAndNumbered) {
  add("a.tessera", FrameRange{3, 5});
  for (int frame = 3; frame <= 5; ++frame) {
    ASSERT_EQ(reads_.back().frame, frame);
    read();
    trace(1);
    EXPECT_EQ(finishes_.back().goal.number, frame);
    finish(1);
  }
  EXPECT_EQ(state(1), "done");
  EXPECT_EQ(queue_.list()["list"][0]["frames_done"], 3);
}

TEST_F(RenderQueueTest, TheLogTellsOnceThatAnAnimationIsRead) {
  std::ostringstream log;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("", std::make_shared<spdlog::sinks::ostream_sink_mt>(log)));
  add("a.tessera", FrameRange{3, 5});
  for (int frame = 3; frame <= 5; ++frame) {
    read();
    trace(1);
    finish(1);
  }
  spdlog::set_default_logger(before);
  const std::string lines = log.str();
  const size_t first = lines.find("read in");
  EXPECT_NE(first, std::string::npos);
  EXPECT_EQ(lines.find("read in", first + 1), std::string::npos) << lines;
}

TEST_F(RenderQueueTest, OfManyFilesTheListNamesTheNewestAndTheirNumber) {
  constexpr int kFrames = 50;
  add("a.tessera", FrameRange{1, kFrames});
  for (int frame = 1; frame <= kFrames; ++frame) {
    read();
    trace(1);
    finish(1, "", "out." + std::to_string(frame) + ".png");
  }
  const Json job = queue_.list()["list"][0];
  EXPECT_EQ(job["written_count"], kFrames);
  ASSERT_EQ(job["written"].size(), RenderQueue::kMostNamed);
  EXPECT_EQ(job["written"].front(), "out.43.png");
  EXPECT_EQ(job["written"].back(), "out.50.png");
}

TEST_F(RenderQueueTest, FramesShareTheFilesThatHoldThemAll) {
  add("a.tessera", FrameRange{3, 5});
  for (int frame = 3; frame <= 5; ++frame) {
    read();
    trace(1);
    finish(1);
    const FileGoal& goal = finishes_.back().goal;
    ASSERT_TRUE(goal.animations);
    EXPECT_EQ(goal.animations, finishes_.front().goal.animations);
    EXPECT_EQ(goal.is_first_frame, frame == 3);
    EXPECT_EQ(goal.is_last_frame, frame == 5);
  }
  add("b.tessera");
  read();
  trace(2);
  EXPECT_FALSE(finishes_.back().goal.animations);
}

TEST_F(RenderQueueTest, APictureIsUnfinishedOnlyWhileItIsTraced) {
  add("a.tessera");
  EXPECT_FALSE(queue_.unfinished_picture(1));
  read();
  EXPECT_TRUE(queue_.unfinished_picture(1));
  EXPECT_FALSE(queue_.picture(1));
  trace(1);
  EXPECT_FALSE(queue_.unfinished_picture(1));
  finish(1);
  EXPECT_FALSE(queue_.unfinished_picture(1));
  EXPECT_TRUE(queue_.picture(1));
  EXPECT_FALSE(queue_.unfinished_picture(7));
}

TEST_F(RenderQueueTest, PausedOnesKeepTheirTilesAndLetOthersThrough) {
  add("a.tessera");
  add("b.tessera");
  read();
  order(1, What::pause);
  ASSERT_EQ(ends_.size(), 1U);
  EXPECT_TRUE(ends_[0].keeps_tiles);
  EXPECT_EQ(state(1), "paused");
  EXPECT_EQ(reads_.back().file, "b.tessera");
  // A pass that ended meanwhile is of no job that is traced.
  trace(1);
  EXPECT_TRUE(finishes_.empty());
  order(1, What::resume);
  EXPECT_EQ(state(1), "queued");
  read();
  trace(2);
  finish(2);
  EXPECT_EQ(traces_, (std::vector<uint64_t>{1, 2, 1}));
  trace(1);
  finish(1);
  EXPECT_EQ(state(1), "done");
}

TEST_F(RenderQueueTest, CancelledOnesEndWhateverIsDoneForThem) {
  add("a.tessera");
  order(1, What::cancel);
  EXPECT_EQ(state(1), "reading");
  read();
  EXPECT_EQ(state(1), "cancelled");
  EXPECT_TRUE(traces_.empty());
  add("b.tessera");
  read();
  order(2, What::cancel);
  EXPECT_EQ(state(2), "cancelled");
  EXPECT_FALSE(ends_.back().keeps_tiles);
  trace(2);
  EXPECT_EQ(state(2), "cancelled");
  order(2, What::forget);
  EXPECT_EQ(state(2), "");
}

TEST_F(RenderQueueTest, WhatFailsSaysWhyAndTheNextBegins) {
  add("a.tessera");
  add("b.tessera");
  read(false);
  EXPECT_EQ(state(1), "failed");
  EXPECT_EQ(queue_.list()["list"][0]["why"], "a wrong word");
  read();
  queue_.take(FrameEnd{.job = 2, .failure = "no such camera"});
  EXPECT_EQ(queue_.list()["list"][1]["why"], "no such camera");
  add("c.tessera");
  read();
  trace(3);
  finish(3, "out.png: the disk is full");
  EXPECT_EQ(state(3), "failed");
  EXPECT_TRUE(queue_.picture(3));
}

TEST_F(RenderQueueTest, NamesThatCannotBeAreRefused) {
  for (const char* name : {"../out.png", "/out.png", ".out.png", "out", "out.tessera"}) {
    page::Render wish;
    wish.file = "a.tessera";
    wish.outputs = {name};
    queue_.add(1, wish, {});
  }
  tick();
  EXPECT_EQ(refused_, 5);
  EXPECT_TRUE(queue_.list()["list"].empty());
}

TEST_F(RenderQueueTest, WhateverIsOrderedAtMostOneIsWorkedFor) {
  std::mt19937 random(1);  // NOLINT: the same orders each time
  for (int i = 0; i < 3000; ++i) {
    const uint64_t job = 1 + random() % 12;
    switch (random() % 8) {
      case 0:
        add("a.tessera", random() % 2 ? std::optional(FrameRange{0, 2}) : std::nullopt);
        break;
      case 1:
        if (!reads_.empty()) read(random() % 8 != 0);
        break;
      case 2:
        trace(job);
        break;
      case 3:
        finish(job, random() % 8 ? "" : "full");
        break;
      default:
        order(job, static_cast<What>(random() % 4));
    }
    int active = 0;
    const Json list = queue_.list();
    for (const Json& each : list["list"]) active += each["state"] == "tracing";
    ASSERT_LE(active, 1);
    ASSERT_LE(list["list"].size(), RenderQueue::kMostJobs + RenderQueue::kMostOver);
  }
}

}  // namespace
}  // namespace tessera
