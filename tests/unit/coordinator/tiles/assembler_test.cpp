#include "coordinator/tiles/assembler.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <numeric>

#include "proto/wire/pixels.h"

namespace tessera {
namespace {

const std::vector<PixelRect> kTiles = {{10, 20, 14, 23}, {14, 20, 17, 23}};
const PixelRect kCrop{10, 20, 17, 23};

/// The rows of tile 0 as messages of one row each.
std::vector<v1::TileBand> rows_of_first_tile(float offset = 0) {
  std::vector<float> values(4 * 3 * 3);
  std::iota(values.begin(), values.end(), offset);
  std::vector<v1::TileBand> bands;
  for (int row = 0; row < 3; ++row) {
    const auto part = std::span(values).subspan(static_cast<size_t>(row) * 12, 12);
    v1::TileBand band = encode_bands(part, 4, 20 + row, false)[0];
    band.set_lease(uint64_t{7} << 32);
    band.set_last(row == 2);
    if (row == 2) (*band.mutable_counters()->mutable_values())["rays_primary"] = 12;
    bands.push_back(band);
  }
  return bands;
}

TEST(Assembler, CompletesATileWithItsLastMissingRow) {
  for (const std::array<size_t, 3> order : {std::array<size_t, 3>{0, 1, 2}, {2, 1, 0}, {1, 2, 0}}) {
    Assembler assembler(kCrop, kTiles);
    const auto bands = rows_of_first_tile();
    for (int i = 0; i < 3; ++i) {
      const BandResult result = assembler.add(bands[order[static_cast<size_t>(i)]], 1);
      EXPECT_TRUE(result.valid);
      EXPECT_EQ(result.completed_tile, i == 2);
    }
    EXPECT_EQ(assembler.tiles_done(), 1u);
    EXPECT_EQ(assembler.counters().at("rays_primary"), 12u);
    const auto values = assembler.film().values();
    EXPECT_EQ(values[0], 0);
    EXPECT_EQ(values[11], 11);
    EXPECT_EQ(values[12], 0);      // of the other tile
    EXPECT_EQ(values[7 * 3], 12);  // the second row
  }
}

TEST(Assembler, CountsACompleteTileOnce) {
  Assembler assembler(kCrop, kTiles);
  const auto bands = rows_of_first_tile();
  for (int round = 0; round < 3; ++round) {
    for (const auto& band : bands) {
      const BandResult result = assembler.add(band, 1);
      EXPECT_FALSE(result.mismatch);
      EXPECT_EQ(result.duplicate_tile, round > 0 && band.last());
    }
  }
  EXPECT_EQ(assembler.tiles_done(), 1u);
  EXPECT_EQ(assembler.counters().at("rays_primary"), 12u);
}

TEST(Assembler, TakesNoValuesThatAreNotFinite) {
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
        -std::numeric_limits<float>::infinity()}) {
    Assembler assembler(kCrop, kTiles);
    std::vector<float> values(4 * 3, 1.0f);
    values[7] = value;
    v1::TileBand band = encode_bands(values, 4, 20, false)[0];
    band.set_lease(uint64_t{7} << 32);
    band.set_last(false);
    EXPECT_FALSE(assembler.add(band, 1).valid);
    // Nothing of it stays.
    EXPECT_FALSE(assembler.add(rows_of_first_tile()[0], 2).mismatch);
    EXPECT_EQ(assembler.film().values()[0], 0);
  }
}

TEST(Assembler, SumsOfCountersSaturate) {
  Assembler assembler(kCrop, kTiles);
  constexpr uint64_t kMost = std::numeric_limits<uint64_t>::max();
  for (uint32_t tile = 0; tile < 2; ++tile) {
    const int width = kTiles[tile].width();
    const std::vector<float> values(static_cast<size_t>(width) * 9, 1.0f);
    v1::TileBand band = encode_bands(values, width, 20, false)[0];
    band.set_tile(tile);
    band.set_lease(uint64_t{7} << 32 | tile);
    (*band.mutable_counters()->mutable_values())["rays_primary"] = kMost - 5;
    EXPECT_TRUE(assembler.add(band, 1).completed_tile);
  }
  EXPECT_EQ(assembler.counters().at("rays_primary"), kMost);
}

TEST(Assembler, MendsOneWorkersRowsWithAnothers) {
  Assembler assembler(kCrop, kTiles);
  const auto bands = rows_of_first_tile();
  assembler.add(bands[2], 1);
  assembler.add(bands[0], 2);
  EXPECT_TRUE(assembler.add(bands[1], 2).completed_tile);
}

TEST(Assembler, NamesBothWorkersWhosePixelsDiffer) {
  for (const bool complete : {false, true}) {
    Assembler assembler(kCrop, kTiles);
    const auto sound = rows_of_first_tile(), wrong = rows_of_first_tile(0.5f);
    for (size_t i = 0; i < (complete ? 3u : 2u); ++i) assembler.add(sound[i], 11);
    const BandResult result = assembler.add(wrong[1], 22);
    ASSERT_TRUE(result.mismatch);
    EXPECT_EQ(result.mismatch->tile, 0u);
    EXPECT_EQ(result.mismatch->row, 21);
    EXPECT_EQ(result.mismatch->first, 11u);
    EXPECT_EQ(result.mismatch->second, 22u);
    EXPECT_EQ(assembler.film().values()[7 * 3], 12) << "the first stays";
  }
}

TEST(Assembler, ComparesBitsAndNotNumbers) {
  Assembler assembler(kCrop, kTiles);
  std::vector<float> values(12, 0.0f);
  v1::TileBand band = encode_bands(values, 4, 20, false)[0];
  band.set_lease(uint64_t{1} << 32);
  assembler.add(band, 1);
  values[3] = -0.0f;
  v1::TileBand other = encode_bands(values, 4, 20, false)[0];
  other.set_lease(band.lease());
  EXPECT_TRUE(assembler.add(other, 2).mismatch);
}

TEST(Assembler, DropsSurplusCountersAndNeverPixels) {
  Assembler assembler(kCrop, kTiles);
  const auto bands = rows_of_first_tile();
  v1::TileBand of_other = encode_bands(std::vector<float>(3 * 3 * 3, 1.0f), 3, 20, false)[0];
  of_other.set_tile(1);
  of_other.set_lease(uint64_t{8} << 32 | 1);
  auto& junk = *of_other.mutable_counters()->mutable_values();
  for (int i = 0; i < 300; ++i) junk["x" + std::to_string(i)] = 1;
  junk[std::string(65, 'x')] = 1;
  for (const auto& band : bands) EXPECT_TRUE(assembler.add(band, 1).valid);
  EXPECT_TRUE(assembler.add(of_other, 2).completed_tile);
  EXPECT_EQ(assembler.counters().size(), 256u) << "of all tiles together";
  EXPECT_EQ(assembler.counters().at("rays_primary"), 12u);
  EXPECT_FALSE(assembler.counters().contains(std::string(65, 'x')));
  assembler.reopen(0);
  v1::TileBand last = bands[2];
  (*last.mutable_counters()->mutable_values())["one more"] = 1;
  EXPECT_TRUE(assembler.add(last, 3).valid);
  for (int i = 0; i < 2; ++i) assembler.add(bands[static_cast<size_t>(i)], 3);
  EXPECT_TRUE(assembler.complete(0));
  EXPECT_FALSE(assembler.counters().contains("one more"));
}

TEST(Assembler, TakesNoNamesOfBandsThatAreDamagedOrCameBefore) {
  Assembler assembler(kCrop, kTiles);
  const auto bands = rows_of_first_tile();
  v1::TileBand damaged = bands[2];
  (*damaged.mutable_counters()->mutable_values())["junk"] = 1;
  damaged.set_pixel_crc(damaged.pixel_crc() + 1);
  EXPECT_FALSE(assembler.add(damaged, 2).valid);
  for (const auto& band : bands) assembler.add(band, 1);
  damaged.set_pixel_crc(bands[2].pixel_crc());
  EXPECT_TRUE(assembler.add(damaged, 2).duplicate_tile);
  EXPECT_EQ(assembler.counters().size(), 1u);
}

TEST(Assembler, CountsAReopenedTileAnew) {
  Assembler assembler(kCrop, kTiles);
  for (const auto& band : rows_of_first_tile()) assembler.add(band, 1);
  assembler.reopen(0);
  EXPECT_FALSE(assembler.complete(0));
  EXPECT_EQ(assembler.tiles_done(), 0u);
  EXPECT_EQ(assembler.counters().at("rays_primary"), 0u);
  for (const auto& band : rows_of_first_tile(0.5f)) EXPECT_FALSE(assembler.add(band, 2).mismatch);
  EXPECT_EQ(assembler.tiles_done(), 1u);
  EXPECT_EQ(assembler.counters().at("rays_primary"), 12u);
  EXPECT_EQ(assembler.film().values()[7 * 3], 12.5f);
}

TEST(Assembler, RefusesWhatDoesNotFit) {
  Assembler assembler(kCrop, kTiles);
  const v1::TileBand sound = rows_of_first_tile()[1];
  const auto refused = [&](auto change) {
    v1::TileBand band = sound;
    change(band);
    return !assembler.add(band, 1).valid;
  };
  EXPECT_TRUE(refused([](auto& band) { band.set_tile(1); }));
  EXPECT_TRUE(refused([](auto& band) { band.set_tile(2), band.set_lease(2); }));
  EXPECT_TRUE(refused([](auto& band) { band.set_tile(0xffffffff), band.set_lease(~uint64_t{0}); }));
  EXPECT_TRUE(refused([](auto& band) { band.set_first_row(19); }));
  EXPECT_TRUE(refused([](auto& band) { band.set_first_row(23); }));
  EXPECT_TRUE(refused([](auto& band) { band.set_first_row(-2147483648); }));
  EXPECT_TRUE(refused([](auto& band) { band.set_rows(3); }));
  EXPECT_TRUE(refused([](auto& band) { band.set_rows(0); }));
  EXPECT_TRUE(refused([](auto& band) { band.set_rows(-1); }));
  EXPECT_TRUE(refused([](auto& band) { band.set_rows(2147483647); }));
  EXPECT_TRUE(refused([](auto& band) { band.set_rows(2); }));
  EXPECT_TRUE(refused([](auto& band) { band.set_pixel_crc(band.pixel_crc() ^ 1); }));
  EXPECT_TRUE(refused([](auto& band) { band.mutable_pixels()->push_back('x'); }));
  EXPECT_EQ(assembler.film().values()[7 * 3], 0) << "nothing was written";
  EXPECT_FALSE(refused([](auto&) {}));
}

/// The same bands under leases of three parts of one row each.
std::vector<v1::TileBand> parts_of_first_tile() {
  auto bands = rows_of_first_tile();
  for (uint32_t part = 0; part < 3; ++part) {
    v1::TileBand& band = bands[part];
    band.set_lease(uint64_t{20 + part} << 32 | TilePiece{0, part, 3}.packed());
    band.set_last(true);
    auto& counters = *band.mutable_counters()->mutable_values();
    counters["rays_primary"] = 4;
    counters["tiles_background"] = part == 0 ? 0 : 1;
  }
  return bands;
}

TEST(Assembler, PartsMakeTheTileInAnyOrder) {
  for (const std::array<size_t, 3> order : {std::array<size_t, 3>{0, 1, 2}, {2, 0, 1}}) {
    Assembler assembler(kCrop, kTiles);
    const auto parts = parts_of_first_tile();
    for (int i = 0; i < 3; ++i) {
      const v1::TileBand& part = parts[order[static_cast<size_t>(i)]];
      EXPECT_FALSE(assembler.has_piece(part.lease()));
      EXPECT_EQ(assembler.add(part, 1 + static_cast<WorkerId>(i)).completed_tile, i == 2);
      EXPECT_TRUE(assembler.has_piece(part.lease()));
    }
    EXPECT_EQ(assembler.counters().at("rays_primary"), 12u);
    EXPECT_EQ(assembler.counters().at("tiles_background"), 0u) << "not all of it is";
    EXPECT_EQ(assembler.film().values()[7 * 3], 12);
  }
}

TEST(Assembler, AWholeTileAndItsPartsRace) {
  Assembler assembler(kCrop, kTiles);
  const auto parts = parts_of_first_tile();
  const auto whole = rows_of_first_tile();
  assembler.add(parts[1], 2);
  assembler.add(whole[0], 1);
  assembler.add(whole[1], 1);  // compared with the part
  EXPECT_TRUE(assembler.add(whole[2], 1).completed_tile);
  EXPECT_EQ(assembler.counters().at("rays_primary"), 12u) << "counted once";
  EXPECT_TRUE(assembler.add(parts[0], 2).duplicate_tile);
  const auto other = rows_of_first_tile(1);
  v1::TileBand wrong = parts[2];
  wrong.set_pixels(other[2].pixels());
  wrong.set_pixel_crc(other[2].pixel_crc());
  const auto mismatch = assembler.add(wrong, 3).mismatch;
  ASSERT_TRUE(mismatch);
  EXPECT_EQ(mismatch->row, 22);
  EXPECT_EQ(mismatch->first, 1u);
}

TEST(Assembler, AllRowsWithoutAllCountersAreNoTile) {
  Assembler assembler(kCrop, kTiles);
  const auto parts = parts_of_first_tile();
  const auto whole = rows_of_first_tile();
  assembler.add(whole[0], 1);
  assembler.add(whole[1], 1);
  EXPECT_FALSE(assembler.add(parts[2], 2).completed_tile) << "a third of its counters is there";
  EXPECT_TRUE(assembler.add(whole[2], 1).completed_tile);
  EXPECT_EQ(assembler.counters().at("rays_primary"), 12u);
}

TEST(Assembler, LooksForPartsThatMakeATileOnceARow) {
  // Ways through the rows, of which none reaches the end, are more than anybody can go.
  constexpr PixelRect kTile{0, 0, 1, 64};
  Assembler assembler(kTile, {kTile});
  const auto add = [&](uint32_t part, uint32_t parts, bool last) {
    const TilePiece piece{0, part, parts};
    const PixelRect rows = piece.rect(kTile);
    const std::vector<float> values(static_cast<size_t>(rows.height()) * 3, 1.0f);
    v1::TileBand band = encode_bands(values, 1, rows.y0, false)[0];
    band.set_lease(piece.packed());
    band.set_last(last);
    if (last) (*band.mutable_counters()->mutable_values())["samples"] = 64 / parts;
    return assembler.add(band, 1).completed_tile;
  };
  for (const uint32_t parts : {2u, 4u, 8u, 16u, 32u, 64u}) {
    for (uint32_t part = 0; part + 1 < parts; ++part) EXPECT_FALSE(add(part, parts, true));
  }
  EXPECT_FALSE(add(63, 64, false)) << "of that part the counters are missing";
  EXPECT_TRUE(add(63, 64, true));
  EXPECT_EQ(assembler.counters().at("samples"), 64u);
}

TEST(Assembler, AWholeTilesRowsDoNotCountForPartsOfIt) {
  Assembler assembler(kCrop, kTiles);
  const auto parts = parts_of_first_tile();
  v1::TileBand outside = parts[0];
  outside.set_lease(parts[1].lease());
  EXPECT_FALSE(assembler.add(outside, 1).valid) << "a row that the part does not have";
  v1::TileBand none = parts[0];
  none.set_lease(uint64_t{9} << 32 | TilePiece{0, 3, 3}.packed());
  EXPECT_FALSE(assembler.add(none, 1).valid) << "the fourth of three";
  none.set_lease(uint64_t{9} << 32 | TilePiece{0, 0, 4}.packed());
  EXPECT_FALSE(assembler.add(none, 1).valid) << "four parts of three rows";
}

TEST(Assembler, FillsWhatNobodyHasTraced) {
  Assembler assembler(kCrop, kTiles);
  v1::Counters of_pixel;
  (*of_pixel.mutable_values())["samples"] = 2;
  (*of_pixel.mutable_values())["tiles_background"] = 1;
  const std::array<float, 3> value{0.25f, 0.5f, 1};
  assembler.add(rows_of_first_tile()[0], 1);
  EXPECT_FALSE(assembler.fill(0, value, of_pixel, 1)) << "some of it is there";
  EXPECT_TRUE(assembler.fill(1, value, of_pixel, 1));
  EXPECT_FALSE(assembler.fill(1, value, of_pixel, 2));
  EXPECT_EQ(assembler.done_by(1), 1u);
  EXPECT_EQ(assembler.counters().at("samples"), 18u);
  EXPECT_EQ(assembler.counters().at("tiles_background"), 1u);
  EXPECT_EQ(assembler.film().values()[4 * 3 + 1], 0.5f);
  const auto bands = assembler.bands_of(1);
  Assembler other(kCrop, kTiles);
  EXPECT_TRUE(other.add(bands[0], 2).completed_tile) << "kept like any other";
}

}  // namespace
}  // namespace tessera
