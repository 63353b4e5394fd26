// Workers that are told apart by their keys: one key is one voter, however many processes use it.
#include "tests/unit/coordinator/service_fixture.h"

namespace tessera::testing {
namespace {

class Trust : public ServiceTest {
 protected:
  Trust() { restart_with(1, 3); }
  void restart_with(double verify, size_t worker_keys) {
    CoordinatorOptions options;
    options.opening = opening_of(++openings);
    options.verify = verify;
    options.worker_keys = worker_keys;
    coordinator = Coordinator(options, store);
    all.clear();
    to.clear();
    given.clear();
    peers.clear();
  }
  /// A worker comes by the key of that name, and builds whatever it is told of.
  void come_by(const std::string& key, WorkerId id, uint32_t credit = 8) {
    v1::Envelope message = hello(id);
    message.mutable_hello()->set_credit(credit);
    message.mutable_hello()->set_threads(credit);
    message.mutable_hello()->set_process_id(static_cast<uint32_t>(id));
    const PeerId peer = key + std::to_string(id);
    peers[peer] = {Role::worker, key, "key of " + key};
    tell(peer, message);
    build();
  }
  void tell(const PeerId& peer, v1::Envelope message, Time now = {}) {
    collect();
    names.complete(message);
    coordinator.on_message(Channel::control, peer, message, now, peers.at(peer));
    collect();
  }
  void collect() {
    for (auto& out : coordinator.take_outgoing()) {
      names.note(out.message);
      if (out.message.has_job_start()) told.emplace_back(out.peer, out.message.job_start().job());
      if (out.message.has_assign()) given.emplace_back(out.peer, out.message.assign());
      to.push_back(out.peer);
      all.push_back(std::move(out.message));
    }
  }
  void build() {
    while (!told.empty()) {
      const auto [peer, job] = told.front();
      told.pop_front();
      if (!builds) continue;
      v1::Envelope message;
      message.mutable_scene_ready()->set_session(1);
      message.mutable_scene_ready()->set_job(job);
      tell(peer, message);
    }
  }
  /// All that was assigned to workers of that key so far is traced; how many tiles. In the end
  /// `told` is built.
  size_t trace(const std::string& key, float value) {
    collect();
    size_t count = 0;
    for (size_t i = 0; i < given.size();) {
      const auto [peer, assign] = given[i];
      if (peers.at(peer).name != key) {
        ++i;
        continue;
      }
      given.erase(given.begin() + static_cast<ptrdiff_t>(i));
      tell(peer, band(assign, value));
      ++count;
    }
    build();
    return count;
  }
  void trace_all(const std::map<std::string, float>& values) {
    for (size_t traced = 1; traced > 0;) {
      traced = 0;
      for (const auto& [key, value] : values) traced += trace(key, value);
    }
  }
  v1::Envelope failed(uint64_t frame, v1::SceneFailed::Cause cause) const {
    v1::Envelope message;
    message.mutable_scene_failed()->set_session(1);
    message.mutable_scene_failed()->set_job(frame);
    message.mutable_scene_failed()->set_cause(cause);
    message.mutable_scene_failed()->set_text("no such texture");
    return message;
  }
  v1::Envelope background(uint64_t frame, float value) const {
    v1::Envelope message;
    v1::SceneReady& ready = *message.mutable_scene_ready();
    ready.set_session(1);
    ready.set_job(frame);
    for (int channel = 0; channel < 3; ++channel) ready.mutable_unseen()->add_value(value);
    ready.mutable_unseen()->mutable_seen()->set_x1(0);
    return message;
  }
  std::string film_of(uint64_t id) { return ask(id).end().film_digest(); }
  /// The digest of a picture of 32 x 32 pixels that are all the same.
  static std::string plain_film(float value) {
    const std::vector<float> values(32 * 32 * 3, value);
    return Digest::of(std::as_bytes(std::span(values))).hex();
  }
  size_t rejected() { return heard(v1::Envelope::kReject).size(); }

  bool builds = true;
  std::map<PeerId, AllowedKey> peers;
  std::deque<std::pair<PeerId, v1::Assign>> given;
  std::deque<std::pair<PeerId, uint64_t>> told;
};

TEST_F(Trust, ProcessesOfOneKeyDoNotCheckEachOther) {
  const uint64_t id = submit(1);
  come_by("thief", 1);
  come_by("thief", 2);
  come_by("thief", 3);
  trace_all({{"thief", 9}});
  EXPECT_EQ(ask(id).tiles_done(), 4u);
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING) << "nobody else has checked it";
  // Honest workers of two keys outvote them, and the key is out with all its processes.
  come_by("alice", 4);
  come_by("bob", 5);
  trace_all({{"thief", 9}, {"alice", 1}, {"bob", 1}});
  EXPECT_EQ(ask(id).how(), v1::JobEnd::DONE);
  EXPECT_EQ(film_of(id), plain_film(1));
  EXPECT_EQ(rejected(), 3u) << "each of its processes";
  const size_t before = rejected();
  come_by("thief", 6);
  EXPECT_EQ(rejected(), before + 1);
  come_by("alice", 7);
  EXPECT_EQ(rejected(), before + 1);
}

TEST_F(Trust, ASecondCopyByTheSameKeyIsNoCheck) {
  const uint64_t id = submit(1);
  come_by("thief", 1, 4);
  ASSERT_EQ(given.size(), 4u);
  const auto first = given;
  // The first process is lost, and its tiles go to the second; then results of both come.
  coordinator.on_peer_gone("thief1", {});
  come_by("thief", 2, 4);
  for (const auto& [peer, assign] : first) tell("thief1", band(assign, 9));
  trace("thief", 9);
  EXPECT_EQ(ask(id).tiles_done(), 4u);
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING);
}

TEST_F(Trust, ChecksWaitForKeysThatAreBusyWithOtherJobs) {
  const uint64_t other = submit(1, 5, 64);
  come_by("alice", 1, 4);
  come_by("bob", 2, 4);
  const uint64_t id = submit(2);
  come_by("thief", 3, 64);
  trace("thief", 9);
  EXPECT_EQ(ask(other).state(), v1::JobStatus::RUNNING);
  for (int second = 1; second < 20; ++second) {
    for (const char* peer : {"alice1", "bob2", "thief3"}) {
      v1::Envelope heartbeat;
      heartbeat.mutable_heartbeat()->set_session(1);
      for (const auto& [whose, assign] : given) {
        if (whose != peer) continue;
        auto& held = *heartbeat.mutable_heartbeat()->add_progress();
        held.set_job(assign.job());
        held.set_lease(assign.lease());
        held.set_started(true);
        held.set_work_done(static_cast<uint64_t>(second));
      }
      tell(peer, heartbeat, seconds(second));
    }
    coordinator.on_tick(seconds(second));
    collect();
    build();
    trace("thief", 9);
  }
  EXPECT_NE(ask(id).state(), v1::JobStatus::ENDED) << "two honest keys are there, if busy";
}

TEST_F(Trust, OneKeyConvictsNobody) {
  const uint64_t id = submit(1);
  come_by("alice", 1, 4);
  trace("alice", 1);
  come_by("thief", 2, 4);
  come_by("thief", 3, 4);
  trace("thief", 9);
  trace("thief", 9);
  EXPECT_EQ(rejected(), 0u);
  for (int second = 1; second < 30; ++second) {
    for (const auto& [peer, key] : peers) {
      v1::Envelope heartbeat;
      heartbeat.mutable_heartbeat()->set_session(1);
      tell(peer, heartbeat, seconds(second));
    }
    coordinator.on_tick(seconds(second));
    collect();
    build();
  }
  EXPECT_EQ(ask(id).state(), v1::JobStatus::HELD) << "nobody can decide between two";
  EXPECT_THAT(ask(id).failure(), ::testing::HasSubstr("(key of alice)"));
  EXPECT_THAT(ask(id).failure(), ::testing::HasSubstr("no third"));
}

TEST_F(Trust, AKeyThatContradictsItselfFailsNoJob) {
  const uint64_t id = submit(1);
  come_by("thief", 1, 4);
  const auto first = given;
  coordinator.on_peer_gone("thief1", {});
  come_by("thief", 2, 4);
  trace("thief", 8);
  for (const auto& [peer, assign] : first) tell("thief1", band(assign, 9));
  come_by("thief", 3, 4);
  trace_all({{"thief", 7}});
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING);
  come_by("alice", 4);
  come_by("bob", 5);
  trace_all({{"thief", 7}, {"alice", 1}, {"bob", 1}});
  EXPECT_EQ(ask(id).how(), v1::JobEnd::DONE);
  EXPECT_EQ(film_of(id), plain_film(1));
}

TEST_F(Trust, NobodySpeaksUnderAnIdOfAnother) {
  submit(1);
  come_by("alice", 1);
  const size_t before = rejected();
  v1::Envelope reserved = hello(kReservedId | 5);
  peers["m"] = {Role::worker, "mallory", "key of mallory"};
  tell("m", reserved);
  EXPECT_EQ(rejected(), before + 1);
  // Alice's worker is lost, and forgotten after a while; its id stays hers.
  coordinator.on_peer_gone("alice1", {});
  coordinator.on_tick(std::chrono::minutes(20));
  tell("m", hello(1, 9), std::chrono::minutes(20));
  EXPECT_EQ(rejected(), before + 2);
}

TEST_F(Trust, AFrameThatCameLaterHasNoLeasesOfBefore) {
  restart_with(0, 3);
  const uint64_t id = submit(1);
  come_by("thief", 1, 1);
  v1::Assign made_up = given.at(0).second;
  made_up.set_lease(uint64_t{0x7ff} << 52 | 3);
  made_up.set_tile(3);
  v1::Envelope forged = band(made_up, 9);
  forged.mutable_tile_band()->set_opening("of another farm.");
  tell("thief1", forged);
  EXPECT_EQ(ask(id).tiles_done(), 0u);
}

TEST_F(Trust, OneKeysLostBuildersHoldNoJob) {
  const uint64_t id = submit(1);
  builds = false;
  for (WorkerId worker = 1; worker <= 8; ++worker) {
    come_by("thief", worker);
    coordinator.on_peer_gone("thief" + std::to_string(worker), milliseconds(worker));
  }
  builds = true;
  come_by("alice", 20);
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING);
  EXPECT_FALSE(given.empty()) << "she builds it";
}

TEST_F(Trust, ASceneIsCalledWrongByTwoKeys) {
  const uint64_t id = submit(1);
  builds = false;
  come_by("thief", 1);
  come_by("thief", 2);
  const uint64_t frame = first_frame_of(id);
  tell("thief1", failed(frame, v1::SceneFailed::BAD_SCENE));
  tell("thief2", failed(frame, v1::SceneFailed::BAD_SCENE));
  EXPECT_EQ(ask(id).state(), v1::JobStatus::HELD) << "all who are there are one voter";
  EXPECT_THAT(ask(id).failure(), ::testing::HasSubstr("one key alone"));
  builds = true;
  come_by("alice", 3);
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING) << "she is asked";
  come_by("bob", 4);
  trace_all({{"alice", 1}, {"bob", 1}});
  EXPECT_EQ(ask(id).how(), v1::JobEnd::DONE);
  // Where she says the same, it is so.
  const uint64_t next = submit(2);
  const uint64_t next_frame = first_frame_of(next);
  tell("thief1", failed(next_frame, v1::SceneFailed::BAD_SCENE));
  tell("thief2", failed(next_frame, v1::SceneFailed::BAD_SCENE));
  EXPECT_EQ(ask(next).state(), v1::JobStatus::RUNNING);
  tell("alice3", failed(next_frame, v1::SceneFailed::BAD_SCENE));
  EXPECT_EQ(ask(next).how(), v1::JobEnd::FAILED);
  EXPECT_EQ(ask(next).exit_code(), static_cast<uint32_t>(ExitCode::bad_scene));
}

TEST_F(Trust, AKeyAloneGivesNoTileUp) {
  restart_with(0, 3);
  const uint64_t id = submit(1, 0, 16);
  const auto fail_tile = [&] {
    const auto [peer, assign] = given.front();
    given.pop_front();
    v1::Envelope failed;
    failed.mutable_tile_failed()->set_job(assign.job());
    failed.mutable_tile_failed()->set_lease(assign.lease());
    tell(peer, failed);
  };
  for (WorkerId worker = 1; worker <= 4; ++worker) {
    come_by("thief", worker, 1);
    if (!given.empty()) fail_tile();
  }
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING);
  EXPECT_TRUE(given.empty()) << "it is given to that key no more";
  coordinator.on_tick(seconds(1));
  EXPECT_EQ(ask(id).state(), v1::JobStatus::HELD);
  EXPECT_THAT(ask(id).failure(), ::testing::HasSubstr("one key alone, thief"));
  come_by("alice", 5, 1);
  trace_all({{"alice", 1}});
  EXPECT_EQ(ask(id).how(), v1::JobEnd::DONE);
}

TEST_F(Trust, AKeyAloneMakesNoTileGivenUpByVanishingWithIt) {
  restart_with(0, 3);
  const uint64_t id = submit(1, 0, 16);
  for (WorkerId worker = 1; worker <= 40; ++worker) {
    come_by("thief", worker, 1);
    coordinator.on_peer_gone("thief" + std::to_string(worker), {});
  }
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING);
  given.clear();
  come_by("alice", 50, 1);
  trace_all({{"alice", 1}});
  EXPECT_EQ(ask(id).how(), v1::JobEnd::DONE);
}

TEST_F(Trust, ASceneThatCrashesItsBuilderIsBlamedByTwoKeys) {
  const uint64_t id = submit(1);
  builds = false;
  come_by("alice", 1);
  come_by("alice", 2);
  come_by("bob", 3);
  const uint64_t frame = first_frame_of(id);
  tell("alice1", failed(frame, v1::SceneFailed::CRASHED));
  tell("alice2", failed(frame, v1::SceneFailed::CRASHED));
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING);
  tell("bob3", failed(frame, v1::SceneFailed::CRASHED));
  EXPECT_EQ(ask(id).how(), v1::JobEnd::FAILED);
}

TEST_F(Trust, TheBackgroundIsFilledOnceTwoKeysSayTheSame) {
  restart_with(0, 3);
  const uint64_t id = submit(1);
  builds = false;
  come_by("thief", 1, 1);
  come_by("thief", 2, 1);
  const uint64_t frame = first_frame_of(id);
  tell("thief1", background(frame, 9));
  tell("thief2", background(frame, 9));
  EXPECT_EQ(ask(id).tiles_done(), 0u);
  come_by("alice", 3, 1);
  tell("alice3", background(frame, 9));
  EXPECT_EQ(ask(id).tiles_done(), 2u) << "of four, two are being traced";
}

TEST_F(Trust, AConvictionReachesJobsThatHaveEnded) {
  restart_with(0, 3);
  const uint64_t ended = submit(1), other = submit(2);
  come_by("thief", 1);
  for (size_t i = 0; i < given.size(); ++i) {
    if (job_of(given[i].second) == ended) tell("thief1", band(given[i].second, 9));
  }
  EXPECT_EQ(ask(ended).how(), v1::JobEnd::DONE);
  EXPECT_EQ(film_of(ended), plain_film(9));
  EXPECT_EQ(store->jobs().at(0).ends_size(), 1);
  // A coordinator that verifies finds it out in the other job.
  restart_with(1, 3);
  coordinator.on_tick({});
  come_by("thief", 2);
  come_by("alice", 3);
  come_by("bob", 4);
  trace_all({{"thief", 9}, {"alice", 1}, {"bob", 1}});
  EXPECT_EQ(ask(other).how(), v1::JobEnd::DONE);
  EXPECT_EQ(film_of(other), plain_film(1));
  EXPECT_GT(rejected(), 0u);
  EXPECT_EQ(ask(ended).how(), v1::JobEnd::DONE);
  EXPECT_EQ(film_of(ended), plain_film(1)) << "traced again, and checked";
  restart_with(1, 3);
  EXPECT_EQ(film_of(ended), plain_film(1));
}

TEST_F(Trust, ATileFromTheStoreIsCheckedByAnotherKeyThanItsOwn) {
  restart_with(0, 2);
  const uint64_t id = submit(1, 0, 32);
  come_by("thief", 1, 1);
  tell("thief1", band(given.at(0).second, 9));
  ASSERT_EQ(ask(id).tiles_done(), 1u);
  restart_with(1, 2);
  coordinator.on_tick({});
  come_by("thief", 2);
  trace_all({{"thief", 9}});
  EXPECT_EQ(ask(id).tiles_done(), 4u);
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING);
}

TEST_F(Trust, WhereOneKeyAloneIsListedItsProcessesAreCompared) {
  restart_with(1, 1);
  const uint64_t id = submit(1);
  come_by("farm", 1);
  come_by("farm", 2);
  trace_all({{"farm", 1}});
  EXPECT_EQ(ask(id).how(), v1::JobEnd::DONE);
}

}  // namespace
}  // namespace tessera::testing
