#include "coordinator/tiles/tile_verifier.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tessera {
namespace {

TEST(TileVerifier, SelectsItsShareByAKeyThatNobodyKnows) {
  constexpr uint32_t kTiles = 20000;
  const auto count = [](double share, uint64_t key) {
    const TileVerifier verifier(kTiles, share, key);
    uint32_t selected = 0;
    for (uint32_t tile = 0; tile < kTiles; ++tile) selected += verifier.selects(tile) ? 1 : 0;
    return selected;
  };
  EXPECT_EQ(count(0, 1), 0u);
  EXPECT_EQ(count(1, 1), kTiles);
  EXPECT_NEAR(count(0.1, 1), 2000, 5 * std::sqrt(2000 * 0.9));
  EXPECT_NEAR(count(0.01, 2), 200, 5 * std::sqrt(200));
  // Another key selects others, the same one the same.
  const TileVerifier one(kTiles, 0.5, 1), again(kTiles, 0.5, 1), other(kTiles, 0.5, 2);
  uint32_t same = 0;
  for (uint32_t tile = 0; tile < kTiles; ++tile) {
    EXPECT_EQ(one.selects(tile), again.selects(tile));
    same += one.selects(tile) == other.selects(tile) ? 1 : 0;
  }
  EXPECT_NEAR(same, kTiles / 2, 5 * std::sqrt(kTiles / 4));
}

TEST(TileVerifier, WhoseTilesAreWrongIsFoundOutAtTheRateThatIsPromised) {
  constexpr int kTrials = 4000;
  for (const auto& [share, wrong] : {std::pair{0.01, 50}, {0.01, 200}, {0.1, 10}, {0.5, 3}}) {
    int caught = 0;
    std::mt19937_64 random(7);
    for (int trial = 0; trial < kTrials; ++trial) {
      const TileVerifier verifier(1000, share, random());
      bool found = false;
      for (int i = 0; i < wrong; ++i)
        found |= verifier.selects(static_cast<uint32_t>(random() % 1000));
      caught += found ? 1 : 0;
    }
    const double expected = 1 - std::pow(1 - share, wrong);
    const double deviation = std::sqrt(kTrials * expected * (1 - expected));
    // The same tile may have been drawn twice.
    EXPECT_NEAR(caught, kTrials * expected, 5 * deviation + kTrials * 0.02)
        << share << " " << wrong;
  }
}

TEST(TileVerifier, ATileIsTheSameOnceAllItsRowsCameFromOneOther) {
  TileVerifier verifier(2, 1, 3);
  const PixelRect rect{0, 10, 8, 16};
  verifier.note_rows(1, 5);
  verifier.note_rows(1, 5);
  EXPECT_THAT(verifier.traced_by(1), ::testing::ElementsAre(5));
  EXPECT_THAT(verifier.tiles_of(5), ::testing::ElementsAre(1));
  EXPECT_FALSE(verifier.note_same_rows(1, 5, rect, 10, 6)) << "its own again";
  EXPECT_FALSE(verifier.note_same_rows(1, 6, rect, 13, 3));
  EXPECT_FALSE(verifier.note_same_rows(1, 7, rect, 10, 3));
  EXPECT_TRUE(verifier.note_same_rows(1, 6, rect, 10, 3));
  verifier.forget(1);
  EXPECT_FALSE(verifier.note_same_rows(1, 7, rect, 13, 3)) << "what came before counts no more";
  EXPECT_TRUE(verifier.tiles_of(5).empty());
}

TEST(TileVerifier, AThirdJudges) {
  const Mismatch dispute{.tile = 4,
                         .row = 2,
                         .first = 11,
                         .second = 22,
                         .first_pixels = {1, 2},
                         .second_pixels = {1, 3}};
  EXPECT_EQ(TileVerifier::judge(dispute, std::vector<float>{1, 2}), 22u);
  EXPECT_EQ(TileVerifier::judge(dispute, std::vector<float>{1, 3}), 11u);
  EXPECT_FALSE(TileVerifier::judge(dispute, std::vector<float>{1, 4}));
  // Bits count: 0 and -0 are two things.
  const Mismatch zeros{.first = 1, .second = 2, .first_pixels = {0.0f}, .second_pixels = {-0.0f}};
  EXPECT_EQ(TileVerifier::judge(zeros, std::vector<float>{-0.0f}), 1u);
}

}  // namespace
}  // namespace tessera
