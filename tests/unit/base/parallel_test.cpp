#include "base/parallel.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace tessera {
namespace {

TEST(Parallel, DoesEachOnce) {
  for (const int threads : {0, 1, 3, 8}) {
    std::vector<std::atomic<int>> done(100);
    for_each_parallel(done.size(), threads, [&](size_t i) { ++done[i]; });
    for (const auto& count : done) EXPECT_EQ(count, 1);
  }
  for_each_parallel(0, 4, [](size_t) { FAIL(); });
}

TEST(Parallel, NothingOfOneThreadIsUsedByTwo) {
  for (const int threads : {0, 1, 3, 200}) {
    std::vector<std::atomic<int>> done(100);
    std::vector<std::atomic<int>> users(100);
    for_each_of_thread(done.size(), threads, [&](size_t thread, size_t i) {
      ASSERT_LT(thread, static_cast<size_t>(std::max(threads, 1)));
      ASSERT_EQ(users[thread]++, 0);
      ++done[i];
      --users[thread];
    });
    for (const auto& count : done) EXPECT_EQ(count, 1);
  }
  for_each_of_thread(0, 4, [](size_t, size_t) { FAIL(); });
}

TEST(Parallel, ThrowsTheFirstOfTheFailures) {
  for (int round = 0; round < 50; ++round) {
    std::string what;
    std::atomic<int> done{0};
    try {
      for_each_parallel(40, 4, [&](size_t i) {
        ++done;
        if (i % 10 == 7) throw std::runtime_error(std::to_string(i));
      });
    } catch (const std::runtime_error& error) {
      what = error.what();
    }
    EXPECT_EQ(what, "7");
    EXPECT_EQ(done, 40);
  }
}

TEST(Parallel, EndsEarlyWhereTheCallerIsCancelled) {
  for (const int threads : {1, 4}) {
    std::atomic<bool> flag{false};
    std::atomic<int> done{0};
    const Cancellation cancellation(&flag);
    const auto work = [&] {
      for_each_parallel(4, threads, [&](size_t) {
        for_each_parallel(1000, threads, [&](size_t) {
          if (++done >= 10) flag = true;
        });
      });
    };
    EXPECT_THROW(work(), WorkCancelled);
    EXPECT_GE(done, 10);
    EXPECT_LE(done, 9 + threads * threads);
    flag = false;
    EXPECT_NO_THROW(for_each_parallel(4, threads, [](size_t) {}));
  }
  EXPECT_EQ(Cancellation::current(), nullptr);
}

}  // namespace
}  // namespace tessera
