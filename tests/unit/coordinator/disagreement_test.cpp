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
  say("r", band(*third, 3));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 1u);
  coordinator.interrupt(id, {});
  const auto result = coordinator.take_result(id);
  const auto& rect = tile.rect();
  const size_t pixel = static_cast<size_t>(rect.y0() * 32 + rect.x0()) * 3;
  EXPECT_EQ(result->film.values()[pixel], 3);
  EXPECT_EQ(result->report.mismatches, 1u);
}

TEST_F(Disagreement, ThatPersistsFailsTheJobAndNamesBoth) {
  const size_t count = heard(v1::Envelope::kAssign).size();
  say("q", band(second, 2));
  for (const WorkerId worker : {3, 4}) {
    const PeerId peer = worker == 3 ? "r" : "s";
    v1::Envelope message = hello(worker);
    message.mutable_hello()->set_process_id(static_cast<uint32_t>(worker));
    say(peer, message);
    ready(peer, id);
    if (worker == 3) coordinator.on_peer_gone("r", {});
  }
  const auto assigns = heard(v1::Envelope::kAssign);
  std::vector<v1::Assign> leases;
  for (size_t i = count; i < assigns.size(); ++i) {
    if (assigns[i].assign().tile() == tile.tile()) leases.push_back(assigns[i].assign());
  }
  ASSERT_EQ(leases.size(), 2u);
  say("r", band(leases[0], 3));
  say("s", band(leases[1], 4));
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.exit_code, ExitCode::render_failed);
  EXPECT_THAT(result->report.failure, ::testing::HasSubstr("worker:3"));
  EXPECT_THAT(result->report.failure, ::testing::HasSubstr("worker:4"));
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

}  // namespace
}  // namespace tessera::testing
