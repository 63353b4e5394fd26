// Which of several jobs workers get tiles of: by priority, by weight, and none of a paused job.
#include "tests/unit/coordinator/service_fixture.h"

namespace tessera::testing {
namespace {

TEST_F(ServiceTest, HigherPriorityComesFirst) {
  const uint64_t low = submit(1, 0, 64), high = submit(2, 5);
  come(1, 4);
  EXPECT_EQ(count_of(high), 4u);
  EXPECT_EQ(count_of(low), 0u);
  for (size_t i = 0; i < 4; ++i) say("w1", band(assigned().at(i), 1));
  get_ready("w1");
  EXPECT_EQ(count_of(low), 4u);
}

TEST_F(ServiceTest, EqualsShareByWeight) {
  const uint64_t one = submit(1, 0, 256), three = submit(2, 0, 256, 3);
  come(1, 1);
  Time now{};
  for (size_t i = 0; i < 80; ++i) {
    now += milliseconds(100);
    say("w1", band(assigned().at(i), 1), now);
    get_ready("w1", now);
  }
  EXPECT_NEAR(static_cast<double>(count_of(three)), 60, 3);
  EXPECT_NEAR(static_cast<double>(count_of(one)), 20, 3);
}

TEST_F(ServiceTest, ALaterJobDoesNotCatchUpWithWhatOthersHad) {
  const uint64_t first = submit(1, 0, 256);
  come(1, 1);
  Time now{};
  size_t given = 0;
  for (; given < 40; ++given) {
    now += milliseconds(100);
    say("w1", band(assigned().at(given), 1), now);
  }
  const uint64_t second = submit(2, 0, 256, 1, 1, now);
  coordinator.on_tick(now);
  get_ready("w1", now);
  const size_t before = assigned().size();
  for (; given < before + 39; ++given) {
    now += milliseconds(100);
    say("w1", band(assigned().at(given), 1), now);
    get_ready("w1", now);
  }
  EXPECT_NEAR(static_cast<double>(count_of(first, before)), 20, 2);
  EXPECT_NEAR(static_cast<double>(count_of(second, before)), 20, 2);
}

TEST_F(ServiceTest, APausedJobGetsNoTileAndTakesThoseThatAreOut) {
  const uint64_t id = submit(1, 0, 64);
  come(1, 2);
  EXPECT_EQ(ask(id, v1::JobQuery::PAUSE).state(), v1::JobStatus::PAUSED);
  say("w1", band(assigned().at(0), 1));
  EXPECT_EQ(ask(id).tiles_done(), 1u);
  EXPECT_EQ(assigned().size(), 2u);
  restart();
  coordinator.on_tick({});
  come(1, 2);
  EXPECT_EQ(assigned().size(), 0u) << "also after a restart";
  ask(id, v1::JobQuery::RESUME);
  coordinator.on_tick({});
  get_ready("w1");
  EXPECT_EQ(assigned().size(), 2u);
}

TEST_F(ServiceTest, APausedJobGivesItsMemoryBackOnceItsTilesAreIn) {
  limit([](CoordinatorOptions& options) { options.begin.film_bytes = 32 * 32 * 12; });
  const uint64_t one = submit(1), two = submit(2);
  come(1, 1);
  EXPECT_EQ(
      ask(two).waits_for(),
      "memory: its picture takes 12288 bytes, those of jobs that were begun, as job 1, 12288 of "
      "12288");
  v1::JobQuery pause;
  pause.set_job(one);
  pause.set_action(v1::JobQuery::PAUSE);
  pause.set_by("alice");
  coordinator.ask(pause, {});
  EXPECT_EQ(ask(one).waits_for(), "somebody to resume it: it was paused by alice");
  EXPECT_EQ(ask(two).state(), v1::JobStatus::RUNNING);
  EXPECT_FALSE(heard(v1::Envelope::kCancelJob).empty()) << "workers forget its scene";
  EXPECT_EQ(coordinator.running_frames().size(), 1u);
  get_ready("w1");
  for (size_t i = 1; i < 5; ++i) say("w1", band(assigned().at(i), 1));
  EXPECT_EQ(ask(two).how(), v1::JobEnd::DONE);
  restart();
  EXPECT_EQ(ask(one).waits_for(), "somebody to resume it: it was paused by alice");
  ask(one, v1::JobQuery::RESUME);
  coordinator.on_tick({});
  come(1, 4);
  for (const v1::Assign& assign : assigned()) say("w1", band(assign, 1));
  EXPECT_EQ(ask(one).how(), v1::JobEnd::DONE);
}

TEST_F(ServiceTest, APausedJobIsShownFromTheStore) {
  const uint64_t id = submit(1);
  come(1, 1);
  say("w1", band(assigned().at(0), 0.25f));
  ask(id, v1::JobQuery::PAUSE);
  say("w1", band(assigned().at(1), 0.25f));
  EXPECT_TRUE(coordinator.running_frames().empty());
  const auto preview = coordinator.preview(id, 0, 8);
  ASSERT_TRUE(preview);
  EXPECT_EQ(preview->tiles_done, 2u);
  EXPECT_EQ(preview->rgb[0], 137);
}

TEST_F(ServiceTest, AMoreUrgentJobGetsTheNextTileWhateverTheLimits) {
  limit([](CoordinatorOptions& options) {
    options.begin.jobs = 2;
    options.begin.urgent_jobs = 3;
    options.scenes_of_worker = 1;
  });
  std::vector<uint64_t> jobs;
  for (uint32_t i = 1; i <= 4; ++i) jobs.push_back(submit(i, static_cast<int>(i), 64));
  EXPECT_EQ(ask(jobs[0]).state(), v1::JobStatus::QUEUED) << "it was put aside for the last";
  EXPECT_EQ(ask(jobs[0]).waits_for(), "workers");
  come(1, 1);
  const uint64_t urgent = submit(9, 10);
  EXPECT_EQ(ask(urgent).state(), v1::JobStatus::RUNNING);
  EXPECT_EQ(ask(jobs[0]).waits_for(), "job 3, which was begun before");
  const size_t before = assigned().size();
  say("w1", band(assigned().back(), 1));
  ready("w1", first_frame_of(urgent));
  ASSERT_GT(assigned().size(), before);
  EXPECT_EQ(job_of(assigned().at(before)), urgent);
  EXPECT_EQ(ask(jobs[2]).waits_for(), fmt::format("job {}, which is more urgent", urgent));
}

}  // namespace
}  // namespace tessera::testing
