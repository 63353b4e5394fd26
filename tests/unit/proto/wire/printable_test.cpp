#include "proto/wire/printable.h"

#include <gtest/gtest.h>

#include "base/file.h"

namespace tessera {
namespace {

TEST(Printable, LeavesTextAsItIs) {
  EXPECT_EQ(printable(""), "");
  EXPECT_EQ(printable("host-7: K\u00f6ln, \u65e5\u672c, \U0001f600 ~"),
            "host-7: K\u00f6ln, \u65e5\u672c, \U0001f600 ~");
}

TEST(Printable, ControlCharactersAreWrittenOut) {
  EXPECT_EQ(printable("a\nb\tc\rd\x7f"
                      "e"),
            "a\\nb\\tc\\rd\\x7fe");
  EXPECT_EQ(printable(std::string_view("a\0b", 3)), "a\\x00b");
  EXPECT_EQ(printable("\x1b[2Jgone"), "\\x1b[2Jgone");
  EXPECT_EQ(printable("\u009b2J \u0080\u00a0"), "\\x9b2J \\x80\u00a0")
      << "the control characters above 127 too";
}

TEST(Printable, LongTextIsCutBetweenCharacters) {
  EXPECT_EQ(printable(std::string(1000, 'x')).size(), 1000u);
  EXPECT_EQ(printable("abcd", 3), "abc");
  EXPECT_EQ(printable(std::string(1001, 'x')).size(), 1000u);
  for (size_t before = 996; before <= 1000; ++before) {
    const std::string cut = printable(std::string(before, 'x') + "\U0001f600\U0001f600");
    EXPECT_EQ(cut.size(), before <= 996 ? before + 4 : before);
    EXPECT_EQ(find_invalid_utf8(cut), std::string::npos);
  }
}

TEST(Printable, WhatTurnsTheDirectionOfWritingIsWrittenOut) {
  EXPECT_EQ(printable("a\u202agnp.\u202ex"), "a\\u202agnp.\\u202ex");
  EXPECT_EQ(printable("\u2066\u2069"), "\\u2066\\u2069");
  EXPECT_EQ(printable("\u2029\u202f\u2065\u206a \u05d0"), "\u2029\u202f\u2065\u206a \u05d0")
      << "its neighbours, and letters from the right";
  EXPECT_EQ(printable("\xe2\x80"), "\xe2\x80");
}

TEST(Printable, StraysOfOtherEncodingsEndNothing) {
  EXPECT_EQ(printable(std::string(2000, '\x80')).size(), 0u) << "nowhere to cut";
  EXPECT_EQ(printable("a\xc2"), "a\xc2");
  EXPECT_EQ(printable("\xff\x01"), "\xff\\x01");
}

}  // namespace
}  // namespace tessera
