// Jobs whose tiles are kept.
#include <memory>
#include <tuple>

#include "coordinator/tiles/tile_store.h"
#include "tests/unit/coordinator/coordinator_fixture.h"

namespace tessera::testing {
namespace {

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
  void drop_all(const Digest& job) override {
    if (job == key) tiles.clear();
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
  uint64_t submit(JobSpec spec = job()) { return coordinator.submit(std::move(spec), {}, store); }
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
  trace(submit(), 3);
  ASSERT_EQ(store->tiles.size(), 3u);
  coordinator = Coordinator(CoordinatorOptions{});
  all.clear();
  const uint64_t id = submit();
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
  trace(submit(), 4);
  JobSpec other = job();
  other.frame.set_seed(7);
  submit(std::move(other));
  EXPECT_EQ(coordinator.progress({}).tiles_done, 0u);
}

TEST_F(StoreTest, AJobWhoseTilesAreAllKeptEndsWithoutWorkers) {
  trace(submit(), 4);
  coordinator = Coordinator(CoordinatorOptions{});
  const uint64_t id = submit();
  coordinator.on_tick({});
  const auto result = coordinator.take_result(id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.tiles_restored, 4u);
  EXPECT_EQ(result->report.end, JobReport::End::done);
}

TEST_F(StoreTest, DamagedTilesAreTracedAgain) {
  trace(submit(), 3);
  v1::TileBand& damaged = *store->tiles[1].kept.mutable_bands(0);
  damaged.set_pixel_crc(damaged.pixel_crc() + 1);
  store->tiles[2].rect.x1 += 1;
  coordinator = Coordinator(CoordinatorOptions{});
  submit();
  EXPECT_EQ(coordinator.progress({}).tiles_done, 1u);
}

TEST_F(StoreTest, WhatAFullDiskDidNotTakeIsKeptLater) {
  store->full = true;
  const uint64_t id = submit();
  trace(id, 3);
  EXPECT_TRUE(store->tiles.empty());
  store->full = false;
  const auto assigns = heard(v1::Envelope::kAssign);
  say("p", band(assigns[3].assign(), 4));
  EXPECT_EQ(store->tiles.size(), 4u);
  EXPECT_EQ(coordinator.take_result(id)->report.end, JobReport::End::done);
}

}  // namespace
}  // namespace tessera::testing
