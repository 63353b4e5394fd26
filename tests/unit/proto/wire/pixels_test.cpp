#include "proto/wire/pixels.h"

#include <gtest/gtest.h>
#include <zstd.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "proto/wire/crc32c.h"

namespace tessera {
namespace {

std::vector<float> gradient(size_t count) {
  std::vector<float> values(count);
  for (size_t i = 0; i < count; ++i) values[i] = static_cast<float>(i) * 0.001f;
  return values;
}

bool same_bits(std::span<const float> a, std::span<const float> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

TEST(Bands, BringEveryBitBack) {
  auto values = gradient(30 * 20 * 3);
  values[5] = std::numeric_limits<float>::infinity();
  values[6] = -0.0f;
  values[7] = std::nanf("12");
  values[8] = std::numeric_limits<float>::denorm_min();
  for (const bool compress : {false, true}) {
    const auto bands = encode_bands(values, 30, 100, compress);
    ASSERT_EQ(bands.size(), 1u);
    EXPECT_EQ(bands[0].first_row(), 100);
    EXPECT_EQ(bands[0].rows(), 20);
    EXPECT_TRUE(bands[0].last());
    std::vector<float> decoded;
    ASSERT_TRUE(decode_band(bands[0], 30, decoded));
    EXPECT_TRUE(same_bits(decoded, values));
  }
}

TEST(Bands, CompressWhatShrinksAndOnlyThat) {
  const std::vector<float> flat(3000, 0.5f);
  const auto small = encode_bands(flat, 10, 0, true);
  EXPECT_EQ(small[0].encoding(), v1::TileBand::SHUFFLED_ZSTD);
  EXPECT_LT(small[0].pixels().size(), 500u);
  const std::vector<float> one(3, 0.5f);
  EXPECT_EQ(encode_bands(one, 1, 0, true)[0].encoding(), v1::TileBand::RAW);
}

TEST(Bands, OfALargeTileAreManyAndSmall) {
  const int width = 1000, height = 700;
  const auto values = gradient(size_t{width} * height * 3);
  const auto bands = encode_bands(values, width, 5, false);
  EXPECT_GT(bands.size(), 7u);
  int row = 5;
  std::vector<float> all;
  for (size_t i = 0; i < bands.size(); ++i) {
    EXPECT_EQ(bands[i].first_row(), row);
    EXPECT_EQ(bands[i].last(), i + 1 == bands.size());
    EXPECT_LE(bands[i].pixels().size(), kBandBytes);
    std::vector<float> part;
    ASSERT_TRUE(decode_band(bands[i], width, part));
    all.insert(all.end(), part.begin(), part.end());
    row += bands[i].rows();
  }
  EXPECT_EQ(row, 5 + height);
  EXPECT_TRUE(same_bits(all, values));
}

TEST(Bands, OfTheLongestRowStillFitAFrame) {
  const auto bands = encode_bands(gradient(size_t{65536} * 2 * 3), 65536, 0, false);
  EXPECT_EQ(bands.size(), 2u);
}

TEST(Bands, ThatAreDamagedAreRefused) {
  const auto values = gradient(300);
  std::vector<float> decoded;
  for (const bool compress : {false, true}) {
    const v1::TileBand sound = encode_bands(values, 10, 0, compress)[0];
    ASSERT_EQ(sound.encoding() == v1::TileBand::SHUFFLED_ZSTD, compress);
    for (size_t i = 0; i < sound.pixels().size(); ++i) {
      v1::TileBand damaged = sound;
      (*damaged.mutable_pixels())[i] ^= 0x10;
      // Some bits of a zstd frame mean nothing; then the pixels must be right.
      if (decode_band(damaged, 10, decoded)) {
        EXPECT_TRUE(compress && same_bits(decoded, values)) << i;
      }
    }
    for (size_t length = 0; length < sound.pixels().size(); ++length) {
      v1::TileBand cut = sound;
      cut.mutable_pixels()->resize(length);
      EXPECT_FALSE(decode_band(cut, 10, decoded)) << length;
    }
  }
}

TEST(Bands, OfAnotherSizeThanExpectedAreRefused) {
  const auto values = gradient(300);
  std::vector<float> decoded;
  for (const bool compress : {false, true}) {
    const v1::TileBand sound = encode_bands(values, 10, 0, compress)[0];
    EXPECT_FALSE(decode_band(sound, 11, decoded));
    EXPECT_FALSE(decode_band(sound, 0, decoded));
    for (const int rows : {9, 11, 0, -1, 2147483647}) {
      v1::TileBand band = sound;
      band.set_rows(rows);
      EXPECT_FALSE(decode_band(band, 10, decoded)) << rows;
    }
  }
  EXPECT_EQ(decoded.capacity(), 0u);
}

TEST(Bands, OfOneByteAllocateNothing) {
  v1::TileBand band;
  band.set_rows(16384);
  band.set_pixels("x");
  std::vector<float> decoded;
  for (const auto encoding : {v1::TileBand::RAW, v1::TileBand::SHUFFLED_ZSTD}) {
    band.set_encoding(encoding);
    EXPECT_FALSE(decode_band(band, 16384, decoded));
    EXPECT_EQ(decoded.capacity(), 0u);
  }
}

TEST(Bands, ThatUnpackToMoreThanABandAreRefused) {
  constexpr int kRows = 1365, kWidth = 4096;  // 64 MiB
  const std::string zeros(size_t{kRows} * kWidth * 12, '\0');
  std::string bomb(ZSTD_compressBound(zeros.size()), '\0');
  bomb.resize(ZSTD_compress(bomb.data(), bomb.size(), zeros.data(), zeros.size(), 1));
  v1::TileBand band;
  band.set_encoding(v1::TileBand::SHUFFLED_ZSTD);
  band.set_pixels(bomb);
  band.set_pixel_crc(crc32c(std::as_bytes(std::span(zeros))));
  std::vector<float> decoded;
  // The rows agree with what it holds, which is too much all the same.
  band.set_rows(kRows);
  EXPECT_FALSE(decode_band(band, kWidth, decoded));
  EXPECT_EQ(decoded.capacity(), 0u);
}

TEST(Bands, OfAnUnknownEncodingAreRefused) {
  v1::TileBand band = encode_bands(gradient(30), 10, 0, false)[0];
  band.set_encoding(static_cast<v1::TileBand::Encoding>(9));
  std::vector<float> decoded;
  EXPECT_FALSE(decode_band(band, 10, decoded));
}

TEST(Bands, HaveAsManyChannelsAsIsSaid) {
  const auto values = gradient(10 * 6 * 18);
  const auto bands = encode_bands(values, 10, 0, true, 18);
  ASSERT_EQ(bands.size(), 1u);
  EXPECT_EQ(bands[0].rows(), 6);
  std::vector<float> decoded;
  ASSERT_TRUE(decode_band(bands[0], 10, decoded, 18));
  EXPECT_TRUE(same_bits(decoded, values));
  for (const int channels : {3, 17, 19}) {
    EXPECT_FALSE(decode_band(bands[0], 10, decoded, channels)) << channels;
  }
}

}  // namespace
}  // namespace tessera
