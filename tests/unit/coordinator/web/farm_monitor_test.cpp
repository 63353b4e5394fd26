// What those who watch cost the coordinator's thread: counted, for any number of them.
#include "coordinator/web/farm_monitor.h"

#include <gtest/gtest.h>

#include "tests/unit/coordinator/service_fixture.h"

namespace tessera::testing {
namespace {

class FarmMonitorTest : public ServiceTest {
 protected:
  FarmMonitorTest() { coordinator.on_tick({}); }
  void look(Time at) { monitor.look(coordinator, at); }
  /// Asks for the frame and looks; how many were told, all the same.
  std::shared_ptr<const FrameShown> watch(uint64_t job, Time at, int watchers = 1) {
    std::vector<std::shared_ptr<const FrameShown>> told;
    for (int i = 0; i < watchers; ++i) {
      EXPECT_TRUE(monitor.watch(job, 0, [&](auto shown) { told.push_back(std::move(shown)); }));
    }
    EXPECT_TRUE(told.empty());
    look(at);
    EXPECT_EQ(told.size(), static_cast<size_t>(watchers));
    for (const auto& shown : told) EXPECT_EQ(shown, told.front());
    return told.front();
  }

  FarmMonitor monitor;
};

TEST_F(FarmMonitorTest, ShowsTheFarmFourTimesASecond) {
  EXPECT_EQ(monitor.farm(), nullptr);
  submit(1);
  look(seconds(1));
  const auto first = monitor.farm();
  EXPECT_EQ(first->snapshot.jobs.size(), 1u);
  look(seconds(1) + milliseconds(100));
  EXPECT_EQ(monitor.farm(), first);
  look(seconds(20));
  EXPECT_NE(monitor.farm(), first);
  EXPECT_EQ(monitor.work().snapshots, 2u);
  EXPECT_EQ(monitor.last_look(), seconds(20));
}

TEST_F(FarmMonitorTest, FramesHaveTheNumbersOfTheirAnimation) {
  const uint64_t animation = submit(1, 0, 32, 1, 2, {}, 7), pictures = submit(2, 0, 32, 1, 2);
  EXPECT_EQ(watch(animation, seconds(1))->number, 7);
  EXPECT_EQ(watch(pictures, seconds(2))->number, 1);
  EXPECT_EQ(coordinator.number_of(animation, 1), 8);
  EXPECT_EQ(coordinator.number_of(pictures, 1), 2);
}

TEST_F(FarmMonitorTest, AJobThatComesAndItsFirstTileShowInTheNextLook) {
  Time now = seconds(1);
  const auto soon = [&now] { return now += milliseconds(20); };
  look(now);
  EXPECT_TRUE(monitor.farm()->snapshot.jobs.empty());
  const uint64_t id = submit(1);
  // Each look is paid for by a pause, of little more than nothing.
  for (int i = 0; i < 3; ++i) look(soon());
  ASSERT_EQ(monitor.farm()->snapshot.jobs.size(), 1u);
  come(1, 4);
  EXPECT_EQ(watch(id, soon())->preview, nullptr) << "there is no picture";
  EXPECT_EQ(monitor.work().previews, 0u);
  say("w1", band(assigned().at(0), 1), now);
  now += milliseconds(40);
  const auto shown = watch(id, now);
  ASSERT_TRUE(shown->preview);
  EXPECT_EQ(shown->preview->tiles_done, 1u);
  EXPECT_EQ(monitor.farm()->snapshot.jobs.at(0).tiles_done, 1u);
  say("w1", band(assigned().at(1), 1), now);
  EXPECT_EQ(watch(id, soon())->preview, shown->preview) << "the second waits for its turn";
}

TEST_F(FarmMonitorTest, NewsAreToldWhenTheyComeOrAfterSomeSeconds) {
  std::vector<uint64_t> told;
  const auto ask_news = [&](uint64_t known) {
    return monitor.ask_news(known, [&](uint64_t news) { told.push_back(news); });
  };
  EXPECT_TRUE(ask_news(UINT64_MAX));
  look(seconds(1));
  ASSERT_EQ(told.size(), 1u) << "who knows nothing is told at once";
  EXPECT_TRUE(ask_news(told[0]));
  look(seconds(2));
  EXPECT_EQ(told.size(), 1u);
  const uint64_t id = submit(1);
  look(seconds(3));
  ASSERT_EQ(told.size(), 2u);
  EXPECT_NE(told[1], told[0]);
  EXPECT_EQ(monitor.farm()->snapshot.jobs.at(0).id, id) << "what is told is shown";
  EXPECT_TRUE(ask_news(told[1]));
  for (int i = 10; i <= 13; ++i) look(seconds(i));
  EXPECT_EQ(told.size(), 3u);
  for (int i = 0; i < 256; ++i) EXPECT_TRUE(ask_news(told[2]));
  EXPECT_FALSE(ask_news(told[2])) << "more wait than may";
}

TEST_F(FarmMonitorTest, KeepsTenMinutesOfSamples) {
  submit(1);
  come(1, 2);
  for (int i = 0; i < 700; ++i) {
    if (i == 5) say("w1", band(assigned().at(0), 1), seconds(5));
    look(seconds(i));
  }
  const auto& history = *monitor.farm()->history;
  ASSERT_EQ(history.size(), 600u);
  EXPECT_EQ(history.back().at, 699);
  EXPECT_EQ(history.front().at, 100);
  EXPECT_EQ(history.back().workers, 1u);
  EXPECT_GT(history.back().coordinator_bytes, 0u);
}

TEST_F(FarmMonitorTest, TellsTheThroughput) {
  submit(1);
  come(1, 2);
  look(seconds(10));
  say("w1", band(assigned().at(0), 1), seconds(11));
  look(seconds(12));
  EXPECT_EQ(monitor.farm()->history->back().tiles_per_second, 0.5);
  EXPECT_EQ(monitor.farm()->history->back().result_bytes_per_second, 16 * 16 * 12 / 2);
}

TEST_F(FarmMonitorTest, AHundredWhoWatchCostWhatOneDoes) {
  const uint64_t id = submit(1);
  come(1, 4);
  for (size_t i = 0; i < 3; ++i) {
    say("w1", band(assigned().at(i), 0.5f));
    const auto shown = watch(id, seconds(10 + 10 * static_cast<int>(i)), 100);
    ASSERT_TRUE(shown->preview);
    EXPECT_EQ(shown->preview->tiles_done, i + 1);
    EXPECT_EQ(shown->tiles.size(), 4u);
  }
  EXPECT_EQ(monitor.work().previews, 3u);
  EXPECT_EQ(monitor.work().tile_lists, 3u);
  EXPECT_EQ(monitor.work().snapshots, 3u);
}

TEST_F(FarmMonitorTest, PicturesAreMadeTwiceASecondAtMostAndOnlyOfWhatChanged) {
  const uint64_t id = submit(1), other = submit(2);
  come(1, 8);
  for (int tenth = 0; tenth < 100; ++tenth) {
    const Time now = seconds(100) + tenth * milliseconds(100);
    watch(id, now);
    watch(other, now);
    if (tenth % 10 == 0 && tenth < 40) say("w1", band(assigned().at(size_t(tenth) / 10), 1), now);
  }
  EXPECT_LE(monitor.work().previews, 20u) << "ten seconds";
  EXPECT_LE(monitor.work().previews, 8u) << "two frames before and after each of a few tiles";
  EXPECT_LE(monitor.work().tile_lists, 2 * 41u);
}

TEST_F(FarmMonitorTest, NobodyWatchesNothingIsMade) {
  const uint64_t id = submit(1);
  come(1, 4);
  watch(id, seconds(1));
  const auto before = monitor.work();
  say("w1", band(assigned().at(0), 1));
  for (int i = 20; i < 100; ++i) look(seconds(i));
  EXPECT_EQ(monitor.work().previews, before.previews);
  EXPECT_EQ(monitor.work().tile_lists, before.tile_lists);
}

TEST_F(FarmMonitorTest, AFrameThatHasEndedIsMadeOnce) {
  const uint64_t id = submit(1);
  come(1, 4);
  for (size_t i = 0; i < 4; ++i) say("w1", band(assigned().at(i), 1));
  ASSERT_EQ(ask(id).state(), v1::JobStatus::ENDED);
  for (int i = 1; i < 20; ++i) {
    const auto shown = watch(id, seconds(i));
    ASSERT_TRUE(shown->preview);
    EXPECT_TRUE(shown->tiles.empty());
  }
  EXPECT_EQ(monitor.work().previews, 1u);
}

TEST_F(FarmMonitorTest, WatchesSoManyFramesAtATime) {
  const uint64_t id = submit(1);
  int told = 0;
  for (uint32_t frame = 0; frame < 1024; ++frame) {
    EXPECT_TRUE(monitor.watch(id, frame, [&](const auto&) { ++told; }));
  }
  EXPECT_FALSE(monitor.watch(id, 0, [&](const auto&) { ++told; })) << "more wait than may";
  look(seconds(1));
  EXPECT_EQ(told, 1024) << "all are answered";
  EXPECT_LE(monitor.work().tile_lists, 16u);
}

TEST_F(FarmMonitorTest, DoesWhatIsOrdered) {
  const uint64_t id = submit(1);
  look(seconds(1));
  v1::JobQuery query;
  query.set_job(id);
  query.set_action(v1::JobQuery::PAUSE);
  std::vector<v1::JobStatus> told;
  EXPECT_TRUE(monitor.order(query, [&](const v1::JobStatus& status) { told.push_back(status); }));
  EXPECT_TRUE(told.empty());
  look(seconds(1) + milliseconds(50));
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].state(), v1::JobStatus::PAUSED);
  EXPECT_EQ(monitor.farm()->snapshot.jobs.at(0).state, FarmSnapshot::JobState::paused)
      << "it shows at once";
}

TEST_F(FarmMonitorTest, TellsTheTimelineWhileItRunsAndAfter) {
  const uint64_t id = submit(1);
  come(1, 4);
  std::shared_ptr<const FrameTrace> trace;
  const auto ask_trace = [&](uint64_t job, Time now) {
    monitor.ask([&, job](Coordinator& asked, Time) { trace = asked.trace(job, 0); });
    look(now);
  };
  say("w1", band(assigned().at(0), 1), seconds(2));
  ask_trace(id, seconds(10));
  ASSERT_TRUE(trace);
  ASSERT_EQ(trace->spans.size(), 2u);
  EXPECT_EQ(trace->spans[0].kind, FrameTrace::Kind::scene);
  EXPECT_EQ(trace->spans[1].kind, FrameTrace::Kind::tile);
  EXPECT_EQ(trace->spans[1].end - trace->spans[1].begin, 2);
  EXPECT_EQ(trace->spans[1].rect, (PixelRect{0, 0, 16, 16}));
  for (size_t i = 1; i < 4; ++i) say("w1", band(assigned().at(i), 1), seconds(3));
  ask_trace(id, seconds(20));
  EXPECT_EQ(trace->spans.size(), 5u);
  ask_trace(id + 1, seconds(30));
  EXPECT_EQ(trace, nullptr);
}

TEST_F(FarmMonitorTest, CarriesOutAFewOrdersInOneLookAndAllInTheEnd) {
  const uint64_t id = submit(1);
  std::vector<int> told;
  for (int i = 0; i < 100; ++i) {
    v1::JobQuery query;
    query.set_job(id);
    query.set_priority(i + 1);
    ASSERT_TRUE(
        monitor.order(query, [&](const v1::JobStatus& s) { told.push_back(s.priority()); }));
  }
  look(seconds(1));
  EXPECT_EQ(told.size(), 4u) << "each may be a write to a disk";
  EXPECT_EQ(monitor.work().orders, 4u);
  look(seconds(1));
  EXPECT_EQ(told.size(), 4u) << "not before they were paid for";
  for (int at = 1; at < 30; ++at) look(std::chrono::hours(at));
  ASSERT_EQ(told.size(), 100u);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(told[static_cast<size_t>(i)], i + 1) << "in their order";
  EXPECT_EQ(monitor.work().orders, 100u);
}

}  // namespace
}  // namespace tessera::testing
