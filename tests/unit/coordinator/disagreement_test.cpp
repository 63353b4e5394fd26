// Workers that trace different pixels.
#include "base/log.h"
#include "tests/unit/coordinator/coordinator_fixture.h"

namespace tessera::testing {
namespace {

class Disagreement : public CoordinatorTest {
 protected:
  /// Two workers trace the first tile and get different pixels.
  void SetUp() override {
    spdlog::set_level(spdlog::level::off);
    id = coordinator.submit(job(), {});
    say("p", hello(1));
    ready("p", id);
    tile = heard(v1::Envelope::kAssign).at(0).assign();
    coordinator.on_peer_gone("p", {});
    say("q", hello(2));
    ready("q", id);
    for (const auto& message : heard(v1::Envelope::kAssign)) {
      if (message.assign().tile() == tile.tile()) second = message.assign();
    }
    ASSERT_NE(second.lease(), tile.lease());
    say("p", band(tile, 1));
    EXPECT_EQ(coordinator.progress({}).tiles_done, 1u);
  }
  /// The first lease of the tile after `count` assignments.
  std::optional<v1::Assign> again(size_t count) {
    const auto assigns = heard(v1::Envelope::kAssign);
    for (size_t i = count; i < assigns.size(); ++i) {
      if (assigns[i].assign().tile() == tile.tile()) return assigns[i].assign();
    }
    return std::nullopt;
  }
  uint64_t id = 0;
  v1::Assign tile, second;
};

TEST_F(Disagreement, IsDecidedByAThird) {
  const size_t count = heard(v1::Envelope::kAssign).size();
  say("q", band(second, 2));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 0u) << "neither counts";
  say("p", band(tile, 1));
  say("q", band(second, 2));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 0u) << "nor do they later";
  EXPECT_FALSE(again(count));
  say("r", hello(3));
  ready("r", id);
  const auto third = again(count);
  ASSERT_TRUE(third);
  say("r", band(*third, 1));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 1u);
  // Who was wrong is out, and stays out.
  ASSERT_FALSE(heard(v1::Envelope::kReject).empty());
  EXPECT_EQ(heard(v1::Envelope::kReject).back().reject().reason(), v1::Reject::QUARANTINED);
  EXPECT_THAT(heard(v1::Envelope::kReject).back().reject().text(),
              ::testing::HasSubstr("traced wrong pixels"));
  const size_t rejects = heard(v1::Envelope::kReject).size();
  say("q", hello(2, 2));
  EXPECT_EQ(heard(v1::Envelope::kReject).size(), rejects + 1);
  coordinator.interrupt(id, {});
  const auto result = coordinator.take_result(id);
  const auto& rect = tile.rect();
  const size_t pixel = static_cast<size_t>(rect.y0() * 32 + rect.x0()) * 3;
  EXPECT_EQ(result->film.values()[pixel], 1);
  EXPECT_EQ(result->report.mismatches, 1u);
  EXPECT_EQ(result->report.liars, 1u);
}

TEST_F(Disagreement, TheTilesOfWhoWasWrongAreTracedAgain) {
  // It has traced another tile, which is in the film by now.
  std::optional<v1::Assign> other;
  for (const auto& message : heard(v1::Envelope::kAssign)) {
    if (message.assign().tile() != tile.tile()) other = message.assign();
  }
  ASSERT_TRUE(other);
  const auto leases = [&] {
    size_t count = 0;
    for (const auto& message : heard(v1::Envelope::kAssign)) {
      count += message.assign().tile() == other->tile() ? 1 : 0;
    }
    return count;
  };
  say("q", band(*other, 9));
  say("q", band(second, 2));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 1u);
  const size_t count = heard(v1::Envelope::kAssign).size(), of_other = leases();
  v1::Envelope third = hello(3);
  third.mutable_hello()->set_credit(4);
  third.mutable_hello()->set_threads(4);
  say("r", third);
  ready("r", id);
  say("r", band(*again(count), 1));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 1u) << "that of the third alone";
  EXPECT_EQ(leases(), of_other + 1);
  coordinator.interrupt(id, {});
  const auto result = coordinator.take_result(id);
  EXPECT_EQ(result->report.retraced, 1u);
  EXPECT_EQ(result->report.liars, 1u);
}

TEST_F(Disagreement, OfThreeFailsTheJobAndNamesThem) {
  const size_t count = heard(v1::Envelope::kAssign).size();
  say("q", band(second, 2));
  v1::Envelope message = hello(3);
  message.mutable_hello()->set_process_id(3);
  say("r", message);
  ready("r", id);
  say("r", band(*again(count), 3));
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.exit_code, ExitCode::render_failed);
  EXPECT_THAT(result->report.failure, ::testing::HasSubstr("worker:3"));
  EXPECT_THAT(result->report.failure, ::testing::HasSubstr("three different"));
}

TEST_F(Disagreement, ThatNobodyCanDecideFailsTheJob) {
  say("q", band(second, 2));
  v1::Envelope heartbeat;
  heartbeat.mutable_heartbeat()->set_session(1);
  heartbeat.mutable_heartbeat()->add_jobs()->set_job(id);
  for (int second_of_time = 1; second_of_time <= 10; ++second_of_time) {
    EXPECT_FALSE(coordinator.take_result(id));
    say("q", heartbeat, seconds(second_of_time));
    coordinator.on_tick(seconds(second_of_time));
  }
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_THAT(result->report.failure, ::testing::HasSubstr("no third"));
}

class UnseenDisagreement : public CoordinatorTest {
 protected:
  UnseenDisagreement() { spdlog::set_level(spdlog::level::off); }
  /// Says that all but the first `seen_side` pixels of each row and column are of that value.
  v1::Envelope built(int seen_side, float value) const {
    v1::Envelope message;
    v1::SceneReady& ready = *message.mutable_scene_ready();
    ready.set_session(1);
    ready.set_job(id);
    for (int channel = 0; channel < 3; ++channel) ready.mutable_unseen()->add_value(value);
    ready.mutable_unseen()->mutable_seen()->set_x1(seen_side);
    ready.mutable_unseen()->mutable_seen()->set_y1(seen_side);
    return message;
  }
  void come(const PeerId& peer, WorkerId worker, int seen_side, float value) {
    say(peer, hello(worker));
    say(peer, built(seen_side, value));
  }
  /// All who are given tiles trace them, until there is nothing left.
  void trace_all(float value) {
    for (listen(); traced < all.size(); ++traced) {
      if (all[traced].has_assign()) say(to[traced], band(all[traced].assign(), value));
      listen();
    }
  }
  uint64_t done() const { return coordinator.progress({}).tiles_done; }
  uint64_t id = 0;
  size_t traced = 0;  ///< of `all`, so far
};

TEST_F(UnseenDisagreement, IsNoneWhereBothSayTheSame) {
  id = coordinator.submit(job(), {});
  come("p", 1, 16, 1);
  EXPECT_EQ(done(), 3u);
  come("q", 2, 16, 1);
  say("q", built(16, 1));
  EXPECT_EQ(done(), 3u);
  say("p", band(heard(v1::Envelope::kAssign).at(0).assign(), 5));
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.filled, 3u);
  EXPECT_EQ(result->report.mismatches, 0u);
}

TEST_F(UnseenDisagreement, HasAllTracedAndLookedAtByAnother) {
  for (const auto& [side, value] : {std::pair(16, 2.0f), {32, 1.0f}}) {
    id = coordinator.submit(job(), {});
    come("p", 1, 16, 1);
    EXPECT_EQ(done(), 3u);
    come("q", 2, side, value);
    EXPECT_EQ(done(), 0u) << "neither is believed";
    come("r", 3, 16, 1);
    EXPECT_EQ(done(), 0u) << "nor is a third";
    trace_all(5);
    const auto result = coordinator.take_result(id);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->report.filled, 0u);
    EXPECT_EQ(result->report.mismatches, 1u);
    EXPECT_GT(result->report.verified, 0u) << "what the two have traced";
    for (const float channel : result->film.values()) ASSERT_EQ(channel, 5);
  }
}

}  // namespace
}  // namespace tessera::testing
