#include <csignal>

#include "tests/unit/worker/worker_session_fixture.h"

namespace tessera {
namespace {

TEST_F(WorkerSessionTest, ABlobThatIsMissingOnceOrTwiceMayYetCome) {
  welcome(1);
  for (int i = 0; i < 2; ++i) {
    start(1);
    const auto asked = sent(v1::Envelope::kBlobRequest);
    ASSERT_THAT(asked, SizeIs(1));
    // The line of blobs is back before the coordinator has taken up its jobs.
    session.on_message(Channel::bulk, answer_blob_request(asked[0].blob_request(), nullptr), {});
    EXPECT_THAT(sent(v1::Envelope::kSceneFailed), IsEmpty());
    session.on_tick(seconds(i + 1));
    EXPECT_EQ(sent(v1::Envelope::kHeartbeat).at(0).heartbeat().jobs_size(), 0)
        << "so that it is told again";
  }
  start(1);
  serve_blobs();
  EXPECT_THAT(wants<StartBuild>(), SizeIs(1));
}

TEST_F(WorkerSessionTest, ABlobThatIsNeverThereFailsTheScene) {
  welcome(1);
  size_t failed = 0;
  for (int i = 0; i < 3; ++i) {
    start(1);
    const auto asked = sent(v1::Envelope::kBlobRequest);
    ASSERT_THAT(asked, SizeIs(1));
    session.on_message(Channel::bulk, answer_blob_request(asked[0].blob_request(), nullptr), {});
    failed += sent(v1::Envelope::kSceneFailed).size();
  }
  EXPECT_EQ(failed, 1u);
}

TEST_F(WorkerSessionTest, AFrameThatCrashedTheProcessIsNotBuiltAgain) {
  const std::string deadly(16, 'x'), harmless(16, 'y');
  SessionOptions after_crash = options();
  after_crash.crashed_frames = {{deadly, SIGSEGV}};
  session = WorkerSession(after_crash, Time{0});
  welcome(1);
  const auto tell = [this](uint64_t job, const std::string& frame_id) {
    v1::Envelope message;
    v1::JobStart& start = *message.mutable_job_start();
    start.set_job(job);
    start.set_frame_id(frame_id);
    start.set_scene_digest(scene_digest.hex());
    start.set_scene_size(scene_size);
    session.on_message(Channel::control, message, {});
  };
  tell(7, deadly);
  for (auto& action : session.take_actions()) actions.push_back(std::move(action));
  const auto all = actions;
  EXPECT_THAT(sent(v1::Envelope::kBlobRequest), IsEmpty()) << "nothing of it is wanted";
  actions = all;
  const auto failed = sent(v1::Envelope::kSceneFailed);
  ASSERT_THAT(failed, SizeIs(1));
  EXPECT_EQ(failed[0].scene_failed().job(), 7u);
  EXPECT_EQ(failed[0].scene_failed().frame_id(), deadly);
  EXPECT_EQ(failed[0].scene_failed().cause(), v1::SceneFailed::CRASHED);
  EXPECT_EQ(failed[0].scene_failed().text(),
            "building the scene ended the worker's process by signal 11 (SEGV)");
  // The same number may come to mean another frame.
  tell(7, harmless);
  serve_blobs();
  EXPECT_THAT(wants<StartBuild>(), SizeIs(1));
}

TEST_F(WorkerSessionTest, RepeatsThatASceneFailedUntilTheJobIsOver) {
  welcome(1);
  start(7);
  serve_blobs();
  session.on_built({.job = 7,
                    .frame_id = {},
                    .renderer = nullptr,
                    .seconds = 0,
                    .failure = "bad",
                    .cause = v1::SceneFailed::BAD_SCENE},
                   {});
  EXPECT_THAT(sent(v1::Envelope::kSceneFailed), SizeIs(1));
  start(7);
  EXPECT_THAT(sent(v1::Envelope::kSceneFailed), SizeIs(1)) << "when it is told the job again";
  session.on_tick(seconds(1));
  const auto failed = sent(v1::Envelope::kSceneFailed);
  ASSERT_THAT(failed, SizeIs(1)) << "with each heartbeat";
  EXPECT_EQ(failed[0].scene_failed().text(), "bad");
  v1::Envelope cancel;
  cancel.mutable_cancel_job()->set_job(7);
  session.on_message(Channel::control, cancel, seconds(1));
  session.on_tick(seconds(2));
  EXPECT_THAT(sent(v1::Envelope::kSceneFailed), IsEmpty());
}

TEST_F(WorkerSessionTest, KeepsScenesThatItHas) {
  make_ready(7);
  start(8);
  EXPECT_THAT(wants<StartBuild>(), IsEmpty());
  EXPECT_THAT(sent(v1::Envelope::kSceneReady), SizeIs(1)) << "the same frame needs nothing";
}

TEST_F(WorkerSessionTest, ReportsASceneThatCannotBeBuilt) {
  welcome(1);
  start(7);
  serve_blobs();
  session.on_built({.job = 7,
                    .frame_id = {},
                    .renderer = nullptr,
                    .seconds = 0,
                    .failure = "bad",
                    .cause = v1::SceneFailed::BAD_SCENE},
                   {});
  const auto failed = sent(v1::Envelope::kSceneFailed).at(0).scene_failed();
  EXPECT_EQ(failed.text(), "bad");
  EXPECT_EQ(failed.cause(), v1::SceneFailed::BAD_SCENE);
}

TEST_F(WorkerSessionTest, LooksOnDiskBeforeItAsksAndKeepsWhatIsSent) {
  begin_with_disk();
  welcome(1);
  start(7);
  const auto looked = wants<LookForBlob>();
  ASSERT_THAT(looked, SizeIs(1));
  EXPECT_EQ(looked[0].lookup.digest, scene_digest);
  EXPECT_EQ(looked[0].lookup.size, scene_size);
  EXPECT_FALSE(looked[0].lookup.place);
  EXPECT_THAT(sent(v1::Envelope::kBlobRequest), IsEmpty());
  session.on_found({scene_digest, nullptr}, {});
  serve_blobs();
  const auto kept = wants<KeepBlob>();
  ASSERT_THAT(kept, SizeIs(1));
  EXPECT_EQ(kept[0].digest, scene_digest);
  EXPECT_EQ(*kept[0].blob, *store.find(scene_digest));
  EXPECT_THAT(wants<StartBuild>(), SizeIs(1));
}

TEST_F(WorkerSessionTest, WhatIsOnDiskIsNotAskedFor) {
  begin_with_disk();
  welcome(1);
  start(7);
  session.on_found({scene_digest, store.find(scene_digest)}, {});
  EXPECT_THAT(sent(v1::Envelope::kBlobRequest), IsEmpty());
  EXPECT_THAT(wants<KeepBlob>(), IsEmpty());
  EXPECT_THAT(wants<StartBuild>(), SizeIs(1));
}

TEST_F(WorkerSessionTest, WhatThisProcessHasIsNotAskedFor) {
  SessionOptions in_process = options();
  in_process.blob_sources.at_hand = [this](const Digest& digest) { return store.find(digest); };
  session = WorkerSession(in_process, Time{0});
  welcome(1);
  start(7);
  EXPECT_THAT(sent(v1::Envelope::kBlobRequest), IsEmpty());
  EXPECT_THAT(wants<StartBuild>(), SizeIs(1));
}

TEST_F(WorkerSessionTest, MapsWhatTheCoordinatorSharesAndFetchesWhatIsNotThere) {
  SessionOptions local = options();
  local.blob_sources.shared_memory = true;
  for (const bool is_there : {true, false}) {
    session = WorkerSession(local, Time{0});
    welcome(1);
    start(7);
    const auto asked = sent(v1::Envelope::kBlobRequest);
    ASSERT_THAT(asked, SizeIs(1));
    EXPECT_TRUE(asked[0].blob_request().place());
    v1::Envelope message;
    message.mutable_blob_place()->set_digest(scene_digest.hex());
    message.mutable_blob_place()->set_process_id(12);
    message.mutable_blob_place()->set_file(34);
    session.on_message(Channel::bulk, message, {});
    session.on_message(Channel::bulk, message, {});  // doubled
    const auto looked = wants<LookForBlob>();
    ASSERT_THAT(looked, SizeIs(1));
    ASSERT_TRUE(looked[0].lookup.place);
    EXPECT_EQ(looked[0].lookup.place->process, 12);
    EXPECT_EQ(looked[0].lookup.place->descriptor, 34);
    session.on_found({scene_digest, is_there ? store.find(scene_digest) : nullptr}, {});
    const auto again = sent(v1::Envelope::kBlobRequest);
    EXPECT_THAT(again, SizeIs(is_there ? 0 : 1));
    for (const auto& request : again) {
      EXPECT_FALSE(request.blob_request().place());
      session.on_message(Channel::bulk,
                         answer_blob_request(request.blob_request(), store.find(scene_digest)), {});
    }
    EXPECT_THAT(wants<StartBuild>(), SizeIs(1));
  }
}

/// Tells of jobs whose scenes refer to blobs, and of their ends.
class WorkerSessionBuilds : public WorkerSessionTest {
 protected:
  std::shared_ptr<const BuildRun> begin(uint64_t job, const std::vector<Digest>& blobs) {
    v1::Envelope message;
    v1::JobStart& start = *message.mutable_job_start();
    start.set_job(job);
    start.set_frame_id(std::to_string(job));
    start.set_scene_digest(scene_digest.hex());
    start.set_scene_size(scene_size);
    for (const Digest& blob : blobs) {
      start.add_blobs(blob.hex());
      start.add_blob_sizes(store.find(blob)->size());
    }
    session.on_message(Channel::control, message, Time{0});
    serve_blobs();
    const auto builds = wants<StartBuild>();
    return builds.empty() ? nullptr : builds.back().run;
  }
  void end(uint64_t job) {
    v1::Envelope message;
    message.mutable_cancel_job()->set_job(job);
    session.on_message(Channel::control, message, Time{0});
  }

  const Digest mesh = store.put(std::vector<std::byte>(10, std::byte{1}));
  const Digest other_mesh = store.put(std::vector<std::byte>(10, std::byte{2}));
};

TEST_F(WorkerSessionBuilds, ABuildOfAJobThatIsOverIsDropped) {
  welcome(1);
  const auto begun = begin(7, {mesh});
  begun->started = true;
  const auto waiting = begin(8, {mesh});
  end(8);
  EXPECT_TRUE(*waiting->dropped) << "it has not begun";
  end(7);
  EXPECT_FALSE(*begun->dropped) << "the next job may need it";
  EXPECT_EQ(session.next_deadline(), milliseconds(5));
  session.on_tick(milliseconds(5));
  EXPECT_TRUE(*begun->dropped);
  // Nobody is told of it, though its number may have come to mean another job.
  begin(7, {});
  wants<SendMessage>();
  BuildOutcome outcome;
  outcome.job = 7;
  outcome.frame_id = "7";
  outcome.dropped = true;
  session.on_built(outcome, {});
  EXPECT_THAT(wants<SendMessage>(), IsEmpty());
}

TEST_F(WorkerSessionBuilds, ABuildOfTheMeshesThatTheNextJobNeedsGoesOn) {
  welcome(1);
  const auto first = begin(7, {mesh});
  first->started = true;
  end(7);
  const auto second = begin(8, {mesh, other_mesh});
  session.on_tick(milliseconds(5));
  EXPECT_FALSE(*first->dropped);
  // It goes on as long as somebody needs it.
  second->started = true;
  end(8);
  begin(9, {other_mesh});
  EXPECT_TRUE(*first->dropped);
  EXPECT_TRUE(*second->dropped) << "more than that job needs";
}

TEST_F(WorkerSessionBuilds, WhoLeavesDropsThem) {
  welcome(1);
  const auto run = begin(7, {mesh});
  run->started = true;
  session.leave("stopped");
  EXPECT_TRUE(*run->dropped);
}

}  // namespace
}  // namespace tessera
