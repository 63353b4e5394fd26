#include "base/signal_stack.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <limits>
#include <thread>

#include "base/parallel.h"

namespace tessera {
namespace {

constexpr int kHandled = 42;

/// No stack has room for as many calls as `left` counts from the largest number.
[[gnu::noinline]] int overflow(int left = std::numeric_limits<int>::max()) {
  volatile char page[4096];
  page[left % 4096] = static_cast<char>(left);
  return left == 0 ? 0 : overflow(left - 1) + page[0];
}

void end_by_handler() {
  struct sigaction action {};
  action.sa_handler = [](int) { _exit(kHandled); };
  action.sa_flags = SA_ONSTACK;
  sigaction(SIGSEGV, &action, nullptr);
}

TEST(SignalStackDeathTest, AHandlerRunsWhereTheStackHasOverflowed) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        end_by_handler();
        std::thread([] {
          const SignalStack stack;
          overflow();
        }).join();
      },
      ::testing::ExitedWithCode(kHandled), "");
}

TEST(SignalStackDeathTest, ThreadsThatHelpHaveOne) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        end_by_handler();
        const auto main_thread = std::this_thread::get_id();
        // Whichever thread takes it, a helper comes to overflow, since the first one waits.
        for_each_parallel(2, 2, [&](size_t) {
          if (std::this_thread::get_id() != main_thread) overflow();
          std::this_thread::sleep_for(std::chrono::hours(1));
        });
      },
      ::testing::ExitedWithCode(kHandled), "");
}

}  // namespace
}  // namespace tessera
