#include "worker/worker_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/wire/scene_codec.h"
#include "tests/farm/fake_renderer.h"

namespace tessera {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class WorkerSessionTest : public ::testing::Test {
 protected:
  WorkerSessionTest() : session(options(), Time{0}) {
    scene.mutable_metadata()->set_title("x");
    const std::string bytes = serialize_scene(scene);
    const auto span = std::as_bytes(std::span(bytes));
    scene_digest = store.put({span.begin(), span.end()});
    scene_size = span.size();
  }

  static SessionOptions options() {
    SessionOptions options;
    options.hello.set_worker_id(5);
    options.hello.set_credit(2);
    options.orphan_timeout = seconds(30);
    return options;
  }
  /// Starts anew, as a worker that keeps blobs on disk.
  void begin_with_disk() {
    SessionOptions with_disk = options();
    with_disk.blob_sources.disk = true;
    session = WorkerSession(with_disk, Time{0});
  }

  /// What the session wants done since last asked, of one kind.
  template <typename Action>
  std::vector<Action> wants() {
    for (auto& action : session.take_actions()) actions.push_back(std::move(action));
    std::vector<Action> result;
    std::erase_if(actions, [&](SessionAction& action) {
      if (!std::holds_alternative<Action>(action)) return false;
      result.push_back(std::move(std::get<Action>(action)));
      return true;
    });
    return result;
  }

  /// Messages of one kind that it sent since last asked; others of that time are forgotten.
  std::vector<v1::Envelope> sent(v1::Envelope::MessageCase kind) {
    std::vector<v1::Envelope> result;
    for (auto& send : wants<SendMessage>()) {
      if (send.message.message_case() == kind) result.push_back(std::move(send.message));
    }
    return result;
  }

  void welcome(uint64_t number, Time now = {}, uint64_t farm = 1) {
    v1::Envelope message;
    v1::Welcome& welcome = *message.mutable_welcome();
    welcome.set_session(number);
    welcome.set_farm(farm);
    welcome.set_heartbeat_ms(1000);
    welcome.set_lost_after_ms(5000);
    welcome.set_bulk_endpoint("tcp://:9");
    session.on_message(Channel::control, message, now);
  }

  void start(uint64_t job, Time now = {}, uint32_t seed = 0) {
    v1::Envelope message;
    v1::JobStart& start = *message.mutable_job_start();
    start.set_job(job);
    start.set_scene_digest(scene_digest.hex());
    start.set_scene_size(scene_size);
    start.mutable_frame()->set_seed(seed);
    start.mutable_frame()->set_width(64);
    start.mutable_frame()->set_height(64);
    session.on_message(Channel::control, message, now);
  }

  void serve_blobs() {
    for (const auto& request : sent(v1::Envelope::kBlobRequest)) {
      const auto digest = Digest::parse(request.blob_request().digest());
      session.on_message(Channel::bulk,
                         answer_blob_request(request.blob_request(), store.find(*digest)), {});
    }
  }

  void built(uint64_t job) {
    session.on_built({.job = job,
                      .renderer = std::make_shared<testing::FakeRenderer>(5),
                      .seconds = 1,
                      .failure = {},
                      .exit_code = 0},
                     {});
  }

  void make_ready(uint64_t job) {
    welcome(1);
    start(job);
    serve_blobs();
    built(job);
    wants<SendMessage>();
    wants<StartBuild>();
  }

  void assign(uint64_t job, uint64_t lease, int x1 = 16) {
    v1::Envelope message;
    v1::Assign& assign = *message.mutable_assign();
    assign.set_job(job);
    assign.set_lease(lease);
    assign.mutable_rect()->set_x1(x1);
    assign.mutable_rect()->set_y1(16);
    assign.set_sample_count(1);
    session.on_message(Channel::control, message, {});
  }

  void ping(uint64_t results, Time now) {
    v1::Envelope message;
    message.mutable_ping()->set_session(1);
    message.mutable_ping()->set_results(results);
    session.on_message(Channel::control, message, now);
  }

  v1::Scene scene;
  BlobStore store;
  Digest scene_digest;
  uint64_t scene_size = 0;
  WorkerSession session;
  std::vector<SessionAction> actions;
};

TEST_F(WorkerSessionTest, GoesFromHelloToBands) {
  EXPECT_THAT(sent(v1::Envelope::kHello), SizeIs(1));
  welcome(1);
  EXPECT_EQ(wants<ConnectBulk>().at(0).endpoint, "tcp://:9");
  start(7);
  serve_blobs();
  const auto builds = wants<StartBuild>();
  ASSERT_THAT(builds, SizeIs(1));
  EXPECT_EQ(builds[0].run->scene.metadata().title(), "x");
  built(7);
  EXPECT_EQ(sent(v1::Envelope::kSceneReady).at(0).scene_ready().job(), 7u);
  assign(7, 11);
  const auto runs = wants<StartTrace>();
  ASSERT_THAT(runs, SizeIs(1));
  session.on_traced(trace(runs[0].run), {});
  const auto bands = sent(v1::Envelope::kTileBand);
  ASSERT_THAT(bands, SizeIs(1));
  EXPECT_EQ(bands[0].tile_band().lease(), 11u);
  EXPECT_TRUE(bands[0].tile_band().last());
}

TEST_F(WorkerSessionTest, SaysHelloAgainUntilItIsWelcome) {
  sent(v1::Envelope::kHello);
  session.on_tick(milliseconds(500));
  EXPECT_THAT(sent(v1::Envelope::kHello), IsEmpty());
  session.on_tick(seconds(1));
  EXPECT_EQ(sent(v1::Envelope::kHello).at(0).hello().session(), 2u);
  // The welcome of the first hello came too late.
  welcome(1);
  session.on_tick(seconds(2));
  EXPECT_THAT(sent(v1::Envelope::kHeartbeat), IsEmpty());
  EXPECT_GE(session.next_deadline(), Time(seconds(3))) << "later each time";
  EXPECT_LE(session.next_deadline(), Time(milliseconds(3500))) << "and by chance";
}

TEST_F(WorkerSessionTest, TellsEachSecondWhatItHolds) {
  make_ready(7);
  assign(7, 11);
  assign(7, 12);
  const auto runs = wants<StartTrace>();
  runs[0].run->started = true;
  runs[0].run->progress.work_done = 99;
  session.on_tick(seconds(1));
  const auto heartbeat = sent(v1::Envelope::kHeartbeat).at(0).heartbeat();
  ASSERT_EQ(heartbeat.jobs_size(), 1);
  EXPECT_EQ(heartbeat.jobs(0).job(), 7u);
  EXPECT_TRUE(heartbeat.jobs(0).ready());
  ASSERT_EQ(heartbeat.progress_size(), 2);
  EXPECT_EQ(heartbeat.progress(0).work_done(), 99u);
  EXPECT_TRUE(heartbeat.progress(0).started());
  EXPECT_FALSE(heartbeat.progress(1).started());
}

TEST_F(WorkerSessionTest, ComesAnewWhenTheCoordinatorIsSilent) {
  make_ready(7);
  assign(7, 11);
  const auto run = wants<StartTrace>().at(0).run;
  session.on_tick(seconds(5));
  EXPECT_THAT(wants<Reconnect>(), SizeIs(1));
  EXPECT_EQ(sent(v1::Envelope::kHello).at(0).hello().session(), 2u);
  // What it traces meanwhile is kept until somebody wants it.
  session.on_traced(trace(run), seconds(6));
  EXPECT_THAT(sent(v1::Envelope::kTileBand), IsEmpty());
  welcome(2, seconds(7));
  EXPECT_EQ(sent(v1::Envelope::kTileBand).at(0).tile_band().lease(), 11u);
}

TEST_F(WorkerSessionTest, KeepsResultsUntilTheyHaveCome) {
  make_ready(7);
  const auto result = [this](uint64_t lease, Time now) {
    assign(7, lease);
    session.on_traced(trace(wants<StartTrace>().at(0).run), now);
    EXPECT_EQ(sent(v1::Envelope::kTileBand).size(), 1u);
  };
  result(11, {});
  session.on_tick(seconds(1));
  EXPECT_EQ(sent(v1::Envelope::kHeartbeat).at(0).heartbeat().results(), 1u);
  result(12, seconds(1));
  ping(1, seconds(1));
  // The coordinator is killed before the second has come, and another takes its place.
  v1::Envelope request;
  request.mutable_hello_request();
  session.on_message(Channel::control, request, seconds(2));
  welcome(2, seconds(2));
  const auto again = sent(v1::Envelope::kTileBand);
  ASSERT_THAT(again, SizeIs(1));
  EXPECT_EQ(again[0].tile_band().lease(), 12u);
}

TEST_F(WorkerSessionTest, GoesOnForACoordinatorOnTheSameStore) {
  make_ready(7);
  assign(7, 11);
  const auto run = wants<StartTrace>().at(0).run;
  session.on_tick(seconds(5));
  welcome(2, seconds(6), 1);
  EXPECT_FALSE(run->progress.cancelled);
  start(7, seconds(6));
  EXPECT_THAT(sent(v1::Envelope::kSceneReady), SizeIs(1)) << "nothing is built again";
}

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

TEST_F(WorkerSessionTest, TracesTilesOfSeveralJobsAtATime) {
  make_ready(7);
  start(8, {}, 99);
  serve_blobs();
  EXPECT_THAT(wants<StartBuild>(), SizeIs(1)) << "another frame";
  built(8);
  assign(7, 11);
  assign(8, 11);
  const auto runs = wants<StartTrace>();
  ASSERT_THAT(runs, SizeIs(2));
  EXPECT_NE(runs[0].run->renderer, runs[1].run->renderer);
  v1::Envelope message;
  message.mutable_cancel_job()->set_job(7);
  session.on_message(Channel::control, message, {});
  EXPECT_TRUE(runs[0].run->progress.cancelled);
  EXPECT_FALSE(runs[1].run->progress.cancelled);
}

TEST_F(WorkerSessionTest, ForgetsAllForACoordinatorOfAnotherFarm) {
  make_ready(7);
  assign(7, 11);
  const auto run = wants<StartTrace>().at(0).run;
  v1::Envelope request;
  request.mutable_hello_request();
  session.on_message(Channel::control, request, {});
  session.on_message(Channel::control, request, {});
  EXPECT_THAT(sent(v1::Envelope::kHello), SizeIs(1)) << "one answers both";
  welcome(2, {}, 2);
  EXPECT_TRUE(run->progress.cancelled);
}

TEST_F(WorkerSessionTest, TakesAnotherFrameForAnotherJobWhateverItsNumber) {
  make_ready(7);
  assign(7, 11);
  const auto run = wants<StartTrace>().at(0).run;
  start(7);
  EXPECT_FALSE(run->progress.cancelled) << "the same again";
  EXPECT_THAT(sent(v1::Envelope::kSceneReady), SizeIs(1));
  TraceOutcome late = trace(run);
  start(7, {}, 99);
  EXPECT_TRUE(run->progress.cancelled);
  EXPECT_THAT(sent(v1::Envelope::kSceneReady), IsEmpty());
  EXPECT_THAT(wants<StartBuild>(), SizeIs(1));
  session.on_traced(std::move(late), {});
  EXPECT_THAT(sent(v1::Envelope::kTileBand), IsEmpty()) << "pixels of the frame before";
}

TEST_F(WorkerSessionTest, TellsWhatBuildingCountedEachTimeItIsReady) {
  welcome(1);
  start(7);
  serve_blobs();
  built(7);
  for (int i = 0; i < 2; ++i) {
    const auto ready = sent(v1::Envelope::kSceneReady);
    ASSERT_THAT(ready, SizeIs(1));
    EXPECT_EQ(ready[0].scene_ready().counters().values().at("build_skipped"), 3u);
    EXPECT_EQ(ready[0].scene_ready().build_seconds(), 1);
    start(7);
  }
}

TEST_F(WorkerSessionTest, RepeatsThatASceneFailedUntilTheJobIsOver) {
  welcome(1);
  start(7);
  serve_blobs();
  session.on_built({.job = 7, .renderer = nullptr, .seconds = 0, .failure = "bad", .exit_code = 1},
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

TEST_F(WorkerSessionTest, GivesUpAsAnOrphan) {
  session.on_tick(seconds(29));
  EXPECT_THAT(wants<Quit>(), IsEmpty());
  session.on_tick(seconds(30));
  EXPECT_EQ(wants<Quit>().at(0).exit_code, ExitCode::render_failed);
}

TEST_F(WorkerSessionTest, QuitsWhenRefusedOrSentAway) {
  v1::Envelope message;
  message.mutable_reject()->set_text("you: 1; we: 2");
  session.on_message(Channel::control, message, {});
  const Quit quit = wants<Quit>().at(0);
  EXPECT_EQ(quit.exit_code, ExitCode::bad_usage);
  EXPECT_THAT(quit.reason, ::testing::HasSubstr("you: 1; we: 2"));
  message.mutable_shutdown();
  session.on_message(Channel::control, message, {});
  EXPECT_EQ(wants<Quit>().at(0).exit_code, ExitCode::done);
}

TEST_F(WorkerSessionTest, CancelsATileAndAJob) {
  make_ready(7);
  for (uint64_t lease = 1; lease <= 3; ++lease) assign(7, lease);
  const auto runs = wants<StartTrace>();
  runs[0].run->started = true;
  v1::Envelope message;
  message.mutable_cancel_tile()->set_lease(2);
  message.mutable_cancel_tile()->set_job(7);
  session.on_message(Channel::control, message, {});
  EXPECT_TRUE(runs[1].run->progress.cancelled);
  EXPECT_FALSE(runs[0].run->progress.cancelled);
  session.on_traced(trace(runs[1].run), {});
  EXPECT_THAT(sent(v1::Envelope::kTileBand), IsEmpty());
  message.mutable_cancel_job()->set_job(6);
  session.on_message(Channel::control, message, {});
  EXPECT_FALSE(runs[0].run->progress.cancelled) << "another job";
  message.mutable_cancel_job()->set_job(7);
  session.on_message(Channel::control, message, {});
  EXPECT_TRUE(runs[0].run->progress.cancelled);
  EXPECT_TRUE(runs[2].run->progress.cancelled);
}

TEST_F(WorkerSessionTest, KeepsScenesThatItHas) {
  make_ready(7);
  start(8);
  EXPECT_THAT(wants<StartBuild>(), IsEmpty());
  EXPECT_THAT(sent(v1::Envelope::kSceneReady), SizeIs(1)) << "the same frame needs nothing";
}

TEST_F(WorkerSessionTest, ReportsATileThatCannotBeTraced) {
  make_ready(7);
  assign(7, 11);
  TraceOutcome outcome;
  outcome.run = wants<StartTrace>().at(0).run;
  outcome.failure = "no";
  session.on_traced(std::move(outcome), {});
  EXPECT_EQ(sent(v1::Envelope::kTileFailed).at(0).tile_failed().text(), "no");
}

TEST_F(WorkerSessionTest, ReportsASceneThatCannotBeBuilt) {
  welcome(1);
  start(7);
  serve_blobs();
  session.on_built({.job = 7, .renderer = nullptr, .seconds = 0, .failure = "bad", .exit_code = 1},
                   {});
  const auto failed = sent(v1::Envelope::kSceneFailed).at(0).scene_failed();
  EXPECT_EQ(failed.text(), "bad");
  EXPECT_EQ(failed.exit_code(), 1u);
}

TEST_F(WorkerSessionTest, TakesNoAssignmentThatCannotBe) {
  make_ready(7);
  assign(6, 1);      // another job
  assign(7, 2, 65);  // beyond the frame
  assign(7, 3, 0);   // empty
  assign(7, 4, -5);
  EXPECT_THAT(wants<StartTrace>(), IsEmpty());
  assign(7, 5);
  assign(7, 5);
  EXPECT_THAT(wants<StartTrace>(), SizeIs(1)) << "a doubled message is one";
  for (uint64_t lease = 10; lease < 100; ++lease) assign(7, lease);
  EXPECT_THAT(wants<StartTrace>(), SizeIs(7)) << "bounded by four times its credit";
}

TEST_F(WorkerSessionTest, GivesBackWhatItHoldsWhenItLeaves) {
  make_ready(7);
  assign(7, 11);
  const auto run = wants<StartTrace>().at(0).run;
  session.leave("stopped");
  EXPECT_TRUE(run->progress.cancelled);
  EXPECT_EQ(sent(v1::Envelope::kBye).at(0).bye().reason(), "stopped");
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

TEST_F(WorkerSessionTest, WhatIsRecalledIsTracedIfItHasBegun) {
  make_ready(7);
  assign(7, 1);
  assign(7, 2);
  const auto runs = wants<StartTrace>();
  runs[0].run->started = true;
  v1::Envelope message;
  message.mutable_cancel_tile()->set_job(7);
  message.mutable_cancel_tile()->set_unless_started(true);
  for (const uint64_t lease : {1, 2}) {
    message.mutable_cancel_tile()->set_lease(lease);
    session.on_message(Channel::control, message, {});
  }
  EXPECT_FALSE(runs[0].run->progress.cancelled);
  EXPECT_TRUE(runs[1].run->progress.cancelled);
}

TEST_F(WorkerSessionTest, DrainingItGivesBackAtOnceWhatItHasNotBegun) {
  make_ready(7);
  assign(7, 1);
  assign(7, 2);
  const auto runs = wants<StartTrace>();
  runs[0].run->started = true;
  session.drain(seconds(1));
  const v1::Heartbeat told = sent(v1::Envelope::kHeartbeat).at(0).heartbeat();
  EXPECT_TRUE(told.leaves());
  ASSERT_EQ(told.progress_size(), 1);
  EXPECT_EQ(told.progress(0).lease(), 1u);
  EXPECT_TRUE(runs[1].run->progress.cancelled);
  EXPECT_FALSE(session.drained());
  assign(7, 3);
  EXPECT_THAT(wants<StartTrace>(), IsEmpty()) << "it takes no more";
  session.on_traced(trace(runs[0].run), seconds(2));
  EXPECT_THAT(sent(v1::Envelope::kTileBand), SizeIs(1));
  EXPECT_FALSE(session.drained()) << "perhaps it has not come";
  EXPECT_LE(session.next_deadline(), seconds(2)) << "it asks at once";
  session.on_tick(seconds(2));
  EXPECT_EQ(sent(v1::Envelope::kHeartbeat).at(0).heartbeat().results(), 1u);
  ping(1, seconds(2));
  EXPECT_TRUE(session.drained());
}

TEST_F(WorkerSessionTest, DrainingItWaitsForNoCoordinatorThatIsAway) {
  make_ready(7);
  assign(7, 1);
  const auto run = wants<StartTrace>().at(0).run;
  run->started = true;
  session.drain(seconds(1));
  session.on_traced(trace(run), seconds(2));
  EXPECT_FALSE(session.drained());
  EXPECT_THAT(session.take_unsent(), IsEmpty());
  session.on_tick(seconds(6));
  EXPECT_TRUE(session.drained());
  const auto unsent = session.take_unsent();
  ASSERT_THAT(unsent, SizeIs(1));
  EXPECT_EQ(unsent[0].tile_band().lease(), 1u);
}

TEST_F(WorkerSessionTest, WhatHasNoRoomInMemoryIsSpooledWhileTheCoordinatorIsAway) {
  SessionOptions small = options();
  small.result_bytes = 5000;  // one of 16x16 pixels
  session = WorkerSession(small, Time{0});
  make_ready(7);
  for (const uint64_t lease : {1u, 2u}) assign(7, lease);
  const auto runs = wants<StartTrace>();
  session.on_tick(seconds(5));
  for (const auto& start : runs) session.on_traced(trace(start.run), seconds(6));
  const auto spooled = wants<SpoolResult>();
  ASSERT_THAT(spooled, SizeIs(1));
  EXPECT_EQ(spooled[0].result.tile_band().lease(), 1u);
  welcome(2, seconds(7));
  EXPECT_THAT(sent(v1::Envelope::kTileBand), SizeIs(1));
  session.on_spooled(spooled[0].result);
  EXPECT_EQ(sent(v1::Envelope::kTileBand).at(0).tile_band().lease(), 1u);
}

TEST_F(WorkerSessionTest, ResultsOfAProcessBeforeAreToldUntilTheyHaveCome) {
  SessionOptions after = options();
  after.hello.set_session(100);
  session = WorkerSession(after, Time{0});
  EXPECT_EQ(sent(v1::Envelope::kHello).at(0).hello().session(), 101u);
  welcome(101);
  v1::Envelope result;
  result.mutable_tile_band()->set_job(7);
  result.mutable_tile_band()->set_lease(1);
  session.on_spooled(result);
  EXPECT_THAT(sent(v1::Envelope::kTileBand), SizeIs(1));
  start(7);
  v1::Envelope request;
  request.mutable_hello_request();
  session.on_message(Channel::control, request, seconds(2));
  welcome(102, seconds(2));
  EXPECT_THAT(sent(v1::Envelope::kTileBand), SizeIs(1));
  session.on_message(Channel::control, request, seconds(3));
  welcome(103, seconds(3), 2);
  EXPECT_THAT(sent(v1::Envelope::kTileBand), IsEmpty()) << "of another farm";
}

TEST_F(WorkerSessionTest, WhoIsRefusedOrAnOrphanForTooLong) {
  make_ready(7);
  assign(7, 1);
  session.on_traced(trace(wants<StartTrace>().at(0).run), {});
  session.on_tick(seconds(30));
  EXPECT_FALSE(wants<Quit>().at(0).refused);
  EXPECT_THAT(session.take_unsent(), SizeIs(1));
  v1::Envelope message;
  message.mutable_reject();
  session.on_message(Channel::control, message, seconds(31));
  EXPECT_TRUE(wants<Quit>().at(0).refused);
  EXPECT_THAT(session.take_unsent(), IsEmpty());
}

TEST_F(WorkerSessionTest, TakesFewerTilesWhereMemoryIsShort) {
  SessionOptions large = options();
  large.hello.set_credit(20);
  large.hello.set_threads(4);
  session = WorkerSession(large, Time{0});
  make_ready(7);
  const auto starve = [this](uint64_t lease) {
    assign(7, lease);
    TraceOutcome outcome;
    outcome.run = wants<StartTrace>().at(0).run;
    outcome.out_of_memory = true;
    outcome.failure = "no memory";
    session.on_traced(outcome, seconds(1));
    EXPECT_LE(session.next_deadline(), seconds(1)) << "it tells so at once";
    session.on_tick(seconds(1));
  };
  std::vector<uint32_t> told;
  for (const uint64_t lease : {1u, 2u, 3u}) {
    starve(lease);
    const auto heartbeat = sent(v1::Envelope::kHeartbeat).at(0).heartbeat();
    EXPECT_EQ(heartbeat.progress_size(), 0) << "it is given back";
    told.push_back(heartbeat.credit());
  }
  EXPECT_EQ(told, (std::vector<uint32_t>{4, 2, 1}));
  assign(7, 4);
  TraceOutcome alone;
  alone.run = wants<StartTrace>().at(0).run;
  alone.out_of_memory = true;
  alone.failure = "no memory";
  session.on_traced(alone, seconds(1));
  EXPECT_THAT(sent(v1::Envelope::kTileFailed), SizeIs(1)) << "alone, the tile is what is too large";
}

TEST_F(WorkerSessionTest, TellsWhatATileTook) {
  make_ready(7);
  assign(7, 1);
  session.on_traced(trace(wants<StartTrace>().at(0).run), {});
  EXPECT_GT(sent(v1::Envelope::kTileBand).at(0).tile_band().trace_microseconds(), 0u);
}

}  // namespace
}  // namespace tessera
