#include "coordinator/coordinator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <tuple>

#include "base/log.h"
#include "proto/wire/blob_transfer.h"
#include "proto/wire/pixels.h"
#include "proto/wire/scene_codec.h"

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

/// Keeps tiles in memory, for one job; `full`: takes none.
struct FakeStore : TileStore {
  void keep(const Digest& job, const FinishedTile& tile) override {
    if (full) throw render_error("full");
    key = job;
    tiles.push_back(tile);
  }
  void drop(const Digest&, const PixelRect& tile) override {
    std::erase_if(tiles, [&](const FinishedTile& t) { return t.rect == tile; });
  }
  std::vector<FinishedTile> find(const Digest& job) override {
    return job == key ? tiles : std::vector<FinishedTile>();
  }
  bool full = false;
  Digest key;
  std::vector<FinishedTile> tiles;
};

class StoreTest : public CoordinatorTest {
 protected:
  JobSpec stored_job() {
    JobSpec spec = job();
    spec.store = store;
    return spec;
  }
  /// Traces the first `count` tiles that it is given.
  void trace(uint64_t id, size_t count) {
    say("p", hello(1));
    ready("p", id);
    for (size_t i = 0; i < count; ++i) {
      const auto assigns = heard(v1::Envelope::kAssign);
      ASSERT_GT(assigns.size(), i);
      const v1::Assign& assign = assigns[i].assign();
      v1::Envelope message = band(assign, static_cast<float>(1 + assign.tile()));
      (*message.mutable_tile_band()->mutable_counters()->mutable_values())["samples"] = 256;
      say("p", message);
    }
  }
  std::shared_ptr<FakeStore> store = std::make_shared<FakeStore>();
};

TEST_F(StoreTest, KeptTilesAreNotTracedAgain) {
  trace(coordinator.submit(stored_job(), {}), 3);
  ASSERT_EQ(store->tiles.size(), 3u);
  coordinator = Coordinator(CoordinatorOptions{});
  all.clear();
  const uint64_t id = coordinator.submit(stored_job(), {});
  trace(id, 1);
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_EQ(heard(v1::Envelope::kAssign).size(), 1u);
  EXPECT_EQ(result->report.tiles_done, 4u);
  EXPECT_EQ(result->report.tiles_restored, 3u);
  EXPECT_EQ(result->report.counters.at("samples"), 4u * 256);
  for (const auto& [x, y, value] :
       {std::tuple{0, 0, 1.f}, {16, 0, 2.f}, {0, 16, 3.f}, {31, 31, 4.f}}) {
    EXPECT_EQ(result->film.values()[static_cast<size_t>(3 * (32 * y + x))], value) << x << " " << y;
  }
}

TEST_F(StoreTest, TilesOfAnotherJobAreNotTakenUp) {
  trace(coordinator.submit(stored_job(), {}), 4);
  JobSpec other = stored_job();
  other.frame.set_seed(7);
  coordinator.submit(std::move(other), {});
  EXPECT_EQ(coordinator.progress({}).tiles_done, 0u);
}

TEST_F(StoreTest, AJobWhoseTilesAreAllKeptEndsWithoutWorkers) {
  trace(coordinator.submit(stored_job(), {}), 4);
  coordinator = Coordinator(CoordinatorOptions{});
  const uint64_t id = coordinator.submit(stored_job(), {});
  coordinator.on_tick({});
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.tiles_restored, 4u);
  EXPECT_EQ(result->report.end, JobReport::End::done);
}

TEST_F(StoreTest, DamagedTilesAreTracedAgain) {
  trace(coordinator.submit(stored_job(), {}), 3);
  v1::TileBand& damaged = *store->tiles[1].kept.mutable_bands(0);
  damaged.set_pixel_crc(damaged.pixel_crc() + 1);
  store->tiles[2].rect.x1 += 1;
  coordinator = Coordinator(CoordinatorOptions{});
  coordinator.submit(stored_job(), {});
  EXPECT_EQ(coordinator.progress({}).tiles_done, 1u);
}

TEST_F(StoreTest, WhatAFullDiskDidNotTakeIsKeptLater) {
  store->full = true;
  const uint64_t id = coordinator.submit(stored_job(), {});
  trace(id, 3);
  EXPECT_TRUE(store->tiles.empty());
  store->full = false;
  const auto assigns = heard(v1::Envelope::kAssign);
  say("p", band(assigns[3].assign(), 4));
  EXPECT_EQ(store->tiles.size(), 4u);
  EXPECT_EQ(coordinator.take_result(id)->report.end, JobReport::End::done);
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
  say("stays", hello(3));
  coordinator.submit(job(), {});
  coordinator.on_peer_gone("lost", {});
  JobReport report = end("stays");
  EXPECT_EQ(report.workers_seen, 2u);
  EXPECT_EQ(report.workers_lost, 1u);

  coordinator.submit(job(), {});
  report = end("stays");
  EXPECT_EQ(report.workers_seen, 1u);
  EXPECT_EQ(report.workers_lost, 0u);

  coordinator.submit(job(), {});
  for (int i = 0; i < 2; ++i) say("back", hello(2, static_cast<uint64_t>(2 + i)));
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
  heartbeat.mutable_heartbeat()->set_job(id);
  heartbeat.mutable_heartbeat()->set_ready(true);
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

TEST_F(CoordinatorTest, OneWorkerIsNotBelievedThatASceneIsBad) {
  const auto failed = [](uint64_t id, uint32_t code) {
    v1::Envelope message;
    message.mutable_scene_failed()->set_session(1);
    message.mutable_scene_failed()->set_job(id);
    message.mutable_scene_failed()->set_exit_code(code);
    message.mutable_scene_failed()->set_text("bad");
    return message;
  };
  const uint64_t id = coordinator.submit(job(), {});
  say("p", hello(1));
  say("q", hello(2));
  say("p", failed(id, 1));
  say("p", failed(id, 1));
  EXPECT_FALSE(coordinator.take_result(id)) << "the other has not said it";
  say("q", failed(id, 1));
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.exit_code, ExitCode::bad_scene);
  // The last one there is believed, also when the other goes after it spoke.
  const uint64_t next = coordinator.submit(job(), {});
  say("p", failed(next, 1));
  coordinator.on_peer_gone("q", {});
  say("p", failed(next, 1));
  ASSERT_TRUE(coordinator.take_result(next));
}

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
  heartbeat.mutable_heartbeat()->set_job(id);
  for (int second_of_time = 1; second_of_time <= 10; ++second_of_time) {
    EXPECT_FALSE(coordinator.take_result(id));
    say("q", heartbeat, seconds(second_of_time));
    coordinator.on_tick(seconds(second_of_time));
  }
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_THAT(result->report.failure, ::testing::HasSubstr("no third"));
}

class ClientTest : public CoordinatorTest {
 protected:
  v1::Envelope submission(uint64_t number, const JobSpec& spec) {
    v1::Envelope message;
    v1::SubmitJob& submit = *message.mutable_submit_job();
    submit.set_submission(number);
    const std::string bytes = serialize_scene(spec.scene);
    const auto span = std::as_bytes(std::span(bytes));
    submit.set_scene_digest(store.put({span.begin(), span.end()}).hex());
    submit.set_scene_size(bytes.size());
    *submit.mutable_frame() = spec.frame;
    submit.mutable_crop()->set_x1(spec.crop.x1);
    submit.mutable_crop()->set_y1(spec.crop.y1);
    return message;
  }
  /// The answers to all that was asked of clients.
  std::vector<v1::Envelope> chunks() {
    std::vector<v1::Envelope> result;
    for (const auto& message : heard(v1::Envelope::kBlobRequest)) {
      const auto& request = message.blob_request();
      result.push_back(answer_blob_request(request, store.find(*Digest::parse(request.digest()))));
    }
    return result;
  }
  v1::JobStatus status() { return heard(v1::Envelope::kJobStatus).back().job_status(); }
  v1::JobStatus ask(uint64_t number, bool cancel) {
    v1::Envelope message;
    message.mutable_job_query()->set_submission(number);
    message.mutable_job_query()->set_cancel(cancel);
    say("client", message);
    return status();
  }
  BlobStore store;
};

TEST_F(ClientTest, CancelsAQueuedJobAtOnce) {
  coordinator.submit(job(), {});
  say("client", submission(42, job()));
  for (const auto& chunk : chunks()) coordinator.on_message(Channel::bulk, "b", chunk, {});
  EXPECT_EQ(ask(42, false).state(), v1::JobStatus::QUEUED);
  const v1::JobStatus cancelled = ask(42, true);
  EXPECT_EQ(cancelled.state(), v1::JobStatus::ENDED);
  EXPECT_EQ(cancelled.end().how(), v1::JobEnd::INTERRUPTED);
}

TEST_F(ClientTest, AreToldWhyTheirJobsDoNotEnd) {
  say("client", submission(42, job()));
  for (const auto& chunk : chunks()) coordinator.on_message(Channel::bulk, "b", chunk, {});
  ASSERT_EQ(ask(42, false).state(), v1::JobStatus::RUNNING);
  coordinator.shut_down("told to end");
  const v1::JobStatus last = status();
  EXPECT_EQ(last.state(), v1::JobStatus::ENDED);
  EXPECT_EQ(last.end().how(), v1::JobEnd::FAILED);
  EXPECT_EQ(last.end().failure(), "told to end");
}

TEST_F(ClientTest, TakesBlobsOnlyFromWhoWasAsked) {
  say("client", submission(42, job()));
  const auto sound = chunks();
  ASSERT_FALSE(sound.empty());
  for (const uint64_t guess : {0, 41}) {
    v1::Envelope forged = sound[0];
    forged.mutable_blob_chunk()->set_submission(guess);
    forged.mutable_blob_chunk()->set_data("x");
    for (int i = 0; i < 5; ++i) coordinator.on_message(Channel::bulk, "evil", forged, {});
    forged.mutable_blob_missing()->set_digest(sound[0].blob_chunk().digest());
    forged.mutable_blob_missing()->set_submission(guess);
    coordinator.on_message(Channel::bulk, "evil", forged, {});
  }
  EXPECT_EQ(ask(42, false).state(), v1::JobStatus::FETCHING);
  for (const auto& chunk : sound) coordinator.on_message(Channel::bulk, "b", chunk, {});
  EXPECT_EQ(ask(42, false).state(), v1::JobStatus::RUNNING);
}

TEST_F(ClientTest, AreHeldToABudgetTogether) {
  const auto submit = [this](uint64_t number, uint64_t bytes) {
    v1::Envelope message = submission(number, job());
    message.mutable_submit_job()->add_blobs(Digest::of(std::to_string(number)).hex());
    message.mutable_submit_job()->add_blob_sizes(bytes);
    say("client", message);
    return status();
  };
  EXPECT_EQ(submit(1, uint64_t{16} << 30).state(), v1::JobStatus::FETCHING);
  EXPECT_EQ(submit(2, uint64_t{15} << 30).state(), v1::JobStatus::FETCHING);
  EXPECT_EQ(submit(3, uint64_t{2} << 30).state(), v1::JobStatus::ENDED);
  EXPECT_EQ(submit(4, ~uint64_t{0}).state(), v1::JobStatus::ENDED);
  EXPECT_EQ(ask(1, true).state(), v1::JobStatus::ENDED);
  v1::Envelope release;
  release.mutable_job_release()->set_submission(1);
  say("client", release);
  EXPECT_EQ(submit(5, uint64_t{2} << 30).state(), v1::JobStatus::FETCHING) << "there is room again";
  EXPECT_EQ(submit(0, 1).state(), v1::JobStatus::ENDED) << "no number";
}

TEST_F(ClientTest, FilmDownloadsAreNoBytesOfTheSceneOfTheNextJob) {
  say("client", submission(42, job(16)));
  for (const auto& chunk : chunks()) coordinator.on_message(Channel::bulk, "b", chunk, {});
  say("p", hello(1));
  ready("p", job_id());
  say("p", band(heard(v1::Envelope::kAssign).at(0).assign(), 1));
  const uint64_t next = coordinator.submit(job(), {});
  const v1::JobStatus ended = ask(42, false);
  ASSERT_EQ(ended.end().film_size(), 16u * 16 * 12);
  v1::Envelope request;
  request.mutable_blob_request()->set_digest(ended.end().film_digest());
  request.mutable_blob_request()->set_length(1 << 20);
  coordinator.on_message(Channel::bulk, "b", request, {});
  EXPECT_EQ(heard(v1::Envelope::kBlobChunk).at(0).blob_chunk().data().size(), 16u * 16 * 12);
  coordinator.interrupt(next, {});
  EXPECT_EQ(coordinator.take_result(next)->report.bytes_scene, 0u);
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
  // Whatever else it says.
  const size_t assigns = heard(v1::Envelope::kAssign).size();
  ready("p", id);
  v1::Envelope heartbeat;
  heartbeat.mutable_heartbeat()->set_session(1);
  heartbeat.mutable_heartbeat()->set_job(id);
  say("p", heartbeat);
  say("p", hello(1, 2));
  EXPECT_EQ(heard(v1::Envelope::kReject).size(), 4u);
  EXPECT_EQ(heard(v1::Envelope::kAssign).size(), assigns);
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
