#include "client/refusal.h"

#include <gtest/gtest.h>

#include <chrono>

#include "base/error.h"

namespace tessera {
namespace {

using namespace std::chrono_literals;

constexpr const char* kNobody = "ipc:///nowhere/farm";

TEST(FirstWord, TellsAfterTwoSecondsThatNobodyListens) {
  const Time begin = 1h;
  FirstWord first_word(begin);
  EXPECT_NO_THROW(first_word.check(kNobody, begin));
  EXPECT_NO_THROW(first_word.check(kNobody, begin + 1999ms));
  EXPECT_THROW(first_word.check(kNobody, begin + 2s), Error);
}

TEST(FirstWord, OnceHeardIsNotWaitedForAgain) {
  FirstWord first_word(1h);
  first_word.heard();
  EXPECT_NO_THROW(first_word.check(kNobody, 24h));
}

}  // namespace
}  // namespace tessera
