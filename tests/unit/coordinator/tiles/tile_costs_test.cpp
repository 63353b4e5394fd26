#include "coordinator/tiles/tile_costs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "job/tile_grid.h"

namespace tessera {
namespace {

using ::testing::ElementsAre;

class TileCostsTest : public ::testing::Test {
 protected:
  static constexpr int kSide = 16, kTile = 8;
  const std::vector<PixelRect> tiles = cut_tiles({0, 0, kSide* kTile, kSide* kTile}, kTile);
  TileCosts costs{tiles, kTile};

  std::deque<uint32_t> order(TileCosts& by) const {
    std::deque<uint32_t> result(tiles.size());
    std::iota(result.begin(), result.end(), 0u);
    by.put_in_order(result);
    return result;
  }
  /// The right half takes ten times as long.
  double seconds(uint32_t tile) const { return tiles[tile].x0 >= kSide * kTile / 2 ? 0.1 : 0.01; }
};

TEST_F(TileCostsTest, WhereNothingIsKnownOneOfSixteenIsFirst) {
  const auto first = order(costs);
  for (int i = 0; i < 16; ++i) {
    const PixelRect& tile = tiles[first[static_cast<size_t>(i)]];
    EXPECT_EQ(tile.x0 / kTile % 4, 1);
    EXPECT_EQ(tile.y0 / kTile % 4, 1);
  }
  EXPECT_TRUE(std::is_sorted(first.begin() + 16, first.end()));
  EXPECT_FALSE(costs.predict(0));
}

TEST_F(TileCostsTest, LearnsOfNeighboursAndPutsCostlyTilesFirst) {
  const auto first = order(costs);
  EXPECT_FALSE(costs.order_is_due());
  for (size_t i = 0; i < 16; ++i) costs.note(first[i], seconds(first[i]));
  EXPECT_TRUE(costs.order_is_due());
  const auto then = order(costs);
  int right = 0;
  for (size_t i = 0; i < tiles.size() / 2; ++i) right += tiles[then[i]].x0 >= kSide * kTile / 2;
  // But for a column at the border, which neighbours of both kinds tell of.
  EXPECT_GE(right, static_cast<int>(tiles.size() / 2) - kSide);
  EXPECT_FALSE(costs.order_is_due());
}

TEST_F(TileCostsTest, AnEarlierFrameTellsOfEachTile) {
  for (uint32_t tile = 0; tile < tiles.size(); ++tile) costs.note(tile, seconds(tile));
  TileCosts next(tiles, kTile);
  next.learn_from(costs);
  EXPECT_TRUE(next.order_is_due());
  const auto first = order(next);
  for (size_t i = 0; i < tiles.size() / 2; ++i) {
    EXPECT_GE(tiles[first[i]].x0, kSide * kTile / 2) << i;
  }
  EXPECT_NEAR(*next.predict(0), 0.01, 1e-6);
  // One of another grid does not.
  TileCosts other(cut_tiles({0, 0, 100, 100}, kTile), kTile);
  other.learn_from(costs);
  EXPECT_FALSE(other.predict(0));
  // Nor does one of which nothing is known.
  TileCosts after_nothing(tiles, kTile);
  after_nothing.learn_from(TileCosts(tiles, kTile));
  EXPECT_FALSE(after_nothing.predict(0));
}

TEST_F(TileCostsTest, WhatIsKnownOfAFrameThatWasPutAsideTellsOfItsOtherTilesToo) {
  const auto first = order(costs);
  for (size_t i = 0; i < 16; ++i) costs.note(first[i], seconds(first[i]));
  TileCosts again(tiles, kTile);
  again.learn_from(costs);
  double foreseen = 0, right = 0;
  for (uint32_t tile = 0; tile < tiles.size(); ++tile) {
    EXPECT_EQ(again.predict(tile), costs.predict(tile)) << tile;
    foreseen += *again.predict(tile);
    right += seconds(tile);
  }
  EXPECT_NEAR(foreseen, right, .1 * right);
  // What it takes this time counts in place of that.
  again.note(first[0], 2 * seconds(first[0]));
  costs.note(first[0], 2 * seconds(first[0]));
  for (uint32_t tile = 0; tile < tiles.size(); ++tile) {
    EXPECT_NEAR(*again.predict(tile), *costs.predict(tile), 1e-6) << tile;
  }
}

TEST_F(TileCostsTest, TakesNoNonsense) {
  costs.note(0, std::numeric_limits<double>::quiet_NaN());
  costs.note(0, -1);
  costs.note(0, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(costs.predict(0));
  costs.note(0, 1);
  costs.note(0, 3);
  EXPECT_EQ(costs.predict(0), 3);
  EXPECT_EQ(costs.predict(200), 3);
}

}  // namespace
}  // namespace tessera
