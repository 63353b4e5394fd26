#include "base/tally.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using std::chrono::seconds;

TEST(Tally, TellsTheFirstAtOnceAndThenOnceAPeriod) {
  Tally tally(seconds(10));
  EXPECT_EQ(tally.note(seconds(100)), 1u);
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(tally.note(seconds(101)));
  EXPECT_EQ(tally.note(seconds(110)), 1001u);
  EXPECT_FALSE(tally.note(seconds(119)));
  EXPECT_EQ(tally.note(seconds(120)), 2u);
}

}  // namespace
}  // namespace tessera
