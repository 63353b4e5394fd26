// Jobs of clients in a store: what outlives a coordinator, who comes first, and a store that is
// full.
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

TEST_F(ServiceTest, WhatAnEarlierCoordinatorGaveOutIsTaken) {
  const uint64_t id = submit(1);
  come(1, 2);
  const v1::Assign early = assigned().at(0), later = assigned().at(1);
  restart();
  coordinator.on_tick({});
  say("w1", hello(1, 2));
  say("w1", band(early, 1));
  EXPECT_EQ(ask(id).tiles_done(), 1u);
  v1::Envelope forged = band(later, 1);
  constexpr int kEpochShift = 52;
  forged.mutable_tile_band()->set_lease(epoch << kEpochShift | later.tile());
  say("w1", forged);
  EXPECT_EQ(ask(id).tiles_done(), 1u) << "this one gave no such lease";
}

TEST_F(ServiceTest, HigherPriorityComesFirst) {
  const uint64_t low = submit(1, 0, 64), high = submit(2, 5);
  come(1, 4);
  EXPECT_EQ(count_of(high), 4u);
  EXPECT_EQ(count_of(low), 0u);
  for (size_t i = 0; i < 4; ++i) say("w1", band(assigned().at(i), 1));
  get_ready("w1");
  EXPECT_EQ(count_of(low), 4u);
}

TEST_F(ServiceTest, EqualsShareByWeight) {
  const uint64_t one = submit(1, 0, 256), three = submit(2, 0, 256, 3);
  come(1, 1);
  Time now{};
  for (size_t i = 0; i < 80; ++i) {
    now += milliseconds(100);
    say("w1", band(assigned().at(i), 1), now);
    get_ready("w1", now);
  }
  EXPECT_NEAR(static_cast<double>(count_of(three)), 60, 3);
  EXPECT_NEAR(static_cast<double>(count_of(one)), 20, 3);
}

TEST_F(ServiceTest, ALaterJobDoesNotCatchUpWithWhatOthersHad) {
  const uint64_t first = submit(1, 0, 256);
  come(1, 1);
  Time now{};
  size_t given = 0;
  for (; given < 40; ++given) {
    now += milliseconds(100);
    say("w1", band(assigned().at(given), 1), now);
  }
  const uint64_t second = submit(2, 0, 256, 1, 1, now);
  coordinator.on_tick(now);
  get_ready("w1", now);
  const size_t before = assigned().size();
  for (; given < before + 39; ++given) {
    now += milliseconds(100);
    say("w1", band(assigned().at(given), 1), now);
    get_ready("w1", now);
  }
  EXPECT_NEAR(static_cast<double>(count_of(first, before)), 20, 2);
  EXPECT_NEAR(static_cast<double>(count_of(second, before)), 20, 2);
}

TEST_F(ServiceTest, APausedJobGetsNoTileAndTakesThoseThatAreOut) {
  const uint64_t id = submit(1, 0, 64);
  come(1, 2);
  EXPECT_EQ(ask(id, v1::JobQuery::PAUSE).state(), v1::JobStatus::PAUSED);
  say("w1", band(assigned().at(0), 1));
  EXPECT_EQ(ask(id).tiles_done(), 1u);
  EXPECT_EQ(assigned().size(), 2u);
  restart();
  coordinator.on_tick({});
  come(1, 2);
  EXPECT_EQ(assigned().size(), 0u) << "also after a restart";
  ask(id, v1::JobQuery::RESUME);
  coordinator.on_tick({});
  get_ready("w1");
  EXPECT_EQ(assigned().size(), 2u);
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

}  // namespace
}  // namespace tessera::testing
