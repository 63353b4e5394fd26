#include "coordinator/jobs/scheduling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace tessera {
namespace {

constexpr BeginLimits kLimits{.jobs = 2, .urgent_jobs = 3, .film_bytes = 100};

OpenJob waiting(uint64_t id, int32_t priority, uint64_t film = 10) {
  return {.id = id, .priority = priority, .next = OpenJob::Next{0, film}};
}

OpenJob begun(uint64_t id, int32_t priority, uint64_t film = 10, size_t tiles_out = 1) {
  OpenJob job{.id = id, .priority = priority};
  job.begun.push_back(
      {.frame = 0, .film_bytes = film, .tiles_out = tiles_out, .has_pending = true});
  return job;
}

OpenJob paused(OpenJob job) {
  job.paused = true;
  return job;
}

using Frames = std::vector<FrameOfJob>;

TEST(Scheduling, JobsOfOnePriorityBeginInTheirOrderUpToTheLimit) {
  const BeginPlan plan = plan_begin({waiting(1, 0), waiting(2, 0), waiting(3, 0)}, kLimits);
  EXPECT_EQ(plan.begin, (Frames{{1, 0}, {2, 0}}));
  EXPECT_TRUE(plan.put_aside.empty());
}

TEST(Scheduling, AMoreUrgentJobBeginsWhateverTheLimitOfBegunJobs) {
  std::vector<OpenJob> jobs = {begun(1, 1), begun(2, 2), waiting(4, 5)};
  EXPECT_EQ(plan_begin(jobs, kLimits).begin, (Frames{{4, 0}})) << "one of the urgent places";
  jobs.push_back(begun(3, 3));
  const BeginPlan plan = plan_begin(jobs, kLimits);
  EXPECT_EQ(plan.put_aside, (Frames{{1, 0}})) << "the least urgent";
  EXPECT_EQ(plan.begin, (Frames{{4, 0}}));
  jobs[2].priority = 1;
  EXPECT_TRUE(plan_begin(jobs, kLimits).begin.empty()) << "an equal one waits";
}

TEST(Scheduling, WhatIsPausedHoldsNothing) {
  EXPECT_EQ(plan_begin({paused(begun(1, 5, 100, 0)), waiting(2, 0)}, kLimits).put_aside,
            (Frames{{1, 0}}));
  // Tiles that are out come in first, unless another needs the memory.
  EXPECT_TRUE(plan_begin({paused(begun(1, 5, 50, 3))}, kLimits).put_aside.empty());
  const BeginPlan plan = plan_begin({paused(begun(1, 5, 50, 3)), waiting(2, 0, 60)}, kLimits);
  EXPECT_EQ(plan.put_aside, (Frames{{1, 0}}));
  EXPECT_EQ(plan.begin, (Frames{{2, 0}}));
}

TEST(Scheduling, MemoryComesFromTheLeastUrgentAndNoMoreThanIsNeeded) {
  const BeginLimits limits{.jobs = 8, .film_bytes = 100};
  const BeginPlan plan =
      plan_begin({begun(1, 0, 10), begun(2, 1, 60), begun(3, 2, 20), waiting(4, 5, 70)}, limits);
  EXPECT_EQ(plan.put_aside, (Frames{{2, 0}}));
  EXPECT_EQ(plan.begin, (Frames{{4, 0}}));
  EXPECT_TRUE(
      plan_begin({begun(1, 5, 40), begun(2, 1, 30), waiting(4, 5, 70)}, limits).put_aside.empty())
      << "that would not do";
  OpenJob unsaved = begun(1, 0, 60);
  unsaved.begun[0].may_be_put_aside = false;
  EXPECT_TRUE(plan_begin({unsaved, waiting(2, 5, 70)}, limits).begin.empty());
  EXPECT_EQ(plan_begin({begun(1, 5, 100), waiting(2, 0, 101)}, limits).begin, (Frames{{2, 0}}))
      << "it is refused";
}

TEST(Scheduling, TheNextFrameBeginsOnceAllTilesOfTheOneBeforeAreOut) {
  OpenJob job = begun(1, 0);
  job.next = {1, 10};
  EXPECT_TRUE(plan_begin({job}, kLimits).begin.empty());
  job.begun[0].has_pending = false;
  EXPECT_EQ(plan_begin({job}, kLimits).begin, (Frames{{1, 1}}));
}

TEST(Scheduling, SaysForWhatAJobWaits) {
  EXPECT_EQ(wait_of(waiting(3, 0), std::vector{begun(1, 1), begun(2, 0)}, kLimits).behind, 2u);
  EXPECT_EQ(wait_of(waiting(3, 0), std::vector{begun(1, 1), begun(2, 0)}, kLimits).what,
            Wait::For::jobs);
  const Wait wait = wait_of(waiting(3, 0, 90), std::vector{begun(1, 1, 20)}, kLimits);
  EXPECT_EQ(wait.what, Wait::For::memory);
  EXPECT_EQ(wait.promised_bytes, 20u);
  EXPECT_EQ(wait_of(waiting(3, 0), std::vector{begun(1, 1)}, kLimits).what, Wait::For::nothing);
}

TEST(Scheduling, AWorkerForgetsTheLeastUrgentSceneOfWhichItHoldsNoTile) {
  const std::vector<KnownScene> scenes = {{1, 3, 0}, {2, 0, 4}, {3, 1, 0}, {4, 2, 0}};
  EXPECT_EQ(scene_to_forget(scenes, 5).frame, 3u);
  EXPECT_FALSE(scene_to_forget(scenes, 5).waits);
  EXPECT_FALSE(scene_to_forget(scenes, 1).frame);
  EXPECT_TRUE(scene_to_forget(scenes, 1).waits) << "for a tile of scene 2";
  EXPECT_FALSE(scene_to_forget(scenes, 0).waits);
}

/// Does what the plan says.
void follow(const BeginPlan& plan, std::vector<OpenJob>& jobs, const BeginLimits& limits) {
  const auto find = [&](uint64_t id) {
    return std::ranges::find_if(jobs, [id](const OpenJob& job) { return job.id == id; });
  };
  for (const FrameOfJob& aside : plan.put_aside) {
    const auto job = find(aside.job);
    const auto is_it = [&](const BegunFrame& of) { return of.frame == aside.frame; };
    const auto at = std::ranges::find_if(job->begun, is_it);
    ASSERT_NE(at, job->begun.end());
    ASSERT_TRUE(at->may_be_put_aside);
    const uint64_t film = at->film_bytes;
    job->begun.erase(at);
    if (!job->next || job->next->frame > aside.frame) job->next = {aside.frame, film};
  }
  for (const auto& [id, frame] : plan.begin) {
    const auto job = find(id);
    ASSERT_EQ(job->next->frame, frame);
    const uint64_t film = job->next->film_bytes;
    job->next.reset();
    if (film > limits.film_bytes) continue;
    job->begun.push_back({frame, film, 0, true, true});
  }
}

TEST(Scheduling, RulesHoldOnceThePlanIsFollowed) {
  for (uint32_t seed = 0; seed < 20'000; ++seed) {
    std::mt19937 random(seed);
    const auto draw = [&random](uint32_t below) { return random() % below; };
    BeginLimits limits;
    limits.jobs = 1 + draw(3);
    limits.urgent_jobs = limits.jobs + draw(3);
    limits.film_bytes = 30 + draw(50);
    std::vector<OpenJob> jobs;
    uint64_t promised = 0;
    for (uint64_t id = 1; id <= 1 + draw(9); ++id) {
      OpenJob& job =
          jobs.emplace_back(OpenJob{.id = id, .priority = static_cast<int32_t>(draw(4))});
      job.paused = draw(4) == 0;
      const uint64_t film = 1 + draw(40);
      uint32_t frame = 0;
      for (; frame < draw(3) && promised + film <= limits.film_bytes; ++frame) {
        promised += film;
        job.begun.push_back({frame, film, draw(3), draw(2) == 0, draw(5) != 0});
      }
      if (draw(3) > 0) job.next = {frame, film};
    }
    for (int step = 0;; ++step) {
      const BeginPlan plan = plan_begin(jobs, limits);
      if (plan.begin.empty() && plan.put_aside.empty()) break;
      ASSERT_LT(step, 20) << "it does not come to rest, seed " << seed;
      follow(plan, jobs, limits);
    }
    ASSERT_EQ(broken_rule(jobs, limits), "") << "seed " << seed;
  }
}

}  // namespace
}  // namespace tessera
