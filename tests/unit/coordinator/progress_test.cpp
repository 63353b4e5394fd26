// How far a job is, how long it was worked on and how long it will take.
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/unit/coordinator/service_fixture.h"

namespace tessera::testing {
namespace {

class Progress : public ServiceTest {
 protected:
  v1::JobStatus look(uint64_t id) { return ask(id, v1::JobQuery::ASK, now); }
  /// Sends the pixels of assignments that were not answered yet, one every `pace`.
  void trace(size_t count, Time pace) {
    for (size_t i = 0; i < count && traced < assigned().size(); ++i) {
      now += pace;
      say("w1", band(assigned()[traced++], 1), now);
      get_ready_in(session);
    }
  }
  void start_anew() {
    restart();
    traced = 0;
    coordinator.on_tick(now);
  }
  void come_now() {
    v1::Envelope message = hello(1, ++session);
    message.mutable_hello()->set_credit(1);
    message.mutable_hello()->set_threads(1);
    say("w1", message, now);
    get_ready_in(session);
  }
  void get_ready_in(uint64_t of_session) {
    for (size_t told = 0; told < heard(v1::Envelope::kJobStart).size(); ++told) {
      v1::Envelope message;
      message.mutable_scene_ready()->set_session(of_session);
      message.mutable_scene_ready()->set_job(
          heard(v1::Envelope::kJobStart)[told].job_start().job());
      say("w1", message, now);
    }
  }
  static constexpr int kColumns = 40, kDiscSide = 16 * kColumns;
  /// A disc in the middle takes up to fifty times as long as what is around it.
  static Time cost(int x0, int y0) {
    const double away = std::hypot(x0 / 16 - 24, y0 / 16 - 14) / 12;
    return milliseconds(20 + static_cast<int>(1000 * std::max(0., 1 - away)));
  }
  uint64_t submit_disc() {
    open_tiles = kColumns * kColumns;
    for (int y = 0; y < kDiscSide; y += 16) {
      for (int x = 0; x < kDiscSide; x += 16) left += cost(x, y);
    }
    const uint64_t id = submit(1, 0, kDiscSide, 1, 1, now);
    come_now();
    return id;
  }
  /// Sends the pixels of the disc's tiles, until so many of all are done or the frame has ended;
  /// after each from `first` of this process on, the time left that is told is at most twice too
  /// long or too short. Returns how often it was looked at.
  int trace_disc(uint64_t id, size_t until, size_t first) {
    int looks = 0;
    while (traced < assigned().size() && kColumns * kColumns - open_tiles < until) {
      const v1::Assign assign = assigned()[traced++];
      const Time took = cost(assign.rect().x0(), assign.rect().y0());
      now += took;
      left -= took;
      --open_tiles;
      v1::Envelope message = band(assign, 1);
      message.mutable_tile_band()->set_trace_microseconds(
          static_cast<uint64_t>(to_seconds(took) * 1e6));
      say("w1", message, now);
      coordinator.on_tick(now);
      if (traced < first || left == Time{}) continue;
      const double told = look(id).remaining_seconds(), right = to_seconds(left);
      ++looks;
      EXPECT_LT(told, 2 * right) << traced;
      EXPECT_GT(2 * told, right) << traced;
    }
    return looks;
  }
  Time now = seconds(100), left{};
  size_t traced = 0, open_tiles = 0;
  uint64_t session = 0;
};

TEST_F(Progress, TimeWithoutAWorkerIsNoPartOfIt) {
  const uint64_t id = submit(1, 0, 160, 1, 1, now);
  now += seconds(1000);
  coordinator.on_tick(now);
  EXPECT_EQ(look(id).elapsed_seconds(), 0);
  EXPECT_LT(look(id).remaining_seconds(), 0);
  come_now();
  trace(50, seconds(1));
  EXPECT_EQ(look(id).elapsed_seconds(), 50);
  EXPECT_NEAR(look(id).remaining_seconds(), 50, 2);
  EXPECT_NEAR(coordinator.snapshot(now).jobs.at(0).remaining_seconds, 50, 2) << "the page";
}

TEST_F(Progress, WhileItIsPausedNothingIsToldAndAfterwardsTheSame) {
  const uint64_t id = submit(1, 0, 160, 1, 1, now);
  come_now();
  trace(50, seconds(1));
  ask(id, v1::JobQuery::PAUSE, now);
  trace(1, seconds(1));
  EXPECT_LT(look(id).remaining_seconds(), 0);
  now += seconds(5000);
  coordinator.on_tick(now);
  EXPECT_LT(look(id).remaining_seconds(), 0);
  EXPECT_EQ(look(id).elapsed_seconds(), 51);
  ask(id, v1::JobQuery::RESUME, now);
  coordinator.on_tick(now);
  come_now();
  trace(1, seconds(1));
  EXPECT_NEAR(look(id).remaining_seconds(), 48, 2);
}

TEST_F(Progress, TilesOfAFrameThatFailedAreNotWaitedFor) {
  const uint64_t id = submit(1, 0, 160, 1, 4, now);
  come_now();
  v1::Envelope message;
  v1::SceneFailed& failed = *message.mutable_scene_failed();
  failed.set_session(session);
  failed.set_job(heard(v1::Envelope::kJobStart).at(0).job_start().job());
  failed.set_cause(v1::SceneFailed::BAD_SCENE);
  failed.set_text("bad");
  say("w1", message, now);
  traced = assigned().size();  // of the frame that failed
  coordinator.on_tick(now);
  get_ready_in(session);
  trace(250, seconds(1));
  EXPECT_EQ(look(id).tiles_done(), 250u);
  EXPECT_EQ(look(id).tiles_total(), 400u);
  EXPECT_NEAR(look(id).remaining_seconds(), 50, 2);
}

TEST_F(Progress, WhatIsStoredCountsBeforeTheJobIsBegun) {
  const uint64_t id = submit(1, 0, 160, 1, 2, now);
  come_now();
  trace(62, seconds(1));
  ask(id, v1::JobQuery::PAUSE, now);
  restart();
  EXPECT_EQ(look(id).tiles_done(), 62u);
  EXPECT_EQ(look(id).tiles_total(), 200u);
  EXPECT_EQ(look(id).tiles_restored(), 62u);
  EXPECT_EQ(look(id).elapsed_seconds(), 62);
  EXPECT_EQ(coordinator.snapshot(now).jobs.at(0).tiles_done, 62u);
}

TEST_F(Progress, TilesOfEqualFramesAreDoneTogether) {
  BlobStore blobs;
  v1::Envelope message = submission(1001, job(160), blobs);
  v1::SubmitJob& request = *message.mutable_submit_job();
  request.set_detached(true);
  for (int i = 0; i < 3; ++i) *request.add_frames() = v1::JobFrame(request.frames(0));
  v1::JobFrame& other = *request.add_frames() = v1::JobFrame(request.frames(0));
  other.mutable_settings()->set_seed(77);
  submit_with(message, blobs, now);
  const uint64_t id = heard(v1::Envelope::kJobStatus).back().job_status().job();
  const auto expect = [&](uint64_t done, uint64_t restored) {
    EXPECT_EQ(look(id).tiles_total(), 500u);
    EXPECT_EQ(look(id).tiles_done(), done);
    EXPECT_EQ(look(id).tiles_restored(), restored);
    EXPECT_EQ(coordinator.snapshot(now).jobs.at(0).tiles_done, done);
  };
  come_now();
  trace(40, seconds(1));
  expect(160, 120);
  EXPECT_NEAR(look(id).remaining_seconds(), 160, 2) << "of two frames";
  start_anew();
  expect(160, 160);
  come_now();
  trace(60, seconds(1));
  for (int i = 0; i < 4; ++i) coordinator.on_tick(now);
  get_ready_in(session);
  EXPECT_EQ(look(id).frames_done(), 4u);
  expect(400, 340);
  trace(40, seconds(1));
  expect(440, 340);
  EXPECT_NEAR(look(id).remaining_seconds(), 60, 2);
}

TEST_F(Progress, IsNotMisledByTilesOfUnequalCosts) {
  const uint64_t id = submit_disc();
  EXPECT_GT(trace_disc(id, kColumns * kColumns, kColumns * kColumns / 10), 1400);
  EXPECT_EQ(left, Time{});
}

TEST_F(Progress, RemembersWhatStoredTilesTook) {
  // The costly tiles come first: those that are left are cheap, which is known at once.
  for (const size_t part : {16u, 4u}) {
    SCOPED_TRACE(part);
    store = std::make_shared<MemoryJobStore>(7);
    start_anew();
    session = 0;
    const uint64_t id = submit_disc();
    trace_disc(id, kColumns * kColumns / part, ~size_t{0});
    const double elapsed = look(id).elapsed_seconds();
    start_anew();
    // And the tile that went beyond.
    EXPECT_GT(look(id).elapsed_seconds(), elapsed - std::clamp(elapsed / 20, 1., 10.) - 1.1);
    come_now();
    EXPECT_GT(trace_disc(id, kColumns * kColumns, 32), 700);
    EXPECT_EQ(left, Time{});
  }
}

TEST_F(Progress, TimeIsKeptInFullWhereTheCoordinatorEnds) {
  const uint64_t id = submit(1, 0, 160, 1, 1, now);
  come_now();
  trace(3, seconds(1));
  coordinator.shut_down("test");
  start_anew();
  EXPECT_EQ(look(id).elapsed_seconds(), 3);
}

TEST_F(Progress, WorkerSecondsAreWhatTilesTook) {
  const uint64_t id = submit(1, 0, 160, 1, 1, now);
  v1::Envelope message = hello(1);
  message.mutable_hello()->set_credit(8);
  message.mutable_hello()->set_threads(1);
  say("w1", message, now);
  ready("w1", first_frame_of(id), now);
  for (size_t i = 0; i < 4; ++i) {
    ASSERT_GT(assigned().size(), i + 1) << "one waits";
    v1::Envelope pixels = band(assigned()[i], 1);
    pixels.mutable_tile_band()->set_trace_microseconds(1'500'000);
    say("w1", pixels, now += seconds(2));
    coordinator.on_tick(now);
  }
  EXPECT_EQ(coordinator.snapshot(now).jobs.at(0).worker_seconds, 6) << "not of tiles that waited";
  // As a crash leaves it.
  start_anew();
  EXPECT_EQ(coordinator.snapshot(now).jobs.at(0).worker_seconds, 6);
  come_now();
  ASSERT_FALSE(assigned().empty());
  v1::Envelope pixels = band(assigned()[0], 1);
  pixels.mutable_tile_band()->set_trace_microseconds(1'500'000);
  say("w1", pixels, now += seconds(2));
  EXPECT_EQ(coordinator.snapshot(now).jobs.at(0).worker_seconds, 7.5);
}

TEST_F(Progress, ASilentWorkerDoesNotWork) {
  const uint64_t id = submit(1, 0, 320, 1, 1, now);
  come_now();
  v1::Envelope second = hello(2);
  second.mutable_hello()->set_credit(1);
  second.mutable_hello()->set_threads(1);
  say("w2", second, now);
  ready("w2", first_frame_of(id), now);
  /// So many seconds in which each of these workers traces a tile a second.
  const auto work = [&](int count, const std::vector<PeerId>& peers) {
    for (int i = 0; i < count; ++i) {
      now += seconds(1);
      for (const PeerId& peer : peers) {
        listen();
        for (size_t at = all.size(); at-- > 0;) {
          if (to[at] != peer || !all[at].has_assign()) continue;
          say(peer, band(all[at].assign(), 1), now);
          break;
        }
      }
      coordinator.on_tick(now);
    }
  };
  work(100, {"w1", "w2"});
  EXPECT_EQ(look(id).tiles_done(), 200u);
  EXPECT_NEAR(look(id).remaining_seconds(), 100, 5);
  work(3, {"w1"});
  EXPECT_NEAR(look(id).remaining_seconds(), 197, 30) << "the other one is suspect";
  work(3, {"w1"});
  EXPECT_NEAR(look(id).remaining_seconds(), 194, 20) << "the other one is lost";
  for (int i = 0; i < 30; ++i) coordinator.on_tick(now += milliseconds(100));
  EXPECT_LT(look(id).remaining_seconds(), 0) << "nobody works";
  const double elapsed = look(id).elapsed_seconds();
  now += seconds(1);
  EXPECT_EQ(look(id).elapsed_seconds(), elapsed);
  work(1, {"w1"});
  EXPECT_NEAR(look(id).remaining_seconds(), 193, 40) << "one is back";
}

TEST_F(Progress, TurnsOfEqualJobsCountForBoth) {
  const uint64_t one = submit(1, 0, 160, 1, 1, now), two = submit(2, 0, 160, 1, 1, now);
  come_now();
  trace(100, seconds(1));
  EXPECT_NEAR(look(one).remaining_seconds(), 100, 15);
  EXPECT_NEAR(look(two).remaining_seconds(), 100, 15);
}

TEST_F(Progress, TheTilesThatAreDoneNeverFallBelowThoseThatAreStored) {
  std::mt19937 random(5);
  const uint64_t id = submit(1, 0, 160, 1, 2, now);
  uint64_t before = 0;
  for (int step = 0; step < 400; ++step) {
    const v1::JobStatus::State state = look(id).state();
    switch (random() % 6) {
      case 0:
        ask(id, v1::JobQuery::PAUSE, now);
        break;
      case 1:
        ask(id, v1::JobQuery::RESUME, now);
        break;
      case 2:
        if (random() % 4 == 0) start_anew();
        break;
      case 3:
        now += seconds(random() % 1000);
        coordinator.on_tick(now);
        break;
      default:
        if (state != v1::JobStatus::PAUSED) come_now();
        trace(random() % 8, milliseconds(100));
    }
    const v1::JobStatus status = look(id);
    ASSERT_GE(status.tiles_done(), before) << step;
    ASSERT_GE(status.tiles_done(), store->tile_count()) << step;
    ASSERT_EQ(coordinator.snapshot(now).jobs.at(0).tiles_done, status.tiles_done());
    before = status.tiles_done();
  }
  EXPECT_GT(before, 50u);
}

}  // namespace
}  // namespace tessera::testing
