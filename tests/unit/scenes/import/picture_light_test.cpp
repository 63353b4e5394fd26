#include "scenes/import/picture_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "renderer/math/encodings.h"
#include "scenes/import/mip_levels.h"
#include "scenes/import/picture_channel.h"

namespace tessera {
namespace {

template <typename Number>
DecodedTexture texture(uint32_t width, uint32_t channels, const std::vector<Number>& numbers) {
  std::vector<std::byte> bytes(numbers.size() * sizeof(Number));
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  const auto texels = static_cast<uint32_t>(numbers.size()) / channels;
  return {.width = width,
          .height = texels / width,
          .channels = channels,
          .bits = 8 * sizeof(Number),
          .texels = make_blob(std::move(bytes))};
}

template <typename Number = float>
std::vector<Number> numbers(const DecodedTexture& texture) {
  std::vector<Number> out(texture.texels->size() / sizeof(Number));
  std::memcpy(out.data(), texture.texels->data(), texture.texels->size());
  return out;
}

TEST(PictureLight, codes_of_8_bits_stay_and_all_others_become_light) {
  DecodedTexture bytes = texture<uint8_t>(1, 3, {188, 128, 64});
  decode_picture(bytes, SampleEncoding::automatic);
  EXPECT_EQ(bytes.bits, 8u);
  DecodedTexture wide = texture<float>(1, 1, {.5f});
  wide.meaning.from_integers = true;
  decode_picture(wide, SampleEncoding::automatic);
  EXPECT_EQ(numbers(wide), std::vector{static_cast<float>(srgb_to_linear(.5))});
  decode_picture(wide, SampleEncoding::automatic);
  EXPECT_EQ(numbers(wide), std::vector{static_cast<float>(srgb_to_linear(.5))}) << "once alone";
  DecodedTexture half = texture<uint16_t>(1, 1, {float_to_half(.5f)});
  decode_picture(half, SampleEncoding::automatic);
  EXPECT_EQ(half.bits, 16u);
  decode_picture(half, SampleEncoding::srgb);
  EXPECT_EQ(half.bits, 32u);
  EXPECT_EQ(numbers(half), std::vector{static_cast<float>(srgb_to_linear(.5))});
}

TEST(PictureLight, levels_of_associated_alpha_are_plain_means) {
  DecodedTexture picture = texture<float>(2, 2, {1, 1, 0, 0});
  picture.meaning.is_associated = true;
  EXPECT_EQ(add_mip_levels(picture, false), 2u);
  EXPECT_EQ(numbers(picture), (std::vector<float>{1, 1, 0, 0, .5f, .5f}));
}

TEST(PictureLight, a_channel_of_associated_alpha_is_divided_by_it) {
  DecodedTexture picture = texture<float>(2, 2, {.25f, .5f, 0, 0});
  picture.meaning.is_associated = true;
  keep_channel(picture, PictureChannel::luminance, false);
  EXPECT_EQ(numbers(picture), (std::vector<float>{.5f, 0}));
  EXPECT_FALSE(picture.meaning.is_associated);
}

TEST(PictureLight, alpha_kept_of_codes_is_linear) {
  DecodedTexture picture = texture<uint8_t>(1, 4, {9, 9, 9, 128});
  keep_channel(picture, PictureChannel::alpha_or_luminance, true);
  EXPECT_EQ(picture.bits, 16u) << "as codes of 8 bits would be decoded";
  EXPECT_EQ(numbers<uint16_t>(picture), std::vector{float_to_half(128 / 255.f)});
}

TEST(PictureLight, light_too_large_for_floats_is_mended) {
  DecodedTexture picture = texture<float>(1, 2, {1e20f, 1});
  const std::vector<PictureNote> notes = prepare_picture(picture, SampleEncoding::srgb);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0].what,
            "pixel 0,0 has the number inf and is read as 65504; expected finite numbers");
  EXPECT_TRUE(notes[0].is_repair);
  EXPECT_EQ(numbers(picture), (std::vector<float>{65504, 1}));
}

TEST(PictureLight, what_is_wrong_with_a_file_is_told) {
  DecodedTexture picture = texture<float>(1, 1, {1});
  picture.damage = "Premature end of JPEG file";
  picture.part_note = "another part";
  const std::vector<PictureNote> notes = prepare_picture(picture, SampleEncoding::linear);
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_FALSE(notes[0].is_repair) << notes[0].what;
  EXPECT_EQ(notes[1].what, "it is damaged, and read as far as it goes: Premature end of JPEG file");
  EXPECT_TRUE(notes[1].is_repair);
}

TEST(PictureLight, numbers_that_are_not_finite_are_mended_with_their_place) {
  constexpr float kEndless = std::numeric_limits<float>::infinity();
  DecodedTexture picture =
      texture<float>(2, 3, {1, 2, 3, 4, 5, 6, 7, kEndless, 9, 1, NAN, -kEndless});
  EXPECT_EQ(
      mend_numbers(picture),
      "pixel 0,1 has the number inf and is read as 65504, like 2 more numbers; expected finite "
      "numbers");
  EXPECT_EQ(numbers(picture), (std::vector<float>{1, 2, 3, 4, 5, 6, 7, 65504, 9, 1, 0, 0}));
  EXPECT_EQ(mend_numbers(picture), "");
  DecodedTexture half = texture<uint16_t>(3, 1, {0x3c00, 0x7bff, 0x7e01});
  EXPECT_EQ(mend_numbers(half),
            "pixel 2,0 has the number nan and is read as 0; expected finite numbers");
  EXPECT_EQ(numbers<uint16_t>(half), (std::vector<uint16_t>{0x3c00, 0x7bff, 0}));
}

}  // namespace
}  // namespace tessera
