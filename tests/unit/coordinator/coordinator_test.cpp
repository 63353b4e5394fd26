#include <limits>

#include "proto/wire/blob_transfer.h"
#include "tests/unit/coordinator/coordinator_fixture.h"

namespace tessera::testing {
namespace {

TEST_F(CoordinatorTest, WelcomesAWorkerBeforeItTellsOfJobs) {
  coordinator.submit(job(), {});
  say("p", hello(1));
  heard(v1::Envelope::kWelcome);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_TRUE(all[0].has_welcome());
  EXPECT_TRUE(all[1].has_job_start());
}

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

TEST_F(CoordinatorTest, CountsWorkersOfEachJob) {
  const auto end = [this](const PeerId& peer) {
    const uint64_t id = job_id();
    ready(peer, id);
    for (size_t i = 0; i < heard(v1::Envelope::kAssign).size(); ++i) {
      const v1::Assign assign = heard(v1::Envelope::kAssign)[i].assign();
      if (assign.job() == id) say(peer, band(assign, 1));
    }
    const auto result = coordinator.take_result(id);
    EXPECT_TRUE(result);
    return result ? result->report : JobReport{};
  };
  say("gone before", hello(1));
  coordinator.on_peer_gone("gone before", {});
  say("lost", hello(2));
  say("read late", hello(5));
  say("stays", hello(3));
  coordinator.submit(job(), {});
  coordinator.on_peer_gone("lost", {});
  coordinator.on_peer_gone("read late", {}, false);
  JobReport report = end("stays");
  EXPECT_EQ(report.workers_seen, 3u);
  EXPECT_EQ(report.workers_lost, 1u);

  coordinator.submit(job(), {});
  report = end("stays");
  EXPECT_EQ(report.workers_seen, 1u);
  EXPECT_EQ(report.workers_lost, 0u);

  coordinator.submit(job(), {});
  for (const uint64_t session : {2, 3}) say("back", hello(2, session));
  say("new", hello(4));
  report = end("stays");
  EXPECT_EQ(report.workers_seen, 3u);
  EXPECT_EQ(report.workers_lost, 0u);
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

TEST_F(CoordinatorTest, WhoGoesWhenToldToIsNotLost) {
  coordinator.submit(job(), {});
  say("p", hello(1));
  coordinator.shut_down("the day is over");
  coordinator.on_peer_gone("p", seconds(1));
  EXPECT_EQ(coordinator.snapshot(seconds(1)).counters.workers_lost, 0u);
  EXPECT_EQ(coordinator.progress({}).workers, 0);
}

TEST_F(CoordinatorTest, ALostConnectionIsLostOnceWhateverStillComesByIt) {
  const uint64_t id = coordinator.submit(job(), {});
  say("p", hello(1));
  ready("p", id);
  const v1::Assign assign = heard(v1::Envelope::kAssign).at(0).assign();
  v1::Envelope heartbeat;
  heartbeat.mutable_heartbeat()->set_session(1);
  // As where the coordinator was stopped meanwhile: heartbeats wait, and the answer finds nobody.
  for (int i = 0; i < 5; ++i) {
    say("p", heartbeat, seconds(i));
    coordinator.on_peer_gone("p", seconds(i));
  }
  EXPECT_EQ(coordinator.snapshot(seconds(5)).counters.workers_lost, 1u);
  EXPECT_EQ(coordinator.progress({}).workers, 0);
  say("p", band(assign, 1), seconds(5));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 1u) << "what it sent before counts";
  say("q", hello(1, 2), seconds(6));
  EXPECT_EQ(coordinator.progress({}).workers, 1) << "it is back by another connection";
}

TEST_F(CoordinatorTest, WhoWasStoppedBlamesNobodyAndListensAsLongAsEver) {
  coordinator.on_tick({});
  const uint64_t id = coordinator.submit(job(), {});
  say("p", hello(1));
  say("q", hello(2));
  ready("p", id);
  ASSERT_FALSE(heard(v1::Envelope::kAssign).empty());
  // Of what came while the coordinator was stopped, the heartbeat of one was read before the clock.
  v1::Envelope heartbeat;
  heartbeat.mutable_heartbeat()->set_session(1);
  say("q", heartbeat, seconds(600));
  Time now = seconds(600);
  coordinator.on_tick(now);
  EXPECT_EQ(coordinator.snapshot(now).counters.workers_lost, 0u);
  EXPECT_TRUE(coordinator.take_stuck_processes().empty()) << "nobody could tell of progress";
  while (now < seconds(606)) coordinator.on_tick(now = coordinator.next_deadline());
  EXPECT_EQ(coordinator.snapshot(now).counters.workers_lost, 2u);
}

TEST_F(CoordinatorTest, ATimelineHasWhatWasLostWithAWorker) {
  const uint64_t id = coordinator.submit(job(16), {});
  say("p", hello(1));
  say("q", hello(2));
  ready("p", id);
  coordinator.on_peer_gone("p", seconds(1));
  ready("q", id, seconds(1));
  say("q", band(heard(v1::Envelope::kAssign).back().assign(), 1), seconds(2));
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  std::vector<FrameTrace::Span> lost;
  for (const auto& span : result->report.trace->spans) {
    if (span.kind == FrameTrace::Kind::lost) lost.push_back(span);
  }
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_EQ(lost[0].worker, 1u);
  EXPECT_EQ(lost[0].end - lost[0].begin, 1.0);
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
  // And once more where SceneReady was lost, which the worker then repeats.
  heartbeat.mutable_heartbeat()->add_jobs()->set_job(id);
  heartbeat.mutable_heartbeat()->mutable_jobs(0)->set_ready(true);
  say("p", heartbeat, seconds(3));
  EXPECT_EQ(heard(v1::Envelope::kJobStart).size(), told + 2);
  ready("p", id);
  EXPECT_EQ(heard(v1::Envelope::kAssign).size(), 2u);
}

TEST_F(CoordinatorTest, CountsWhatBuildingCountedOnce) {
  const uint64_t id = coordinator.submit(job(16), {});
  for (const WorkerId worker : {1, 2}) {
    const PeerId peer = worker == 1 ? "p" : "q";
    say(peer, hello(worker));
    v1::Envelope message;
    message.mutable_scene_ready()->set_session(1);
    message.mutable_scene_ready()->set_job(id);
    (*message.mutable_scene_ready()->mutable_counters()->mutable_values())["left_out"] = 5;
    say(peer, message);
    say(peer, message);
  }
  say("p", band(heard(v1::Envelope::kAssign).at(0).assign(), 1));
  EXPECT_EQ(coordinator.take_result(id)->report.build_counters.at("left_out"), 5u);
}

TEST_F(CoordinatorTest, TakesPixelsOnlyUnderALeaseOfTheirWorker) {
  const uint64_t id = coordinator.submit(job(), {});
  say("p", hello(1));
  say("q", hello(2));
  ready("p", id);
  v1::Assign assign = heard(v1::Envelope::kAssign).at(0).assign();
  say("q", band(assign, 9));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 0u) << "another's lease";
  assign.set_lease(assign.lease() + (uint64_t{1} << 40));
  say("p", band(assign, 9));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 0u) << "an invented one";
  // One that it had, and lost, is its own.
  coordinator.on_peer_gone("p", milliseconds(1));
  say("p", band(heard(v1::Envelope::kAssign).at(0).assign(), 1), milliseconds(2));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 1u);
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

TEST_F(CoordinatorTest, AnIdSaidByAnotherKeyIsRefusedAndChangesNothing) {
  const AllowedKey alice{Role::worker, "alice", "aa"}, mallory{Role::worker, "mallory", "bb"};
  const uint64_t id = coordinator.submit(job(64), {});
  say("p", hello(1), {}, alice);
  ready("p", id);
  const size_t welcomes = heard(v1::Envelope::kWelcome).size();
  say("m", hello(1, ~uint64_t{0}), {}, mallory);
  const auto rejects = heard(v1::Envelope::kReject);
  ASSERT_EQ(rejects.size(), 1u);
  EXPECT_EQ(rejects[0].reject().reason(), v1::Reject::ID_TAKEN);
  EXPECT_EQ(heard(v1::Envelope::kWelcome).size(), welcomes);
  // The first goes on, and is welcomed anew when its line failed.
  say("p", band(heard(v1::Envelope::kAssign)[0].assign(), 0.5f));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 1u);
  say("p2", hello(1, 2), {}, alice);
  EXPECT_EQ(heard(v1::Envelope::kWelcome).size(), welcomes + 1);
  EXPECT_EQ(coordinator.workers().all().at(1).failures, 0);
  EXPECT_EQ(coordinator.workers().all().size(), 1u);
}

TEST_F(CoordinatorTest, AnOlderSessionOfAnotherIsAnsweredWhereThereAreNoKeys) {
  say("p", hello(1));
  say("m", hello(1, ~uint64_t{0}));
  say("p", hello(1, 2));
  const auto rejects = heard(v1::Envelope::kReject);
  ASSERT_EQ(rejects.size(), 1u);
  EXPECT_EQ(rejects[0].reject().reason(), v1::Reject::ID_TAKEN);
  EXPECT_EQ(rejects[0].reject().session(), 2u);
  EXPECT_THAT(rejects[0].reject().text(), ::testing::HasSubstr("another worker uses this id"));
}

TEST_F(CoordinatorTest, LeasesThatAreNotOursAreCancelledAndLeaveNoTrace) {
  const uint64_t id = coordinator.submit(job(), {});
  say("p", hello(1));
  ready("p", id);
  const auto assigns = heard(v1::Envelope::kAssign);
  say("p", band(assigns.at(0).assign(), 1), seconds(1));
  const LeaseId of_done = assigns[0].assign().lease(), beyond = uint64_t{5} << 32 | 0xfffff;
  v1::Envelope heartbeat;
  heartbeat.mutable_heartbeat()->set_session(1);
  for (const LeaseId lease : {of_done, beyond}) {
    auto& progress = *heartbeat.mutable_heartbeat()->add_progress();
    progress.set_job(id);
    progress.set_lease(lease);
  }
  say("p", heartbeat, seconds(1));
  const auto cancels = heard(v1::Envelope::kCancelTile);
  ASSERT_EQ(cancels.size(), 2u);
  EXPECT_EQ(cancels[0].cancel_tile().lease(), of_done);
  EXPECT_EQ(cancels[1].cancel_tile().lease(), beyond);
  coordinator.interrupt(id, seconds(1));
  const auto result = coordinator.take_result(id);
  EXPECT_EQ(result->report.trace->spans.size(), 2u) << "of the scene and the tile";
  for (const auto& span : result->report.trace->spans) {
    EXPECT_NE(span.kind, FrameTrace::Kind::wasted);
  }
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
  refused([](JobSpec& spec) { spec.priority = kMostPriority + 1; });
  refused([](JobSpec& spec) { spec.priority = -kMostPriority - 1; });
}

TEST_F(CoordinatorTest, InterruptsQueuedJobsToo) {
  const uint64_t first = coordinator.submit(job(), {}), second = coordinator.submit(job(), {});
  coordinator.interrupt(second, {});
  EXPECT_EQ(coordinator.take_result(second)->report.exit_code, ExitCode::interrupted);
  EXPECT_FALSE(coordinator.take_result(first));
  coordinator.interrupt(first, {});
  EXPECT_EQ(coordinator.take_result(first)->report.holes.size(), 4u);
}

TEST_F(CoordinatorTest, OfJobsOfThisProcessTheMostUrgentIsServedFirst) {
  const uint64_t whole = coordinator.submit(job(64), {});
  v1::Envelope worker = hello(1);
  worker.mutable_hello()->set_credit(5);  // more than it is given: there is always a place
  say("p", worker);
  ready("p", whole);
  JobSpec urgent = job();
  urgent.priority = 5;
  urgent.frame.set_seed(2);
  const uint64_t view = coordinator.submit(urgent, {});
  EXPECT_EQ(job_id(), view) << "it is told at once, while tiles of the other are traced";
  ready("p", view);
  std::vector<uint64_t> served;
  for (size_t i = 0; i < heard(v1::Envelope::kAssign).size() && i < 8; ++i) {
    const v1::Assign assign = heard(v1::Envelope::kAssign)[i].assign();
    served.push_back(assign.job());
    say("p", band(assign, 1));
  }
  EXPECT_EQ(served, (std::vector<uint64_t>{whole, whole, view, view, view, view, whole, whole}));
  // Both at once: one has ended, the other goes on.
  const auto result = coordinator.take_result(view);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.end, JobReport::End::done);
  EXPECT_FALSE(coordinator.take_result(whole));
}

TEST_F(CoordinatorTest, TellsOfOneOfSeveralJobsOfThisProcess) {
  const uint64_t small = coordinator.submit(job(), {}), large = coordinator.submit(job(64), {});
  say("p", hello(1));
  ready("p", small);
  say("p", band(heard(v1::Envelope::kAssign).at(0).assign(), 0.25f));
  EXPECT_EQ(coordinator.progress(small, {})->tiles_done, 1u);
  EXPECT_EQ(coordinator.progress(large, {})->tiles_done, 0u);
  EXPECT_EQ(coordinator.progress(large, {})->tiles_total, 16u);
  EXPECT_EQ(coordinator.tiles(small, {}).size(), 4u);
  EXPECT_EQ(coordinator.tiles(large, {}).size(), 16u);
  EXPECT_EQ(coordinator.film(small)->values[0], 0.25f);
  EXPECT_EQ(coordinator.film(large)->rect, (PixelRect{0, 0, 64, 64}));
  coordinator.interrupt(small, {});
  EXPECT_FALSE(coordinator.progress(small, {}));
  EXPECT_FALSE(coordinator.film(small));
  EXPECT_TRUE(coordinator.tiles(small, {}).empty());
  EXPECT_TRUE(coordinator.progress(large, {}));
}

TEST_F(CoordinatorTest, AWorkerThatIsShortOfMemoryHoldsFewerTiles) {
  coordinator.submit(job(64), {});
  v1::Envelope large = hello(1);
  large.mutable_hello()->set_credit(6);
  large.mutable_hello()->set_threads(4);
  say("w1", large);
  ready("w1", job_id());
  EXPECT_EQ(heard(v1::Envelope::kAssign).size(), 6u);
  v1::Envelope heartbeat;
  heartbeat.mutable_heartbeat()->set_session(1);
  heartbeat.mutable_heartbeat()->set_credit(2);
  v1::Heartbeat::Job& known = *heartbeat.mutable_heartbeat()->add_jobs();
  known.set_job(job_id());
  known.set_ready(true);
  // It has given all back.
  say("w1", heartbeat, seconds(3));
  EXPECT_EQ(heard(v1::Envelope::kAssign).size(), 8u);
  EXPECT_EQ(coordinator.snapshot(seconds(3)).workers.at(0).credit, 2u);
  // No heartbeat raises it again.
  heartbeat.mutable_heartbeat()->set_credit(100);
  say("w1", heartbeat, seconds(4));
  EXPECT_EQ(coordinator.snapshot(seconds(4)).workers.at(0).credit, 2u);
}

}  // namespace
}  // namespace tessera::testing
