// What failures count against: the scene, a worker or its key.
#include <limits>

#include "coordinator/tiles/tile_store.h"
#include "proto/wire/blob_transfer.h"
#include "tests/unit/coordinator/coordinator_fixture.h"

namespace tessera::testing {
namespace {

TEST_F(CoordinatorTest, OneWorkerIsNotBelievedThatASceneIsBad) {
  const auto failed = [](uint64_t id) {
    v1::Envelope message;
    message.mutable_scene_failed()->set_session(1);
    message.mutable_scene_failed()->set_job(id);
    message.mutable_scene_failed()->set_cause(v1::SceneFailed::BAD_SCENE);
    message.mutable_scene_failed()->set_text("bad");
    return message;
  };
  const uint64_t id = coordinator.submit(job(), {});
  say("p", hello(1));
  say("q", hello(2));
  say("p", failed(id));
  say("p", failed(id));
  EXPECT_FALSE(coordinator.take_result(id)) << "the other has not said it";
  say("q", failed(id));
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.exit_code, ExitCode::bad_scene);
  // The last one there is believed, also when the other goes after it spoke.
  const uint64_t next = coordinator.submit(job(), {});
  say("p", failed(next));
  coordinator.on_peer_gone("q", {});
  say("p", failed(next));
  ASSERT_TRUE(coordinator.take_result(next));
}

/// What is kept in it cannot be read.
class DamagedTiles final : public TileStore {
 public:
  void keep(const Digest&, const FinishedTile&) override {}
  void drop(const Digest&, const PixelRect&) override {}
  void drop_all(const Digest&) override {}
  std::vector<FinishedTile> find(const Digest&) override { throw render_error("damaged"); }
};

TEST_F(CoordinatorTest, AJobOfThisProcessFailsWhoseTilesCannotBeRead) {
  const uint64_t id = coordinator.submit(job(), {}, std::make_shared<DamagedTiles>());
  say("p", hello(1));
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.failure, "damaged");
  EXPECT_EQ(result->report.holes, std::vector{job().crop});
  EXPECT_EQ(result->film.rect(), job().crop);
}

TEST_F(CoordinatorTest, AJobThatEndsWorkersWhileTheyBuildEnds) {
  const uint64_t id = coordinator.submit(job(), {});
  const auto come_and_go = [&](WorkerId worker, Time now) {
    const PeerId peer = "p" + std::to_string(worker);
    say(peer, hello(worker), now);
    coordinator.on_peer_gone(peer, now + milliseconds(500));
  };
  for (int i = 1; i <= 4; ++i) come_and_go(static_cast<WorkerId>(i), seconds(i));
  EXPECT_FALSE(coordinator.take_result(id));
  come_and_go(5, seconds(5));
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.exit_code, ExitCode::render_failed);
  EXPECT_EQ(result->report.failure,
            "5 workers, one after the other, were lost while they built the scene, and none has "
            "built it; it may take more memory than they have: 'tessera retry' tries again");
}

TEST_F(CoordinatorTest, ASceneThatCrashesTwoLocalProcessesThatBuildItFails) {
  const uint64_t id = coordinator.submit(job(), {});
  const auto crash = [&](uint32_t process) {
    v1::Envelope message = hello(process);
    message.mutable_hello()->set_process_id(process);
    say("p" + std::to_string(process), message);
    const std::string how = "process " + std::to_string(process) + " ended with signal 11 (SEGV)";
    coordinator.on_process_ended(static_cast<pid_t>(process), true, how, {});
  };
  crash(77);
  EXPECT_FALSE(coordinator.take_result(id)) << "though nobody is left who could build it";
  crash(78);
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.exit_code, ExitCode::render_failed);
  EXPECT_EQ(result->report.failure,
            "building the scene ended the worker's process: process 78 ended with signal 11 "
            "(SEGV); that happened to 2 workers");
}

TEST_F(CoordinatorTest, ASceneThatOneHasBuiltIsNotBlamedForCrashes) {
  const auto crash = [&](uint64_t id, WorkerId worker) {
    const PeerId peer = "p" + std::to_string(worker);
    say(peer, hello(worker));
    v1::Envelope message;
    message.mutable_scene_failed()->set_session(1);
    message.mutable_scene_failed()->set_job(id);
    message.mutable_scene_failed()->set_cause(v1::SceneFailed::CRASHED);
    say(peer, message);
  };
  const uint64_t id = coordinator.submit(job(), {});
  say("q", hello(1));
  ready("q", id);
  for (WorkerId worker = 2; worker <= 5; ++worker) crash(id, worker);
  EXPECT_FALSE(coordinator.take_result(id));
}

TEST_F(CoordinatorTest, AJobIsNotBlamedForWorkersThatAreLostOtherwise) {
  const uint64_t id = coordinator.submit(job(), {});
  const auto peer = [](int worker) { return "p" + std::to_string(worker); };
  const auto come = [&](int worker, Time now) {
    say(peer(worker), hello(static_cast<WorkerId>(worker)), now);
  };
  const auto go = [&](int worker, Time now) { coordinator.on_peer_gone(peer(worker), now); };
  // A cable is drawn.
  for (int i = 1; i <= 20; ++i) come(i, seconds(1));
  for (int i = 1; i <= 20; ++i) go(i, seconds(2) + milliseconds(i));
  // One comes back each time.
  for (int i = 3; i <= 20; ++i) come(21, seconds(i)), go(21, seconds(i) + milliseconds(500));
  EXPECT_FALSE(coordinator.take_result(id));
  // They leave.
  for (int i = 31; i <= 50; ++i) {
    come(i, seconds(i));
    v1::Envelope bye;
    bye.mutable_bye()->set_session(1);
    say(peer(i), bye, seconds(i));
  }
  EXPECT_FALSE(coordinator.take_result(id));
  // It has been built.
  come(51, seconds(51));
  ready(peer(51), id, seconds(52));
  for (int i = 61; i <= 80; ++i) come(i, seconds(i)), go(i, seconds(i) + milliseconds(500));
  EXPECT_FALSE(coordinator.take_result(id));
}

TEST_F(CoordinatorTest, ThreeFailedTilesSetAWorkerAsideAsLongAsThereIsAnother) {
  const uint64_t id = coordinator.submit(job(64), {});
  say("p", hello(1));
  say("q", hello(2));
  ready("p", id);
  for (size_t i = 0; i < 3; ++i) {
    const v1::Assign assign = heard(v1::Envelope::kAssign)[i].assign();
    v1::Envelope failed;
    failed.mutable_tile_failed()->set_job(id);
    failed.mutable_tile_failed()->set_lease(assign.lease());
    failed.mutable_tile_failed()->set_tile(assign.tile());
    say("p", failed);
  }
  ASSERT_EQ(heard(v1::Envelope::kReject).size(), 1u);
  EXPECT_EQ(heard(v1::Envelope::kReject)[0].reject().reason(), v1::Reject::QUARANTINED);
  EXPECT_EQ(coordinator.progress({}).workers, 1);
  // Whatever else it says.
  const size_t assigns = heard(v1::Envelope::kAssign).size();
  ready("p", id);
  v1::Envelope heartbeat;
  heartbeat.mutable_heartbeat()->set_session(1);
  heartbeat.mutable_heartbeat()->add_jobs()->set_job(id);
  say("p", heartbeat);
  say("p", hello(1, 2));
  EXPECT_EQ(heard(v1::Envelope::kReject).size(), 4u);
  EXPECT_EQ(heard(v1::Envelope::kAssign).size(), assigns);
  EXPECT_EQ(coordinator.progress({}).workers, 1);
}

TEST_F(CoordinatorTest, AKeyWhoseWorkersFailUnderManyIdsIsSetAside) {
  const AllowedKey alice{Role::worker, "alice", "aa"}, mallory{Role::worker, "mallory", "bb"};
  const uint64_t id = coordinator.submit(job(64), {});
  say("a", hello(100), {}, alice);
  for (WorkerId worker = 1; worker <= 3; ++worker) {
    const PeerId peer = "m" + std::to_string(worker);
    say(peer, hello(worker), {}, mallory);
    const size_t told = heard(v1::Envelope::kAssign).size();
    ready(peer, id);
    const v1::Assign assign = heard(v1::Envelope::kAssign).at(told).assign();
    v1::Envelope failed;
    failed.mutable_tile_failed()->set_job(id);
    failed.mutable_tile_failed()->set_lease(assign.lease());
    say(peer, failed);
    v1::Envelope bye;
    bye.mutable_bye()->set_session(1);
    if (worker < 3) say(peer, bye);
  }
  EXPECT_EQ(coordinator.progress({}).workers, 1);
  const size_t before = heard(v1::Envelope::kReject).size();
  say("m4", hello(4), {}, mallory);
  ASSERT_EQ(heard(v1::Envelope::kReject).size(), before + 1);
  EXPECT_EQ(heard(v1::Envelope::kReject).back().reject().reason(), v1::Reject::QUARANTINED);
  coordinator.forgive_keys();
  say("m5", hello(5), {}, mallory);
  EXPECT_EQ(coordinator.progress({}).workers, 2);
}

TEST_F(CoordinatorTest, AKeyThatOthersShareIsNotSetAside) {
  const AllowedKey farm{Role::worker, "farm", "aa"}, alice{Role::worker, "alice", "bb"};
  const uint64_t id = coordinator.submit(job(64), {});
  say("p", hello(1), {}, farm);
  say("q", hello(2), {}, farm);
  say("a", hello(3), {}, alice);
  ready("p", id);
  for (size_t i = 0; i < 3; ++i) {
    v1::Envelope failed;
    failed.mutable_tile_failed()->set_job(id);
    failed.mutable_tile_failed()->set_lease(heard(v1::Envelope::kAssign)[i].assign().lease());
    say("p", failed);
  }
  EXPECT_EQ(heard(v1::Envelope::kReject).size(), 1u);
  EXPECT_EQ(coordinator.progress({}).workers, 2);
}

TEST_F(CoordinatorTest, AWorkerWhoseThreadsHangInWhatItHoldsNoLongerIsSetAside) {
  const uint64_t id = coordinator.submit(job(64), {});
  say("p", hello(1));
  say("q", hello(2));
  ready("p", id);
  bool set_aside = false;
  // Its heart beats, it lists what it was given, and begins with none of it.
  for (int second = 1; second <= 60 && !set_aside; ++second) {
    const Time now = seconds(second);
    v1::Envelope heartbeat;
    heartbeat.mutable_heartbeat()->set_session(1);
    auto& known = *heartbeat.mutable_heartbeat()->add_jobs();
    known.set_job(id);
    known.set_ready(true);
    std::map<uint64_t, bool> held;
    for (const auto& message : heard(v1::Envelope::kAssign)) held[message.assign().lease()] = true;
    for (const auto& message : heard(v1::Envelope::kCancelTile))
      held.erase(message.cancel_tile().lease());
    // The newest are those that it may hold.
    size_t listed = 0;
    for (auto it = held.rbegin(); it != held.rend() && listed < 2; ++it, ++listed) {
      auto& progress = *heartbeat.mutable_heartbeat()->add_progress();
      progress.set_job(id);
      progress.set_lease(it->first);
    }
    say("p", heartbeat, now);
    v1::Envelope other;
    other.mutable_heartbeat()->set_session(1);
    say("q", other, now);
    coordinator.on_tick(now);
    set_aside = !heard(v1::Envelope::kReject).empty();
    if (second < 20) {
      EXPECT_FALSE(set_aside) << "not for the first time";
    }
  }
  EXPECT_TRUE(set_aside);
  EXPECT_EQ(coordinator.progress({}).workers, 1);
}

TEST_F(CoordinatorTest, PixelsThatAreNotFiniteCountAgainstTheirWorker) {
  const uint64_t id = coordinator.submit(job(64), {});
  for (const WorkerId worker : {1, 2}) {
    const PeerId peer = worker == 1 ? "p" : "q";
    say(peer, hello(worker));
    ready(peer, id);
    if (worker == 1) continue;
    // The first two that each was given are its own; all bad ones count.
    for (int i = 0; i < 3; ++i) {
      const auto assigns = heard(v1::Envelope::kAssign);
      for (const auto& assign : assigns) {
        say("p", band(assign.assign(), std::numeric_limits<float>::quiet_NaN()));
      }
    }
  }
  const auto rejects = heard(v1::Envelope::kReject);
  ASSERT_FALSE(rejects.empty());
  EXPECT_EQ(rejects.front().reject().reason(), v1::Reject::QUARANTINED);
  EXPECT_EQ(coordinator.progress({}).tiles_done, 0u);
}

TEST_F(CoordinatorTest, OnlyWhoHoldsATileSaysWhyItFailed) {
  const uint64_t id = coordinator.submit(job(16), {});
  for (const auto& [peer, worker] : {std::pair("p", 1), {"q", 2}, {"r", 3}}) {
    say(peer, hello(static_cast<WorkerId>(worker)));
    ready(peer, id);
  }
  const auto failed = [&](LeaseId lease, const char* text) {
    v1::Envelope message;
    message.mutable_tile_failed()->set_job(id);
    message.mutable_tile_failed()->set_lease(lease);
    message.mutable_tile_failed()->set_text(text);
    return message;
  };
  for (const char* holder : {"p", "q", "r"}) {
    const v1::Assign assign = heard(v1::Envelope::kAssign).back().assign();
    const LeaseId lease = assign.lease();
    for (const char* peer : {"p", "q", "r"}) {
      if (std::string(peer) != holder) say(peer, failed(lease, "made up"));
    }
    say(holder, failed(lease + 1, "made up"));
    if (*holder != 'r') {
      say(holder, failed(lease, "no memory"));
      say(holder, failed(lease, "made up"));
      continue;
    }
    // Of the third failure there is no word.
    v1::Envelope damaged = band(assign, 1);
    damaged.mutable_tile_band()->set_pixel_crc(1);
    say(holder, damaged);
  }
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_THAT(result->report.failure, ::testing::HasSubstr("no memory"));
}

}  // namespace
}  // namespace tessera::testing
