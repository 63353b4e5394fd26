#include "scenes/import/mip_levels.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <span>

#include "renderer/math/encodings.h"

namespace tessera {
namespace {

DecodedTexture texture(uint32_t width, uint32_t height, uint32_t channels,
                       std::initializer_list<int> values) {
  DecodedTexture out{
      .width = width, .height = height, .channels = channels, .bits = 8, .texels = {}};
  std::vector<std::byte> texels;
  for (const int value : values) texels.push_back(static_cast<std::byte>(value));
  out.texels = make_blob(std::move(texels));
  return out;
}

int code(const DecodedTexture& t, size_t i) { return static_cast<int>(t.texels->data()[i]); }

TEST(MipLevels, halve_and_round_up_to_one) {
  DecodedTexture t = texture(5, 2, 1, {0, 20, 40, 60, 80, 0, 20, 40, 60, 80});
  EXPECT_EQ(add_mip_levels(t, false), 4u);  // 5x2, 3x1, 2x1, 1x1
  ASSERT_EQ(t.texels->size(), 10u + 3 + 2 + 1);
  // Five texels are three of 5/3 each, and three are two of 3/2 each.
  EXPECT_EQ(code(t, 10), 8);
  EXPECT_EQ(code(t, 11), 40);
  EXPECT_EQ(code(t, 12), 72);
  EXPECT_EQ(code(t, 13), 19);
  EXPECT_EQ(code(t, 14), 61);
  EXPECT_EQ(code(t, 15), 40);
  DecodedTexture one = texture(1, 1, 3, {1, 2, 3});
  EXPECT_EQ(add_mip_levels(one, true), 1u);
  EXPECT_EQ(one.texels->size(), 3u);
}

TEST(MipLevels, each_texel_counts_alike_whatever_the_size) {
  for (const uint32_t size : {1u, 3u, 7u, 33u, 65u, 100u}) {
    for (uint32_t white = 0; white < size; ++white) {
      DecodedTexture t{.width = size, .height = 1, .channels = 1, .bits = 32, .texels = {}};
      std::vector<std::byte> texels(size * sizeof(float));
      const float one = 1;
      std::memcpy(&texels[white * sizeof one], &one, sizeof one);
      t.texels = make_blob(std::move(texels));
      add_mip_levels(t, false);
      float mean;
      std::memcpy(&mean, t.texels->data() + t.texels->size() - sizeof mean, sizeof mean);
      EXPECT_NEAR(mean, 1.f / static_cast<float>(size), 1e-6f) << white << " of " << size;
    }
  }
}

TEST(MipLevels, take_means_of_light) {
  DecodedTexture t = texture(2, 1, 1, {0, 255});
  add_mip_levels(t, true);
  EXPECT_EQ(code(t, 2), 188);  // half the light
  DecodedTexture same = texture(2, 2, 1, {77, 77, 77, 77});
  add_mip_levels(same, true);
  EXPECT_EQ(code(same, 4), 77);
}

TEST(MipLevels, every_code_is_its_own_mean) {
  for (int i = 0; i < 256; ++i) {
    DecodedTexture t = texture(2, 2, 1, {i, i, i, i});
    add_mip_levels(t, true);
    ASSERT_EQ(code(t, 4), i);
  }
}

TEST(MipLevels, take_the_nearest_code_of_any_mean) {
  std::array<float, 256> from{};
  for (int i = 1; i < 256; ++i) from[i] = static_cast<float>(srgb_to_linear((i - 0.5) / 255));
  for (int i = 0; i < 20000; ++i) {
    const auto part = [&](int k) { return i * (k + 7) * 2654435761u >> 24; };
    const int a = static_cast<int>(part(0)), b = static_cast<int>(part(1)) / (1 + i % 7);
    DecodedTexture t = texture(2, 1, 1, {a, b});
    add_mip_levels(t, true);
    const auto light = [](int c) { return static_cast<float>(srgb_to_linear(c / 255.0)); };
    const float mean = 0.5f * light(a) + 0.5f * light(b);
    int nearest = 255;
    while (nearest > 0 && from[static_cast<size_t>(nearest)] > mean) --nearest;
    ASSERT_EQ(code(t, 2), nearest) << a << " " << b;
  }
}

TEST(MipLevels, what_is_clear_has_no_colour) {
  DecodedTexture t = texture(2, 1, 4, {200, 100, 50, 255, 0, 0, 0, 0});
  add_mip_levels(t, false);
  EXPECT_EQ(code(t, 8), 200);
  EXPECT_EQ(code(t, 9), 100);
  EXPECT_EQ(code(t, 11), 128);
  DecodedTexture clear = texture(2, 1, 2, {200, 0, 100, 0});
  add_mip_levels(clear, false);
  EXPECT_EQ(code(clear, 4), 150);
  EXPECT_EQ(code(clear, 5), 0);
}

TEST(MipLevels, keep_halves_and_floats) {
  const std::array<uint16_t, 2> pair{0x3e00, 0xc200};  // 1.5 and -3
  DecodedTexture halves{.width = 2,
                        .height = 1,
                        .channels = 1,
                        .bits = 16,
                        .texels = copy_to_blob(std::as_bytes(std::span(pair)))};
  EXPECT_EQ(add_mip_levels(halves, true), 2u);
  uint16_t mean;
  std::memcpy(&mean, halves.texels->data() + 4, 2);
  EXPECT_EQ(mean, 0xba00);  // -.75
  const std::array<float, 2> values{1000, 1};
  DecodedTexture floats{.width = 1,
                        .height = 2,
                        .channels = 1,
                        .bits = 32,
                        .texels = copy_to_blob(std::as_bytes(std::span(values)))};
  add_mip_levels(floats, false);
  float middle;
  std::memcpy(&middle, floats.texels->data() + 8, 4);
  EXPECT_EQ(middle, 500.5f);
}

}  // namespace
}  // namespace tessera
