#include "front/option_values.h"

#include <gtest/gtest.h>

#include <array>

#include "base/error.h"
#include "tests/error_of.h"

namespace tessera {
namespace {

TEST(OptionValues, SizesAreReadAndBounded) {
  const FrameSize size = parse_size("--size", "1920x1080");
  EXPECT_EQ(size.width, 1920);
  EXPECT_EQ(size.height, 1080);
  EXPECT_EQ(parse_size("--size", "65536x4096").width, 65536);
  for (const char* wrong :
       {"", "x", "8", "8x", "x8", "0x8", "8x0", "-8x8", "8x8x8", "8.0x8", "+8x8", " 8x8", "8x8 ",
        "65537x1", "65536x4097", "1000000000x1000000000", "99999999999999999999x2", "axb"}) {
    EXPECT_NE(usage_error_of([&] { parse_size("--size", wrong); }), "no error") << wrong;
  }
}

TEST(OptionValues, WholeNumbersNameTheirRange) {
  EXPECT_EQ(parse_whole("--spp", "64", 1, 64), 64);
  EXPECT_EQ(usage_error_of([] { parse_whole("--spp", "65", 1, 64); }),
            "--spp: '65'; expected a whole number from 1 to 64");
  for (const char* wrong : {"", "0", "-1", "1e1", "0x10", "1 ", "9223372036854775808"}) {
    EXPECT_NE(usage_error_of([&] { parse_whole("--spp", wrong, 1, 64); }), "no error") << wrong;
  }
}

TEST(OptionValues, NumbersAreFinite) {
  EXPECT_EQ(parse_number("--time", "-2.5e1"), -25);
  for (const char* wrong : {"", "nan", "inf", "1e999", "1,5", "1s"}) {
    EXPECT_NE(usage_error_of([&] { parse_number("--time", wrong); }), "no error") << wrong;
  }
}

TEST(OptionValues, CropsHaveAnInside) {
  EXPECT_EQ(parse_crop("--crop", "1,2,30,40"), (PixelRect{1, 2, 30, 40}));
  for (const char* wrong :
       {"", "1,2,3", "1,2,3,4,5", "3,0,3,9", "0,9,3,9", "-1,0,3,3", "a,b,c,d"}) {
    EXPECT_NE(usage_error_of([&] { parse_crop("--crop", wrong); }), "no error") << wrong;
  }
}

TEST(OptionValues, FramesAreNumbersRangesAndSteps) {
  const auto frames = [](const char* text) { return parse_frames("--frames", text); };
  EXPECT_EQ(frames("5"), FrameNumbers({5}));
  EXPECT_EQ(frames("3-6"), FrameNumbers({3, 4, 5, 6}));
  EXPECT_EQ(frames("3..6"), FrameNumbers({3, 4, 5, 6}));
  EXPECT_EQ(frames("7-7"), FrameNumbers({7}));
  EXPECT_EQ(frames("1-20x5"), FrameNumbers({1, 6, 11, 16}));
  EXPECT_EQ(frames("1-21x5"), FrameNumbers({1, 6, 11, 16, 21}));
  EXPECT_EQ(frames("0-9x100"), FrameNumbers({0}));
  EXPECT_EQ(frames("1,5,10-12"), FrameNumbers({1, 5, 10, 11, 12}));
  EXPECT_EQ(frames("999999990-999999999x9"), FrameNumbers({999999990, 999999999}));
  // In any order, with spaces, and given twice.
  EXPECT_EQ(frames("10-12, 5, 1-9x4, 11"), FrameNumbers({1, 5, 9, 10, 11, 12}));
  for (const char* wrong : {"",
                            "-",
                            "3-",
                            "-3",
                            "4-3",
                            "1-2-3",
                            "1,",
                            ",1",
                            "1,,2",
                            "1x2",
                            "1-9x",
                            "1-9x0",
                            "x3",
                            "1-9x-1",
                            "1.5",
                            "1...3",
                            "0--0",
                            "1 3",
                            "1-9y2",
                            "1- 3",
                            "0-1000000000",
                            "99999999999999999999"}) {
    EXPECT_NE(usage_error_of([&] { frames(wrong); }).find("1,5,10-20 or 1-100x5"),
              std::string::npos)
        << wrong;
  }
}

TEST(OptionValues, TooManyFramesAreRefusedBeforeTheyAreCounted) {
  EXPECT_EQ(parse_frames("--frames", "1-1000000").size(), 1000000U);
  EXPECT_EQ(usage_error_of([] { parse_frames("--frames", "0-999999999"); }),
            "--frames: '0-999999999' asks for 1000000000 frames; expected at most 1000000, "
            "for a job of a farm 10000");
  EXPECT_NE(usage_error_of([] { parse_frames("--frames", "0-600000,0-600000"); }), "no error");
}

TEST(OptionValues, ChannelsMayHaveSpacesBetween) {
  const AovSet two = AovSet().with(Aov::albedo).with(Aov::depth);
  EXPECT_EQ(parse_aovs("--aovs", "albedo,depth"), two);
  EXPECT_EQ(parse_aovs("--aovs", "albedo,  depth"), two);
  for (const char* wrong : {"", " ", "albedo,", "albedo depth", ",depth"}) {
    EXPECT_NE(usage_error_of([&] { parse_aovs("--aovs", wrong); }), "no error") << wrong;
  }
}

TEST(OptionValues, AChoiceSuggestsTheNearest) {
  const std::array<std::string, 2> names{"bvh", "linear"};
  EXPECT_EQ(parse_choice("--accel", "bvh", names), "bvh");
  const std::string said = usage_error_of([&] { parse_choice("--accel", "liner", names); });
  EXPECT_NE(said.find("'liner'"), std::string::npos) << said;
  EXPECT_NE(said.find("did you mean 'linear'"), std::string::npos) << said;
}

}  // namespace
}  // namespace tessera
