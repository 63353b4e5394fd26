// Jobs that lack something for a time, and stores that are not what they were.
#include "tests/unit/coordinator/service_fixture.h"

namespace tessera::testing {
namespace {

class Held : public ServiceTest {
 protected:
  /// A worker comes and says of all scenes that it is told of that it cannot build them.
  void come_in_vain(WorkerId id, v1::SceneFailed::Cause cause) {
    const PeerId peer = "w" + std::to_string(id);
    v1::Envelope message = hello(id);
    message.mutable_hello()->set_credit(8);
    say(peer, message);
    // One is told after the other.
    for (size_t next = told; next < heard(v1::Envelope::kJobStart).size(); ++next) {
      v1::Envelope failed;
      failed.mutable_scene_failed()->set_session(1);
      failed.mutable_scene_failed()->set_job(
          heard(v1::Envelope::kJobStart)[next].job_start().job());
      failed.mutable_scene_failed()->set_cause(cause);
      failed.mutable_scene_failed()->set_text("there is not enough memory for the scene");
      say(peer, failed);
    }
    told = heard(v1::Envelope::kJobStart).size();
  }
  void come_and_build(WorkerId id) {
    const PeerId peer = "w" + std::to_string(id);
    v1::Envelope message = hello(id);
    message.mutable_hello()->set_credit(64);
    message.mutable_hello()->set_threads(64);
    say(peer, message);
    size_t traced = assigned().size();
    for (size_t next = told; next < heard(v1::Envelope::kJobStart).size(); ++next) {
      ready(peer, heard(v1::Envelope::kJobStart)[next].job_start().job());
      for (; traced < assigned().size(); ++traced) say(peer, band(assigned()[traced], 1));
    }
    told = heard(v1::Envelope::kJobStart).size();
  }
  v1::Envelope film_request(const std::string& film) const {
    v1::Envelope request;
    request.mutable_blob_request()->set_digest(film);
    request.mutable_blob_request()->set_length(1 << 20);
    return request;
  }
  size_t told = 0;
};

TEST_F(Held, AJobThatNobodyWhoIsLeftCanBuildIsHeld) {
  const uint64_t job = submit(1);
  const auto come_in_hope = [&](WorkerId id) {
    say("able", hello(id));
    EXPECT_EQ(ask(job).state(), v1::JobStatus::RUNNING) << "this one has not tried";
  };
  come_in_hope(2);
  come_in_vain(1, v1::SceneFailed::CRASHED);
  EXPECT_EQ(ask(job).state(), v1::JobStatus::RUNNING);
  v1::Envelope bye;
  bye.mutable_bye()->set_session(1);
  say("able", bye);
  EXPECT_EQ(ask(job).state(), v1::JobStatus::HELD) << "it left";
  come_in_hope(3);
  coordinator.on_peer_gone("able", {});
  EXPECT_EQ(ask(job).state(), v1::JobStatus::HELD) << "its connection is gone";
  come_in_hope(4);
  for (int second = 1; second <= 6; ++second) {
    v1::Envelope heartbeat;
    heartbeat.mutable_heartbeat()->set_session(1);
    say("w1", heartbeat, seconds(second));
    coordinator.on_tick(seconds(second));
  }
  EXPECT_EQ(ask(job).state(), v1::JobStatus::HELD) << "it fell silent";
}

TEST_F(Held, AWorkerWithoutMemoryHoldsTheQueueUntilAnotherComes) {
  std::vector<uint64_t> jobs;
  for (uint32_t seed = 1; seed <= 20; ++seed) jobs.push_back(submit(seed));
  come_in_vain(1, v1::SceneFailed::OUT_OF_RESOURCES);
  for (const uint64_t job : jobs) {
    EXPECT_EQ(ask(job).state(), v1::JobStatus::HELD) << job;
    EXPECT_THAT(ask(job).failure(), ::testing::HasSubstr("not enough memory")) << job;
  }
  come_and_build(2);
  for (const uint64_t job : jobs) EXPECT_EQ(ask(job).how(), v1::JobEnd::DONE) << job;
}

TEST_F(Held, AWorkerThatFailedOneSceneBuildsTheNext) {
  const uint64_t large = submit(1);
  come_in_vain(1, v1::SceneFailed::OUT_OF_RESOURCES);
  const uint64_t small = submit(2);
  ready("w1", first_frame_of(small));
  for (const v1::Assign& assign : assigned()) say("w1", band(assign, 1));
  EXPECT_EQ(ask(small).how(), v1::JobEnd::DONE);
  EXPECT_EQ(ask(large).state(), v1::JobStatus::HELD);
}

TEST_F(Held, AFrameThatDoesNotFitWaitsByItself) {
  const uint64_t id = submit(1, 0, 32, 1, 4);
  v1::Envelope message = hello(1);
  message.mutable_hello()->set_credit(8);
  message.mutable_hello()->set_threads(8);
  say("w1", message);
  size_t next = 0, traced = 0;
  const auto go_on = [&](const PeerId& peer, bool fits) {
    for (; next < heard(v1::Envelope::kJobStart).size(); ++next) {
      const uint64_t frame = heard(v1::Envelope::kJobStart)[next].job_start().job();
      if (fits || frame != first_frame_of(id) + 1) {
        ready(peer, frame);
        for (; traced < assigned().size(); ++traced) say(peer, band(assigned()[traced], 1));
        continue;
      }
      v1::Envelope failed;
      failed.mutable_scene_failed()->set_session(1);
      failed.mutable_scene_failed()->set_job(frame);
      failed.mutable_scene_failed()->set_cause(v1::SceneFailed::OUT_OF_RESOURCES);
      failed.mutable_scene_failed()->set_text("there is not enough memory for the scene");
      say(peer, failed);
    }
  };
  go_on("w1", false);
  EXPECT_EQ(ask(id).frames_done(), 3u);
  EXPECT_EQ(ask(id).state(), v1::JobStatus::HELD);
  EXPECT_THAT(ask(id).failure(), ::testing::StartsWith("frame 2: there is not enough memory"));
  EXPECT_THAT(ask(id).waits_for(), ::testing::HasSubstr("a worker that can"));
  say("w2", hello(2));
  go_on("w2", true);
  EXPECT_EQ(ask(id).how(), v1::JobEnd::DONE);
}

TEST_F(Held, AJobWhoseSceneCannotBeReadNowWaits) {
  const uint64_t first = submit(1);
  restart();
  store->set_unreadable(true);
  coordinator.on_tick(seconds(1));
  EXPECT_EQ(ask(first).state(), v1::JobStatus::HELD);
  EXPECT_NE(ask(first).failure(), "");
  store->set_unreadable(false);
  coordinator.on_tick(seconds(4));
  EXPECT_EQ(ask(first).state(), v1::JobStatus::RUNNING);
  EXPECT_EQ(ask(first).failure(), "");
}

TEST_F(Held, RetryGoesOnWithWhatIsHeldOrFailed) {
  const uint64_t id = submit(1);
  come_in_vain(1, v1::SceneFailed::BAD_SCENE);
  ASSERT_EQ(ask(id).how(), v1::JobEnd::FAILED);
  ASSERT_EQ(store->jobs().at(0).ends_size(), 1);
  EXPECT_EQ(ask(id, v1::JobQuery::RETRY).state(), v1::JobStatus::QUEUED);
  EXPECT_EQ(store->jobs().at(0).ends_size(), 0) << "also after a restart";
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING);
  come_and_build(2);
  EXPECT_EQ(ask(id).how(), v1::JobEnd::DONE);
  EXPECT_THAT(ask(id, v1::JobQuery::RETRY).failure(), ::testing::HasSubstr("expected one that"));
}

TEST_F(Held, AJobWhoseNumberIsAheadOfTheLastOneCostsNoOtherItsPlace) {
  submit(1);
  v1::KeptJob ahead = store->jobs().at(0);
  ahead.set_job(7);
  ahead.mutable_request()->set_submission(99);
  store->save(ahead);
  store->set_last_job(0);
  restart();
  EXPECT_EQ(submit(2), 8u);
  EXPECT_EQ(coordinator.ask({}, {}).state(), v1::JobStatus::UNKNOWN);
}

TEST_F(Held, TilesInEachOthersPlaceAreTracedAgainToTheSamePicture) {
  const uint64_t id = submit(1);
  come(1, 4);
  float value = 1;
  for (const v1::Assign& assign : assigned()) say("w1", band(assign, value++));
  const std::string film = ask(id).end().film_digest();
  const Digest key = Digest::from_hex(store->jobs().at(0).tile_keys(0));
  const auto swap_two = [&] {
    auto tiles = store->find(key);
    std::swap(tiles[0].kept, tiles[1].kept);
    for (FinishedTile& tile : tiles) {
      for (v1::TileBand& moved : *tile.kept.mutable_bands()) moved.set_first_row(tile.rect.y0);
      store->keep(key, tile);
    }
  };
  const auto retrace = [&](float first) {
    restart();
    coordinator.on_message(Channel::bulk, "b", film_request(film), {});
    EXPECT_EQ(heard(v1::Envelope::kBlobMissing).size(), 1u);
    coordinator.on_tick(seconds(1));
    EXPECT_EQ(ask(id).tiles_restored(), 0u) << "which of them are wrong nobody knows";
    come(1, 4);
    for (const v1::Assign& assign : assigned()) {
      say("w1", band(assign, first + static_cast<float>(assign.tile())));
    }
  };
  swap_two();
  retrace(1);
  EXPECT_EQ(ask(id).end().film_digest(), film);
  EXPECT_EQ(ask(id).how(), v1::JobEnd::DONE);
  // Where it becomes another picture, that does not take the place of the first without a word.
  swap_two();
  retrace(5);
  EXPECT_EQ(ask(id).how(), v1::JobEnd::FAILED);
  EXPECT_THAT(ask(id).failure(), ::testing::HasSubstr(film));
}

TEST_F(Held, AFrameThatIsComputedOtherwiseByNowBeginsAnew) {
  const uint64_t id = submit(1);
  come(1, 1);
  say("w1", band(assigned().at(0), 1));
  EXPECT_EQ(store->tile_count(), 1u);
  // As if the program that accepted it had computed otherwise.
  v1::KeptJob kept = store->jobs().at(0);
  const Digest now = Digest::from_hex(kept.tile_keys(0)), before = Digest::of("other numerics");
  for (const FinishedTile& tile : store->find(now)) store->keep(before, tile);
  store->drop_all(now);
  kept.set_tile_keys(0, before.hex());
  store->save(kept);
  restart();
  coordinator.on_tick({});
  EXPECT_EQ(store->tile_count(), 0u) << "nothing can be made of the old ones";
  come(1, 4);
  for (const v1::Assign& assign : assigned()) say("w1", band(assign, 1));
  ASSERT_EQ(ask(id).how(), v1::JobEnd::DONE);
  restart();
  coordinator.on_message(Channel::bulk, "b", film_request(ask(id).end().film_digest()), {});
  EXPECT_EQ(heard(v1::Envelope::kBlobChunk).size(), 1u);
  ask(id, v1::JobQuery::FORGET);
  EXPECT_EQ(store->tile_count(), 0u);
}

}  // namespace
}  // namespace tessera::testing
