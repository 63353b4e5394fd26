#include "renderer/shading/image_texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "renderer/shading/background.h"

namespace tessera {
namespace {

using Wrap = ImageTextureSettings::Wrap;
using Filter = ImageTextureSettings::Filter;

std::shared_ptr<const std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> texels;
  for (const int value : values) texels.push_back(static_cast<std::byte>(value));
  const auto owner = std::make_shared<const std::vector<std::byte>>(std::move(texels));
  return {owner, owner->data()};
}

/// Two by two grey texels: 0 51 / 102 255.
ImageTexture grey(ImageTextureSettings settings) {
  settings.width = settings.height = 2;
  settings.channels = 1;
  return {settings, bytes({0, 51, 102, 255})};
}

TEST(ImageTexture, blends_between_the_centres_of_texels) {
  const ImageTexture texture = grey({.wrap_s = Wrap::clamp, .wrap_t = Wrap::clamp});
  EXPECT_DOUBLE_EQ(texture.lookup(.25, .25).color.r, 0);
  EXPECT_DOUBLE_EQ(texture.lookup(.75, .25).color.r, .2);
  EXPECT_DOUBLE_EQ(texture.lookup(.5, .25).color.r, .1);
  EXPECT_DOUBLE_EQ(texture.lookup(.5, .5).color.r, 1.6 / 4);
  EXPECT_DOUBLE_EQ(texture.lookup(5, 5).color.r, 1);
}

TEST(ImageTexture, or_between_their_corners) {
  const ImageTexture texture = grey({.texels_at_corners = true});
  EXPECT_DOUBLE_EQ(texture.lookup(0, 0).color.r, 0);
  EXPECT_DOUBLE_EQ(texture.lookup(.5, 0).color.r, .2);
  EXPECT_DOUBLE_EQ(texture.lookup(.75, 0).color.r, .1);  // the first column follows the last
  EXPECT_DOUBLE_EQ(texture.lookup(0, 1).color.r, 0);     // and the first row the last
  EXPECT_DOUBLE_EQ(texture.lookup(.5, .75).color.r, .6);
}

TEST(ImageTexture, wraps_as_told) {
  const auto at = [](Wrap wrap, double s) {
    return grey({.wrap_s = wrap, .wrap_t = wrap, .filter = Filter::nearest}).lookup(s, .1).color.r;
  };
  EXPECT_EQ(at(Wrap::repeat, -.1), .2);
  EXPECT_EQ(at(Wrap::repeat, 3.1), 0);
  EXPECT_EQ(at(Wrap::clamp, -7), 0);
  EXPECT_EQ(at(Wrap::clamp, 7), .2);
  EXPECT_EQ(at(Wrap::mirror, 1.1), .2);
  EXPECT_EQ(at(Wrap::mirror, -.1), 0);
  EXPECT_EQ(at(Wrap::black, 1.1), 0);
  EXPECT_EQ(at(Wrap::black, .9), .2);
}

TEST(ImageTexture, far_places_are_harmless) {
  const ImageTexture texture = grey({});
  for (const double s : {1e300, -1e300, 1e18})
    EXPECT_TRUE(std::isfinite(texture.lookup(s, s).color.r));
}

TEST(ImageTexture, reads_srgb_and_floats) {
  const ImageTexture encoded({.width = 1, .height = 1, .is_srgb = true}, bytes({255, 188, 0}));
  EXPECT_EQ(encoded.lookup(0, 0).color.r, 1);
  EXPECT_NEAR(encoded.lookup(0, 0).color.g, .5, .003);
  EXPECT_EQ(encoded.lookup(0, 0).color.b, 0);
  const float values[4] = {2.5f, -1, 1e-9f, 1};
  std::vector<std::byte> raw(sizeof values);
  std::memcpy(raw.data(), values, sizeof values);
  const ImageTexture floats({.width = 1, .height = 1, .channels = 4, .bits = 32},
                            std::shared_ptr<const std::byte>(std::shared_ptr<void>(), raw.data()));
  EXPECT_EQ(floats.lookup(.3, .9).color, (Color{2.5, -1, double{1e-9f}}));
  EXPECT_EQ(floats.lookup(.3, .9).alpha, 1);
}

TEST(ImageTexture, reads_halves_and_alpha) {
  // 1.5, 2^-24, -2 and .5 as half floats.
  const ImageTexture halves({.channels = 4, .bits = 16},
                            bytes({0x00, 0x3e, 0x01, 0x00, 0x00, 0xc0, 0x00, 0x38}));
  EXPECT_EQ(halves.lookup(.5, .5).color, (Color{1.5, 0x1p-24, -2}));
  EXPECT_EQ(halves.lookup(.5, .5).alpha, .5);
  // Alpha is never encoded; where there is no picture there is nothing.
  const ImageTexture grey_alpha(
      {.channels = 2, .wrap_s = Wrap::black, .filter = Filter::nearest, .is_srgb = true},
      bytes({255, 51}));
  EXPECT_EQ(grey_alpha.lookup(.5, .5).color, kWhite);
  EXPECT_EQ(grey_alpha.lookup(.5, .5).alpha, .2);
  EXPECT_EQ(grey_alpha.lookup(1.5, .5).alpha, 0);
}

/// Four by four black, two by two of code 51, one of code 255: the level tells itself.
ImageTexture levels(Filter filter) {
  return {{.width = 4, .height = 4, .channels = 1, .levels = 3, .filter = filter},
          bytes({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 51, 51, 51, 51, 255})};
}

TEST(ImageTexture, takes_the_level_of_the_patch) {
  const auto at = [](double a, double b, Filter filter = Filter::trilinear) {
    return levels(filter).lookup(.5, .5, {a, 0}, {0, b}).color.r;
  };
  EXPECT_EQ(levels(Filter::trilinear).settings().bytes(), 21u);
  EXPECT_EQ(at(0, 0), 0);
  EXPECT_EQ(at(.25, .25), 0);
  EXPECT_NEAR(at(.5, .5), .2, 1e-12);
  EXPECT_NEAR(at(.25 * std::sqrt(2.0), .25 * std::sqrt(2.0)), .1, 1e-12);
  EXPECT_NEAR(at(1, 1), 1, 1e-12);
  EXPECT_EQ(at(1e30, 1), 1);
  // Along a narrow patch the level is that of its width.
  EXPECT_EQ(at(1, .25), 0);
  EXPECT_NEAR(at(.5, 2), .2, 1e-12);
  EXPECT_EQ(at(.5, .5, Filter::bilinear), 0);
  EXPECT_EQ(at(1, 1, Filter::nearest), 0);
}

TEST(ImageTexture, sums_along_a_long_patch) {
  // A row of eight: 0 and 255 in turns; the patch spans four of them, with one probe a texel.
  const ImageTexture row({.width = 8, .height = 1, .channels = 1, .levels = 4},
                         bytes({0, 255, 0, 255, 0, 255, 0, 255, 9, 9, 9, 9, 9, 9, 9}));
  EXPECT_NEAR(row.lookup(.5, .5, {.5, 0}, {0, 1}).color.r, .5, 1e-12);
}

TEST(ImageTexture, what_is_clear_lends_no_colour) {
  // Opaque red and clear green in turns, and the same as one level less.
  const std::initializer_list<int> texels = {255, 0,   0, 255, 0,   255, 0, 0,   255, 0, 0, 255,
                                             0,   255, 0, 0,   255, 0,   0, 128, 255, 0, 0, 128};
  const ImageTexture row({.width = 4, .height = 1, .channels = 4, .levels = 2}, bytes(texels));
  for (const double s : {.125, .2, .25, .3, .45}) {
    EXPECT_EQ(row.lookup(s, .5).color, (Color{1, 0, 0})) << s;
    EXPECT_EQ(row.lookup(s, .5, {.4, 0}, {0, .3}).color, (Color{1, 0, 0})) << s;
  }
  EXPECT_NEAR(row.lookup(.25, .5).alpha, .5, 1e-12);
  // All of it clear, it keeps its own, which materials without alpha show.
  EXPECT_EQ(row.lookup(.375, .5).color, (Color{0, 1, 0}));
}

/// Eight texels in a row, of value 0, 1 ... 7 over 255, each of one colour.
Background panorama(BackgroundKind kind, uint32_t width, uint32_t height) {
  Background background;
  background.kind = kind;
  background.picture = std::make_shared<ImageTexture>(
      ImageTextureSettings{
          .width = width, .height = height, .channels = 1, .filter = Filter::nearest},
      bytes({0, 1, 2, 3, 4, 5, 6, 7}));
  return background;
}

double seen(const Background& background, const Vec3& d) {
  return std::round(background.radiance({}, normalize(d), {}).r * 255);
}

TEST(Panorama, its_middle_lies_ahead_and_its_right_to_the_right) {
  const Background around = panorama(BackgroundKind::panorama_equirectangular, 8, 1);
  EXPECT_EQ(seen(around, {.1, 0, -1}), 4);
  EXPECT_EQ(seen(around, {-.1, 0, -1}), 3);
  EXPECT_EQ(seen(around, {1, 0, -.1}), 5);
  EXPECT_EQ(seen(around, {1, 0, .1}), 6);
  EXPECT_EQ(seen(around, {.1, 0, 1}), 7);
  EXPECT_EQ(seen(around, {-.1, 0, 1}), 0);
}

TEST(Panorama, turns_by_the_right_hand_rule) {
  Background around = panorama(BackgroundKind::panorama_equirectangular, 8, 1);
  around.angle = std::numbers::pi / 2;  // what was ahead is now to the left
  EXPECT_EQ(seen(around, {-1, 0, -.1}), 4);
  around.angle += 40 * std::numbers::pi;
  EXPECT_EQ(seen(around, {-1, 0, -.1}), 4);
}

TEST(Panorama, its_zenith_does_not_meet_its_nadir) {
  Background sky = panorama(BackgroundKind::panorama_equirectangular, 1, 8);
  sky.picture = std::make_shared<ImageTexture>(
      ImageTextureSettings{.width = 1, .height = 2, .channels = 1}, bytes({255, 0}));
  EXPECT_EQ(seen(sky, {0, 1, -1e-9}), 255);
  EXPECT_EQ(seen(sky, {0, -1, -1e-9}), 0);
  EXPECT_EQ(std::round(seen(sky, {0, 0, -1})), 128);
}

TEST(Panorama, rows_are_angles_or_heights) {
  const Background angles = panorama(BackgroundKind::panorama_equirectangular, 1, 8);
  const Background heights = panorama(BackgroundKind::panorama_equal_area, 1, 8);
  EXPECT_EQ(seen(angles, {0, 1, -1e-9}), 0);
  EXPECT_EQ(seen(angles, {0, 1, -.5}), 1);   // 27 degrees from the zenith
  EXPECT_EQ(seen(heights, {0, 1, -.5}), 0);  // y = .89
  EXPECT_EQ(seen(heights, {0, -.1, -1}), 4);
  EXPECT_EQ(seen(angles, {0, -1, -1e-9}), 7);
}

}  // namespace
}  // namespace tessera
