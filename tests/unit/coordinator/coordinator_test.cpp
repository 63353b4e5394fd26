#include "coordinator/coordinator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/wire/pixels.h"

namespace tessera {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class CoordinatorTest : public ::testing::Test {
 protected:
  static JobSpec job(int side = 32) {
    JobSpec spec;
    spec.frame.set_width(static_cast<uint32_t>(side));
    spec.frame.set_height(static_cast<uint32_t>(side));
    spec.frame.set_samples_per_pixel(1);
    spec.crop = {0, 0, side, side};
    spec.tile_size = 16;
    return spec;
  }

  v1::Envelope hello(WorkerId id, uint64_t session = 1) const {
    v1::Envelope message;
    v1::Hello& hello = *message.mutable_hello();
    hello.set_protocol_major(kProtocolMajor);
    hello.set_numerics_id(kNumericsId);
    hello.set_worker_id(id);
    hello.set_session(session);
    hello.set_credit(2);
    return message;
  }

  void say(const PeerId& peer, const v1::Envelope& message, Time now = {}) {
    coordinator.on_message(Channel::control, peer, message, now);
  }

  /// All that was said since last asked, by kind.
  std::vector<v1::Envelope> heard(v1::Envelope::MessageCase kind) {
    for (auto& out : coordinator.take_outgoing()) all.push_back(std::move(out.message));
    std::vector<v1::Envelope> result;
    for (const auto& message : all) {
      if (message.message_case() == kind) result.push_back(message);
    }
    return result;
  }

  uint64_t job_id() { return heard(v1::Envelope::kJobStart).back().job_start().job(); }

  void ready(const PeerId& peer, uint64_t job, Time now = {}) {
    v1::Envelope message;
    message.mutable_scene_ready()->set_session(1);
    message.mutable_scene_ready()->set_job(job);
    say(peer, message, now);
  }

  static v1::Envelope band(const v1::Assign& assign, float value) {
    const std::vector<float> values(16 * 16 * 3, value);
    v1::Envelope message;
    v1::TileBand& band = *message.mutable_tile_band();
    band = encode_bands(values, 16, assign.rect().y0(), false)[0];
    band.set_job(assign.job());
    band.set_lease(assign.lease());
    band.set_tile(assign.tile());
    return message;
  }

  Coordinator coordinator{CoordinatorOptions{}};
  std::vector<v1::Envelope> all;
};

TEST_F(CoordinatorTest, TakesAJobFromHelloToPicture) {
  const uint64_t id = coordinator.submit(job(), {});
  say("p", hello(1));
  EXPECT_EQ(heard(v1::Envelope::kWelcome).size(), 1u);
  EXPECT_EQ(job_id(), id);
  EXPECT_TRUE(heard(v1::Envelope::kAssign).empty()) << "before the scene is ready";
  ready("p", id);
  EXPECT_EQ(heard(v1::Envelope::kAssign).size(), 2u) << "as many as its credit";
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_FALSE(coordinator.take_result(id));
    const auto assigns = heard(v1::Envelope::kAssign);
    ASSERT_GT(assigns.size(), i);
    say("p", band(assigns[i].assign(), static_cast<float>(i)));
  }
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.end, JobReport::End::done);
  EXPECT_EQ(result->report.tiles_done, 4u);
  EXPECT_FALSE(coordinator.take_result(id));
  EXPECT_EQ(heard(v1::Envelope::kCancelJob).size(), 1u);
}

TEST_F(CoordinatorTest, AsksStrangersForAHello) {
  v1::Envelope message;
  message.mutable_heartbeat()->set_session(1);
  say("stranger", message);
  EXPECT_EQ(heard(v1::Envelope::kHelloRequest).size(), 1u);
}

TEST_F(CoordinatorTest, TakesNoPixelsFromStrangers) {
  const uint64_t id = coordinator.submit(job(), {});
  say("p", hello(1));
  ready("p", id);
  const auto assigns = heard(v1::Envelope::kAssign);
  say("stranger", band(assigns[0].assign(), 9));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 0u);
}

TEST_F(CoordinatorTest, ALocalProcessThatEndedIsNoticedAtOnce) {
  const uint64_t id = coordinator.submit(job(), {});
  v1::Envelope first = hello(1);
  first.mutable_hello()->set_process_id(77);
  say("p", first);
  say("q", hello(2));
  ready("p", id);
  ready("q", id);
  EXPECT_EQ(heard(v1::Envelope::kAssign).size(), 4u);
  coordinator.on_process_ended(77, false, "was killed", milliseconds(1));
  EXPECT_EQ(coordinator.progress({}).workers, 1);
  const auto assigns = heard(v1::Envelope::kAssign);
  say("q", band(assigns[2].assign(), 1), milliseconds(2));
  say("q", band(assigns[3].assign(), 1), milliseconds(2));
  EXPECT_EQ(heard(v1::Envelope::kAssign).size(), 6u) << "what the dead one held";
}

TEST_F(CoordinatorTest, TellsTheJobAgainToAWorkerThatMissedIt) {
  const uint64_t id = coordinator.submit(job(), {});
  say("p", hello(1));
  const size_t told = heard(v1::Envelope::kJobStart).size();
  v1::Envelope heartbeat;
  heartbeat.mutable_heartbeat()->set_session(1);
  say("p", heartbeat, seconds(2));
  EXPECT_EQ(heard(v1::Envelope::kJobStart).size(), told + 1);
  EXPECT_EQ(heard(v1::Envelope::kPing).size(), 1u);
  // And takes its word that it is ready, though SceneReady was lost.
  heartbeat.mutable_heartbeat()->set_job(id);
  heartbeat.mutable_heartbeat()->set_ready(true);
  say("p", heartbeat, seconds(3));
  EXPECT_EQ(heard(v1::Envelope::kAssign).size(), 2u);
}

TEST_F(CoordinatorTest, ServesTheScenesBlobs) {
  JobSpec spec = job();
  const Digest digest = spec.blobs.put(std::vector<std::byte>(10, std::byte{3}));
  coordinator.submit(spec, {});
  v1::Envelope request;
  request.mutable_blob_request()->set_digest(digest.hex());
  request.mutable_blob_request()->set_length(100);
  coordinator.on_message(Channel::bulk, "b", request, {});
  EXPECT_EQ(heard(v1::Envelope::kBlobChunk)[0].blob_chunk().data(), std::string(10, '\3'));
  request.mutable_blob_request()->set_digest("../etc/passwd");
  coordinator.on_message(Channel::bulk, "b", request, {});
  EXPECT_EQ(heard(v1::Envelope::kBlobMissing).size(), 1u);
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
}

TEST_F(CoordinatorTest, JobsThatCannotBeAreRefused) {
  const auto refused = [&](auto change) {
    JobSpec spec = job();
    change(spec);
    EXPECT_THROW(coordinator.submit(spec, {}), Error);
  };
  refused([](JobSpec& spec) { spec.frame.set_width(0); });
  refused([](JobSpec& spec) { spec.frame.set_width(1000000000); });
  refused([](JobSpec& spec) { spec.crop = {0, 0, 33, 32}; });
  refused([](JobSpec& spec) { spec.crop = {5, 5, 5, 9}; });
  refused([](JobSpec& spec) { spec.crop = {-1, 0, 5, 9}; });
  refused([](JobSpec& spec) { spec.tile_size = -1; });
  refused([](JobSpec& spec) { spec.frame.set_samples_per_pixel(0); });
}

TEST_F(CoordinatorTest, InterruptsQueuedJobsToo) {
  const uint64_t first = coordinator.submit(job(), {}), second = coordinator.submit(job(), {});
  coordinator.interrupt(second, {});
  EXPECT_EQ(coordinator.take_result(second)->report.exit_code, ExitCode::interrupted);
  EXPECT_FALSE(coordinator.take_result(first));
  coordinator.interrupt(first, {});
  EXPECT_EQ(coordinator.take_result(first)->report.holes.size(), 4u);
}

}  // namespace
}  // namespace tessera
