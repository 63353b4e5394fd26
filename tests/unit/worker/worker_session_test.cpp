#include "tests/unit/worker/worker_session_fixture.h"

namespace tessera {
namespace {

TEST_F(WorkerSessionTest, GoesFromHelloToBands) {
  EXPECT_THAT(sent(v1::Envelope::kHello), SizeIs(1));
  welcome(1);
  EXPECT_EQ(wants<ConnectBulk>().at(0).endpoint, "tcp://:9");
  start(7);
  serve_blobs();
  const auto builds = wants<StartBuild>();
  ASSERT_THAT(builds, SizeIs(1));
  EXPECT_EQ(builds[0].run->scene().metadata().title(), "x");
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

TEST_F(WorkerSessionTest, TilesThatWaitForATreeGetOnWithIt) {
  struct Building : testing::FakeRenderer {
    using FakeRenderer::FakeRenderer;
    bool builds() const override { return building; }
    bool building = true;
  };
  const auto renderer = std::make_shared<Building>(5);
  welcome(1);
  start(7);
  serve_blobs();
  session.on_built({.job = 7, .frame_id = {}, .renderer = renderer, .seconds = 1, .failure = {}},
                   {});
  assign(7, 11);
  assign(7, 12);
  const auto runs = wants<StartTrace>();
  runs[0].run->started = true;
  runs[0].run->progress.work_done = 99;
  sent(v1::Envelope::kHeartbeat);
  const auto told = [&](Time now) {
    session.on_tick(now);
    ping(0, now);
    const v1::Heartbeat heartbeat = sent(v1::Envelope::kHeartbeat).at(0).heartbeat();
    return std::pair(heartbeat.progress(0).work_done(), heartbeat.progress(1).work_done());
  };
  EXPECT_EQ(told(seconds(1)), std::pair(uint64_t{100}, uint64_t{0}));
  EXPECT_EQ(told(seconds(2)), std::pair(uint64_t{101}, uint64_t{0})) << "what has not begun waits";
  renderer->building = false;
  EXPECT_EQ(told(seconds(3)).first, 101u) << "one that hangs is noticed";
  runs[0].run->progress.work_done = 100;
  EXPECT_EQ(told(seconds(4)).first, 102u);
}

TEST_F(WorkerSessionTest, ComesAnewWhenTheCoordinatorIsSilent) {
  make_ready(7);
  assign(7, 11);
  const auto run = wants<StartTrace>().at(0).run;
  run_until(seconds(5));
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
  run_until(seconds(5));
  welcome(2, seconds(6), 1);
  EXPECT_FALSE(run->progress.cancelled);
  start(7, seconds(6));
  EXPECT_THAT(sent(v1::Envelope::kSceneReady), SizeIs(1)) << "nothing is built again";
}

TEST_F(WorkerSessionTest, DoesNotHeedTheRefusalOfAHelloBeforeItsLast) {
  make_ready(7);
  v1::Envelope message;
  message.mutable_reject()->set_reason(v1::Reject::ID_TAKEN);
  message.mutable_reject()->set_session(99);
  session.on_message(Channel::control, message, {});
  EXPECT_THAT(wants<Quit>(), SizeIs(0));
  message.mutable_reject()->set_session(1);
  session.on_message(Channel::control, message, {});
  EXPECT_THAT(wants<Quit>(), SizeIs(1));
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

TEST_F(WorkerSessionTest, GivesUpAsAnOrphan) {
  run_until(seconds(29));
  EXPECT_THAT(wants<Quit>(), IsEmpty());
  run_until(seconds(30));
  EXPECT_EQ(wants<Quit>().at(0).exit_code, ExitCode::render_failed);
}

TEST_F(WorkerSessionTest, WhoWasStoppedAsksBeforeItTakesTheCoordinatorForSilent) {
  make_ready(7);
  session.on_tick(seconds(1));
  ping(0, seconds(1));
  wants<SendMessage>();
  session.on_tick(seconds(66));
  EXPECT_THAT(wants<Quit>(), IsEmpty());
  EXPECT_THAT(wants<Reconnect>(), IsEmpty()) << "what was said meanwhile may wait to be read";
  EXPECT_THAT(sent(v1::Envelope::kHeartbeat), SizeIs(1));
  // The coordinator, which was there all the time, has given it up.
  v1::Envelope request;
  request.mutable_hello_request();
  session.on_message(Channel::control, request, seconds(66));
  EXPECT_THAT(sent(v1::Envelope::kHello), SizeIs(1));
  welcome(2, seconds(67));
  run_until(seconds(71));
  EXPECT_TRUE(session.is_welcome());
}

TEST_F(WorkerSessionTest, WhoWasStoppedGivesUpOnceItHasListened) {
  make_ready(7);
  session.on_tick(seconds(1));
  ping(0, seconds(1));
  session.on_tick(seconds(66));
  run_until(milliseconds(70'999));
  EXPECT_THAT(wants<Reconnect>(), IsEmpty());
  run_until(seconds(71));
  EXPECT_THAT(wants<Reconnect>(), SizeIs(1)) << "the connection may be dead";
  run_until(milliseconds(95'999));
  EXPECT_THAT(wants<Quit>(), IsEmpty());
  run_until(seconds(96));
  EXPECT_EQ(wants<Quit>().at(0).reason, "the coordinator is silent");
}

TEST_F(WorkerSessionTest, WhoIsStoppedJustBeforeItGivesUpAsksOnceMore) {
  run_until(milliseconds(29'900));
  session.on_tick(seconds(95));
  EXPECT_THAT(wants<Quit>(), IsEmpty());
  run_until(milliseconds(96'900));
  EXPECT_THAT(wants<Quit>(), IsEmpty());
  EXPECT_THAT(sent(v1::Envelope::kHello), ::testing::Not(IsEmpty()));
  run_until(seconds(98));
  EXPECT_THAT(wants<Quit>(), SizeIs(1));
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

TEST_F(WorkerSessionTest, ReportsATileThatCannotBeTraced) {
  make_ready(7);
  assign(7, 11);
  TraceOutcome outcome;
  outcome.run = wants<StartTrace>().at(0).run;
  outcome.failure = "no";
  session.on_traced(std::move(outcome), {});
  EXPECT_EQ(sent(v1::Envelope::kTileFailed).at(0).tile_failed().text(), "no");
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
  run_until(seconds(6));
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
  run_until(seconds(5));
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
  run_until(seconds(30));
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
