// Jobs of clients in a store: what outlives a coordinator, and a store that is full.
#include "tests/address_space_limit.h"
#include "tests/unit/coordinator/service_fixture.h"

namespace tessera::testing {
namespace {

TEST_F(ServiceTest, JobsOutliveTheirCoordinator) {
  const uint64_t id = submit(1);
  come(1, 2);
  say("w1", band(assigned().at(0), 1));
  ASSERT_EQ(store->tile_count(), 1u);
  restart();
  EXPECT_EQ(ask(id).state(), v1::JobStatus::QUEUED);
  coordinator.on_tick({});
  EXPECT_EQ(ask(id).tiles_done(), 1u);
  EXPECT_EQ(ask(id).tiles_restored(), 1u);
  come(1, 4);
  ASSERT_EQ(assigned().size(), 3u) << "no tile that is kept";
  for (const v1::Assign& assign : assigned()) say("w1", band(assign, 1));
  EXPECT_EQ(ask(id).state(), v1::JobStatus::ENDED);
  const std::string film = ask(id).end().film_digest();
  restart();
  EXPECT_EQ(ask(id).end().film_digest(), film);
  v1::Envelope request;
  request.mutable_blob_request()->set_digest(film);
  request.mutable_blob_request()->set_length(1 << 20);
  coordinator.on_message(Channel::bulk, "b", request, {});
  EXPECT_EQ(heard(v1::Envelope::kBlobChunk).at(0).blob_chunk().data().size(), 32u * 32 * 12)
      << "put together from its tiles";
  EXPECT_GT(submit(2), id) << "no number is given twice";
}

TEST_F(ServiceTest, EndsOfFramesThatAJobHasNotAreNoEnds) {
  const uint64_t id = submit(1);
  for (const uint32_t frame : {1u, 1u << 31, ~0u}) {
    v1::KeptJob::End end;
    end.set_frame(frame);
    end.mutable_end()->set_film_digest(Digest::of(std::string("x")).hex());
    store->save_end(id, end);
  }
  restart();
  coordinator.on_tick({});
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING);
  EXPECT_EQ(ask(id).frames_done(), 0u);
}

TEST_F(ServiceTest, AJobWithoutMemoryForItsPictureWaitsAndOthersGoOn) {
  if (!AddressSpaceLimit::kWorks) GTEST_SKIP() << AddressSpaceLimit::kWhyNot;
  std::optional<AddressSpaceLimit> limit(std::in_place, rlim_t{256} << 20);
  const uint64_t large = submit(1, 0, 8192);
  EXPECT_EQ(ask(large).state(), v1::JobStatus::HELD);
  EXPECT_EQ(ask(large).failure(),
            "the coordinator has no memory for 8192x8192 pixels with their scene");
  const uint64_t small = submit(2);
  come(1, 4);
  for (const v1::Assign& assign : assigned()) say("w1", band(assign, 1));
  EXPECT_EQ(ask(small).how(), v1::JobEnd::DONE);
  limit.reset();
  coordinator.on_tick(milliseconds(500));
  EXPECT_EQ(ask(large).state(), v1::JobStatus::HELD) << "it is not tried at each moment";
  coordinator.on_tick(seconds(5));
  EXPECT_EQ(ask(large).state(), v1::JobStatus::RUNNING);
}

TEST_F(ServiceTest, TheTimeOfAJobEndsWithIt) {
  const uint64_t job = submit(1);
  come(1, 4);
  const auto elapsed = [&](int seconds) {
    return ask(job, v1::JobQuery::ASK, std::chrono::seconds(seconds)).elapsed_seconds();
  };
  EXPECT_EQ(elapsed(5), 5);
  for (const v1::Assign& assign : assigned()) say("w1", band(assign, 1), std::chrono::seconds(7));
  EXPECT_EQ(ask(job).how(), v1::JobEnd::DONE);
  EXPECT_EQ(elapsed(7), 7);
  EXPECT_EQ(elapsed(60), 7);
}

TEST_F(ServiceTest, FilmsOfFramesThatRunAreHeldToABudget) {
  constexpr uint64_t kFilm = 32 * 32 * 12;
  const auto restart_with = [this](uint64_t budget) {
    CoordinatorOptions options;
    options.opening = opening_of(++openings);
    options.client_budget_bytes = budget;
    coordinator = Coordinator(options, store);
    all.clear();
    to.clear();
  };
  restart_with(2 * kFilm - 1);
  const uint64_t one = submit(1), two = submit(2), small = submit(3, 0, 16);
  EXPECT_EQ(ask(one).state(), v1::JobStatus::RUNNING);
  EXPECT_EQ(ask(two).state(), v1::JobStatus::QUEUED);
  EXPECT_EQ(ask(small).state(), v1::JobStatus::RUNNING) << "there is room for this one";
  const uint64_t animation = submit(4, 0, 32, 1, 5);
  EXPECT_EQ(ask(animation).state(), v1::JobStatus::QUEUED) << "its films are not all there at once";
  come(1, 8);
  for (const v1::Assign& assign : assigned()) say("w1", band(assign, 1));
  EXPECT_EQ(ask(one).how(), v1::JobEnd::DONE);
  EXPECT_EQ(ask(two).state(), v1::JobStatus::RUNNING);
  restart_with(kFilm - 1);
  coordinator.on_tick({});
  EXPECT_EQ(ask(two).how(), v1::JobEnd::FAILED);
  EXPECT_EQ(ask(two).failure(), "a picture of 12288 bytes; expected at most 12287");
}

TEST_F(ServiceTest, APictureWhoseTilesAreGoneIsTracedAgainWhereTheyAre) {
  const uint64_t id = submit(1);
  come(1, 4);
  for (const v1::Assign& assign : assigned()) say("w1", band(assign, 1));
  const std::string film = ask(id).end().film_digest();
  store->drop(Digest::from_hex(store->jobs().at(0).tile_keys(0)), {16, 0, 32, 16});
  restart();
  v1::Envelope request;
  request.mutable_blob_request()->set_digest(film);
  request.mutable_blob_request()->set_length(1 << 20);
  coordinator.on_message(Channel::bulk, "b", request, {});
  EXPECT_EQ(heard(v1::Envelope::kBlobMissing).size(), 1u);
  EXPECT_FALSE(ask(id).has_end());
  coordinator.on_tick({});
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING);
  EXPECT_EQ(ask(id).tiles_restored(), 3u);
  come(1, 4);
  ASSERT_EQ(assigned().size(), 1u);
  say("w1", band(assigned()[0], 1));
  EXPECT_EQ(ask(id).state(), v1::JobStatus::ENDED);
  EXPECT_EQ(ask(id).end().film_digest(), film);
  EXPECT_EQ(ask(id).frames_done(), 1u);
  restart();
  coordinator.on_message(Channel::bulk, "b", request, {});
  EXPECT_EQ(heard(v1::Envelope::kBlobChunk).size(), 1u);
}

TEST_F(ServiceTest, WhatAnEarlierCoordinatorGaveOutIsTaken) {
  const uint64_t id = submit(1);
  come(1, 2);
  v1::Envelope early = band(assigned().at(0), 1), later = band(assigned().at(1), 1);
  names.complete(early);
  names.complete(later);
  restart();
  coordinator.on_tick({});
  say("w1", hello(1, 2));
  say("w1", early);
  EXPECT_EQ(ask(id).tiles_done(), 1u);
  later.mutable_tile_band()->set_opening(opening_of(openings));
  say("w1", later);
  EXPECT_EQ(ask(id).tiles_done(), 1u) << "this coordinator gave no such lease";
}

// A store is restored from a copy that was made before a job came: its number is given again.
TEST_F(ServiceTest, ResultsOfAnotherJobOfTheSameNumberDoNotCount) {
  submit(1);
  const MemoryJobStore copy = *store;
  const uint64_t lost = submit(2);
  come(1, 8);
  std::vector<v1::Envelope> results;
  for (const v1::Assign& assign : assigned()) {
    if (job_of(assign) == lost) results.push_back(band(assign, 9));
  }
  ASSERT_FALSE(results.empty());
  for (v1::Envelope& result : results) names.complete(result);
  *store = copy;
  restart();
  const uint64_t other = submit(3);
  ASSERT_EQ(other, lost) << "the numbers repeat";
  restart();
  coordinator.on_tick({});
  say("w1", hello(1, 2));
  for (const v1::Envelope& result : results) say("w1", result);
  EXPECT_EQ(ask(other).tiles_done(), 0u);
  // A heartbeat that lists what it holds of the lost job claims no tile of the other.
  v1::Envelope heartbeat;
  heartbeat.mutable_heartbeat()->set_session(2);
  v1::Heartbeat::Job& known = *heartbeat.mutable_heartbeat()->add_jobs();
  known.set_job(results[0].tile_band().job());
  known.set_frame_id(results[0].tile_band().frame_id());
  known.set_ready(true);
  say("w1", heartbeat);
  EXPECT_FALSE(heard(v1::Envelope::kCancelJob).empty()) << "it is told to forget that one";
}

TEST_F(ServiceTest, ANameHasABound) {
  BlobStore blobs;
  v1::Envelope message = submission(5, job(32), blobs);
  message.mutable_submit_job()->set_name(std::string(kMostName + 1, 'x'));
  submit_with(message, blobs);
  const v1::JobStatus status = heard(v1::Envelope::kJobStatus).back().job_status();
  EXPECT_EQ(status.state(), v1::JobStatus::ENDED);
  EXPECT_NE(status.failure().find("a name of 1001 bytes"), std::string::npos) << status.failure();
  message.mutable_submit_job()->set_submission(6);
  message.mutable_submit_job()->set_name(std::string(kMostName, 'x'));
  submit_with(message, blobs);
  EXPECT_NE(heard(v1::Envelope::kJobStatus).back().job_status().job(), 0u);
}

TEST_F(ServiceTest, OneClientDoesNotKeepOthersOut) {
  const auto state = [this](const std::string& peer, uint64_t number) {
    BlobStore blobs;
    v1::Envelope message = submission(number, job(32), blobs);
    // Each is of a scene that never comes.
    v1::JobFrame& frame = *message.mutable_submit_job()->mutable_frames(0);
    frame.set_scene_digest(Digest::of(std::to_string(number)).hex());
    say(peer, message, {});
    return heard(v1::Envelope::kJobStatus).back().job_status().state();
  };
  for (uint64_t i = 1; i <= 8; ++i) EXPECT_EQ(state("greedy", i), v1::JobStatus::FETCHING);
  for (uint64_t i = 9; i <= 100; ++i) EXPECT_EQ(state("greedy", i), v1::JobStatus::ENDED);
  EXPECT_EQ(state("other", 200), v1::JobStatus::FETCHING);
}

TEST_F(ServiceTest, ACancelledJobIsTakenFromItsWorkersAtOnce) {
  const uint64_t id = submit(1);
  come(1, 2);
  EXPECT_EQ(ask(id, v1::JobQuery::CANCEL).how(), v1::JobEnd::INTERRUPTED);
  EXPECT_EQ(heard(v1::Envelope::kCancelJob).size(), 1u);
  say("w1", band(assigned().at(0), 1));
  EXPECT_EQ(ask(id).tiles_done(), 0u);
  EXPECT_EQ(ask(id, v1::JobQuery::FORGET).state(), v1::JobStatus::UNKNOWN);
  EXPECT_EQ(ask(id).state(), v1::JobStatus::UNKNOWN);
  EXPECT_TRUE(store->jobs().empty());
}

TEST_F(ServiceTest, AFullStorePausesAllAndIsTold) {
  const uint64_t id = submit(1, 0, 64);
  come(1, 2);
  store->set_full(true);
  say("w1", band(assigned().at(0), 1));
  EXPECT_EQ(ask(id).failure(), "the store is full");
  EXPECT_EQ(coordinator.snapshot({}).store_trouble, "the store is full");
  say("w1", band(assigned().at(1), 1));
  EXPECT_EQ(assigned().size(), 2u) << "none is given out that could not be kept";
  EXPECT_EQ(store->tile_count(), 0u);
  store->set_full(false);
  coordinator.on_tick(milliseconds(100));
  EXPECT_EQ(store->tile_count(), 2u) << "what had come is kept now";
  EXPECT_EQ(assigned().size(), 4u) << "and it goes on";
  EXPECT_EQ(ask(id).failure(), "");
}

TEST_F(ServiceTest, AJobEndsOnlyOnceAllOfItIsKept) {
  const uint64_t id = submit(1, 0, 16);
  come(1, 1);
  store->set_full(true);
  say("w1", band(assigned().at(0), 1));
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING);
  store->set_full(false);
  coordinator.on_tick(milliseconds(100));
  EXPECT_EQ(ask(id).state(), v1::JobStatus::ENDED);
}

TEST_F(ServiceTest, NobodyIsToldOfAnEndThatIsNotKept) {
  // The tile is kept, its job's end is not.
  struct Endless : MemoryJobStore {
    using MemoryJobStore::MemoryJobStore;
    void save_end(uint64_t job, const v1::KeptJob::End& end) override {
      if (full) throw render_error("the store is full");
      MemoryJobStore::save_end(job, end);
    }
    bool full = true;
  };
  const auto endless = std::make_shared<Endless>(7);
  store = endless;
  restart();
  const uint64_t id = submit(1, 0, 16);
  come(1, 1);
  say("w1", band(assigned().at(0), 1));
  EXPECT_EQ(store->tile_count(), 1u);
  EXPECT_EQ(ask(id).state(), v1::JobStatus::RUNNING);
  EXPECT_FALSE(ask(id).has_end());
  EXPECT_EQ(ask(id).failure(), "the store is full");
  endless->full = false;
  coordinator.on_tick(milliseconds(100));
  EXPECT_EQ(ask(id).state(), v1::JobStatus::ENDED);
  restart();
  coordinator.on_tick({});
  EXPECT_EQ(ask(id).state(), v1::JobStatus::ENDED);
}

TEST_F(ServiceTest, ForgettingKeepsWhatOtherJobsNeed) {
  const uint64_t one = submit(1), two = submit(2);
  ask(one, v1::JobQuery::CANCEL);
  ask(one, v1::JobQuery::FORGET);
  restart();
  coordinator.on_tick({});
  EXPECT_EQ(ask(two).state(), v1::JobStatus::RUNNING) << "with the scene that both have";
  ask(two, v1::JobQuery::CANCEL);
  const Digest scene = *Digest::parse(store->jobs().at(0).blobs(0));
  EXPECT_TRUE(store->has_blob(scene));
  ask(two, v1::JobQuery::FORGET);
  EXPECT_FALSE(store->has_blob(scene));
}

TEST_F(ServiceTest, WhoSendsMuchIsAnsweredBeforeItsHeartbeatComes) {
  submit(1);
  come(1, 2);
  const size_t before = heard(v1::Envelope::kPing).size();
  for (const int second : {3, 4}) {
    say("w1", band(assigned().at(0), 1), std::chrono::seconds(second));
    say("w1", band(assigned().at(0), 1), std::chrono::milliseconds(1000 * second + 1));
  }
  const auto pings = heard(v1::Envelope::kPing);
  ASSERT_EQ(pings.size(), before + 2);
  EXPECT_EQ(pings.back().ping().results(), 0u) << "it may forget nothing yet";
}

TEST_F(ServiceTest, ForgettingKeepsAPictureThatAnotherJobHasToo) {
  // Of other seeds, and so of other tiles, but of the same bits.
  std::vector<uint64_t> ids;
  for (const uint32_t seed : {1u, 2u}) ids.push_back(submit(seed, 0, 16));
  come(1, 2);
  for (const v1::Assign& assign : assigned()) say("w1", band(assign, 1));
  for (const uint64_t id : ids) ASSERT_TRUE(coordinator.film(id, 0)) << id;
  ask(ids[0], v1::JobQuery::FORGET);
  EXPECT_FALSE(coordinator.film(ids[0], 0));
  EXPECT_TRUE(coordinator.film(ids[1], 0));
}

TEST_F(ServiceTest, AReleasedJobIsForgottenOnceTheStoreIsWritable) {
  BlobStore blobs;
  submit_with(submission(77, job(16), blobs), blobs);
  ask(heard(v1::Envelope::kJobStatus).back().job_status().job(), v1::JobQuery::CANCEL);
  store->set_full(true);
  v1::Envelope release;
  release.mutable_job_release()->set_submission(77);
  say("client", release);
  EXPECT_EQ(store->jobs().size(), 1u);
  store->set_full(false);
  coordinator.on_tick(std::chrono::minutes(2));
  EXPECT_TRUE(store->jobs().empty());
}

TEST_F(ServiceTest, AFailedSubmissionTakesNothingFromOthers) {
  JobSpec spec = job(16);
  v1::BlobRef& positions =
      *spec.scene.add_nodes()->mutable_shape()->mutable_mesh()->mutable_positions();
  positions.set_digest(Digest::of(std::span<const std::byte>()).hex());
  positions.set_size(uint64_t{1} << 63);
  BlobStore blobs;
  submit_with(submission(78, spec, blobs), blobs);
  v1::Envelope question;
  question.mutable_job_query()->set_submission(78);
  say("client", question);
  EXPECT_EQ(heard(v1::Envelope::kJobStatus).back().job_status().state(), v1::JobStatus::ENDED);
  v1::Envelope release;
  release.mutable_job_release()->set_submission(78);
  say("client", release);
  EXPECT_NE(submit(1), 0u);
}

TEST_F(ServiceTest, TheNextFrameBeginsWhileTheLastTilesOfOneAreOut) {
  const uint64_t id = submit(1, 0, 32, 1, 3);
  come(1, 6);
  get_ready("w1");
  EXPECT_EQ(assigned().size(), 6u) << "four of the first frame, two of the second";
  const FarmSnapshot snapshot = coordinator.snapshot({});
  EXPECT_EQ(snapshot.jobs.at(0).frames_running, std::vector<uint32_t>({0, 1}));
  for (size_t i = 0; i < 12; ++i) {
    get_ready("w1");
    say("w1", band(assigned().at(i), 1));
  }
  EXPECT_EQ(ask(id).frames_done(), 3u);
  EXPECT_EQ(ask(id).how(), v1::JobEnd::DONE);
}

TEST_F(ServiceTest, IsShownAsItIs) {
  const uint64_t id = submit(1);
  come(1, 2);
  say("w1", band(assigned().at(0), 0.25f), seconds(1));
  const FarmSnapshot snapshot = coordinator.snapshot(seconds(2));
  ASSERT_EQ(snapshot.jobs.size(), 1u);
  EXPECT_EQ(snapshot.jobs[0].state, FarmSnapshot::JobState::running);
  EXPECT_EQ(snapshot.jobs[0].tiles_done, 1u);
  ASSERT_EQ(snapshot.workers.size(), 1u);
  EXPECT_EQ(snapshot.workers[0].tiles_done, 1u);
  EXPECT_EQ(snapshot.workers[0].tile_seconds, 1);
  EXPECT_EQ(snapshot.workers[0].tiles_held, 2u);
  EXPECT_EQ(snapshot.counters.tiles_done, 1u);
  const auto tiles = coordinator.tiles(id, 0, seconds(2));
  ASSERT_EQ(tiles.size(), 4u);
  EXPECT_EQ(tiles[0].state, TileSnapshot::State::done);
  EXPECT_EQ(tiles[0].worker, 1u);
  EXPECT_EQ(tiles[1].state, TileSnapshot::State::assigned);
  EXPECT_EQ(tiles[1].seconds, 2);
  EXPECT_EQ(tiles[3].state, TileSnapshot::State::pending);
  const auto preview = coordinator.preview(id, 0, 8);
  ASSERT_TRUE(preview);
  EXPECT_EQ(preview->width, 8);
  EXPECT_EQ(preview->rgb.size(), 8u * 8 * 3);
  EXPECT_EQ(preview->rgb[0], 137) << "0.25 in sRGB";
  EXPECT_EQ(preview->rgb[4 * 3], 0) << "not there yet";
  EXPECT_FALSE(coordinator.preview(id, 1, 8));
  EXPECT_TRUE(coordinator.tiles(9, 0, {}).empty());
}

TEST_F(ServiceTest, AFrameOfWhichNothingDiffersIsTakenFromTheOneBefore) {
  v1::Envelope message;
  v1::SubmitJob& request = *message.mutable_submit_job();
  request.set_submission(5);
  request.set_detached(true);
  request.set_tile_size(16);
  request.mutable_crop()->set_x1(32);
  request.mutable_crop()->set_y1(32);
  BlobStore blobs;
  const auto add_frame = [&](double time, bool moving) {
    JobSpec spec = job(32);
    if (moving) spec.scene.add_cameras()->add_keys()->set_time(1);
    spec.frame.set_time(time);
    v1::JobFrame& frame = *request.add_frames();
    const std::string scene = serialize_scene(spec.scene);
    const auto bytes = std::as_bytes(std::span(scene));
    frame.set_scene_digest(blobs.put({bytes.begin(), bytes.end()}).hex());
    frame.set_scene_size(bytes.size());
    *frame.mutable_settings() = spec.frame;
  };
  add_frame(0, false);
  add_frame(1, false);  // another instant, and nothing moves
  add_frame(0, true);
  add_frame(1, true);
  submit_with(message, blobs);
  const uint64_t id = heard(v1::Envelope::kJobStatus).back().job_status().job();
  ASSERT_NE(id, 0u);
  come(1, 100);
  for (size_t i = 0; i < assigned().size(); ++i) {
    const v1::Assign assign = assigned()[i];
    say("w1", band(assign, 1));
    get_ready("w1");
  }
  EXPECT_EQ(ask(id).frames_done(), 4u);
  EXPECT_EQ(ask(id).how(), v1::JobEnd::DONE);
  EXPECT_EQ(assigned().size(), 12u) << "four tiles of each frame but the second";
  EXPECT_EQ(ask(id).tiles_restored(), 4u);
}

TEST_F(ServiceTest, TilesAreCutForTheThreadsThatThereAre) {
  const auto tile_size = [&](uint32_t threads) {
    restart();
    v1::Envelope message = hello(threads);
    message.mutable_hello()->set_threads(threads);
    say("w", message);
    message = {};
    v1::SubmitJob& request = *message.mutable_submit_job();
    request.set_submission(100 + threads);
    request.set_detached(true);
    request.mutable_crop()->set_x1(1024);
    request.mutable_crop()->set_y1(1024);
    JobSpec spec = job(1024);
    v1::JobFrame& frame = *request.add_frames();
    const std::string scene = serialize_scene(spec.scene);
    const auto bytes = std::as_bytes(std::span(scene));
    BlobStore blobs;
    frame.set_scene_digest(blobs.put({bytes.begin(), bytes.end()}).hex());
    frame.set_scene_size(bytes.size());
    *frame.mutable_settings() = spec.frame;
    submit_with(message, blobs);
    return store->jobs().back().request().tile_size();
  };
  const uint32_t for_one = tile_size(1), for_many = tile_size(64);
  EXPECT_GT(for_one, for_many);
  v1::Envelope query;
  query.mutable_job_list_query();
  say("client", query);
  EXPECT_EQ(heard(v1::Envelope::kJobList).back().job_list().threads(), 64u);
}

TEST_F(ServiceTest, WhatLooksPastEverythingIsFilledAsItsWorkerSays) {
  const uint64_t id = submit(1, 0, 64);
  say("w1", hello(1));
  v1::Envelope message;
  v1::SceneReady& ready = *message.mutable_scene_ready();
  ready.set_session(1);
  ready.set_job(job_id());
  for (const float channel : {0.1f, 0.2f, 0.3f}) ready.mutable_unseen()->add_value(channel);
  ready.mutable_unseen()->mutable_seen()->set_x1(17);
  ready.mutable_unseen()->mutable_seen()->set_y1(16);
  (*ready.mutable_unseen()->mutable_counters()->mutable_values())["samples"] = 1;
  say("w1", message);
  EXPECT_EQ(ask(id).tiles_done(), 14u) << "all but two tiles of sixteen";
  EXPECT_EQ(store->tile_count(), 14u);
  ASSERT_EQ(assigned().size(), 2u);
  for (const v1::Assign& assign : assigned()) {
    EXPECT_LT(assign.rect().x0(), 17);
    EXPECT_EQ(assign.rect().y0(), 0);
    say("w1", band(assign, 1));
  }
  EXPECT_EQ(ask(id).end().totals().values().at("filled"), 14u);
  EXPECT_EQ(ask(id).end().counters().values().at("samples"), 14u * 256);
}

TEST_F(ServiceTest, AWorkerThatLeavesGetsNoMoreAndItsQueueIsGivenToOthers) {
  submit(1);
  come(1, 2);
  come(2, 2);
  const std::vector<v1::Assign> given = assigned();
  ASSERT_EQ(given.size(), 4u);
  v1::Envelope message;
  v1::Heartbeat& heartbeat = *message.mutable_heartbeat();
  heartbeat.set_session(1);
  heartbeat.set_leaves(true);
  heartbeat.add_jobs()->set_job(given[0].job());
  heartbeat.mutable_jobs(0)->set_ready(true);
  auto& begun = *heartbeat.add_progress();
  begun.set_job(given[0].job());
  begun.set_lease(given[0].lease());
  begun.set_started(true);
  say("w1", message);
  for (size_t i = 2; i < 4; ++i) say("w2", band(given[i], 1));
  ASSERT_EQ(assigned().size(), 5u);
  EXPECT_EQ(assigned().back().tile(), given[1].tile());
  say("w1", band(given[0], 1));
  EXPECT_EQ(assigned().size(), 5u) << "its last tile brings it no other";
}

TEST_F(ServiceTest, FramesThatWereCancelledAreNotDone) {
  const uint64_t id = submit(1, 0, 32, 1, 3);
  come(1, 4);
  for (size_t i = 0; i < 4; ++i) say("w1", band(assigned().at(i), 1));
  EXPECT_EQ(ask(id).frames_done(), 1u);
  get_ready("w1");
  ask(id, v1::JobQuery::CANCEL);
  EXPECT_EQ(ask(id).state(), v1::JobStatus::ENDED);
  EXPECT_EQ(ask(id).frames_done(), 1u);
  restart();
  EXPECT_EQ(ask(id).frames_done(), 1u);
}

}  // namespace
}  // namespace tessera::testing
