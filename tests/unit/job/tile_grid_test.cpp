#include "job/tile_grid.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <set>

#include "base/error.h"

namespace tessera {
namespace {

RC_GTEST_PROP(TileGrid, CoversEveryPixelOfTheCropOnce, ()) {
  const int x0 = *rc::gen::inRange(0, 50), y0 = *rc::gen::inRange(0, 50);
  const PixelRect crop{x0, y0, x0 + *rc::gen::inRange(1, 60), y0 + *rc::gen::inRange(1, 60)};
  const int size = *rc::gen::inRange(1, 130);
  std::multiset<std::pair<int, int>> pixels;
  for (const PixelRect& tile : cut_tiles(crop, size)) {
    RC_ASSERT(!tile.empty());
    RC_ASSERT(crop.contains(tile));
    // No line of the frame's grid runs through it.
    RC_ASSERT(tile.x0 / size == (tile.x1 - 1) / size);
    RC_ASSERT(tile.y0 / size == (tile.y1 - 1) / size);
    for (int y = tile.y0; y < tile.y1; ++y) {
      for (int x = tile.x0; x < tile.x1; ++x) pixels.emplace(x, y);
    }
  }
  RC_ASSERT(pixels.size() == static_cast<size_t>(crop.area()));
  RC_ASSERT(std::set(pixels.begin(), pixels.end()).size() == pixels.size());
}

TEST(TileGrid, IsInMortonOrder) {
  const auto tiles = cut_tiles({0, 0, 32, 32}, 8);
  ASSERT_EQ(tiles.size(), 16u);
  EXPECT_EQ(tiles[0], (PixelRect{0, 0, 8, 8}));
  EXPECT_EQ(tiles[1], (PixelRect{8, 0, 16, 8}));
  EXPECT_EQ(tiles[2], (PixelRect{0, 8, 8, 16}));
  EXPECT_EQ(tiles[15], (PixelRect{24, 24, 32, 32}));
}

TEST(TileGrid, TakesAnyLegalSize) {
  EXPECT_EQ(cut_tiles({0, 0, 640, 480}, 2147483647).size(), 1u);
  EXPECT_THROW(cut_tiles({0, 0, 640, 480}, 0), Error);
  EXPECT_THROW(cut_tiles({0, 0, 640, 480}, -5), Error);
  EXPECT_THROW(cut_tiles({0, 0, 16384, 16384}, 1), Error);
}

TEST(TileGrid, ChoosesManyTilesForEachWorker) {
  EXPECT_EQ(choose_tile_size({0, 0, 1920, 1080}, 4), 64);
  EXPECT_EQ(choose_tile_size({0, 0, 64, 64}, 4), 16);
  EXPECT_EQ(choose_tile_size({0, 0, 65536, 4096}, 1000), 48);
}

}  // namespace
}  // namespace tessera
