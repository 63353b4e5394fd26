#include "base/process.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <thread>

namespace tessera {
namespace {

TEST(CoreCount, IsOfTheCoresThatMayBeUsed) {
  // What a thread may use is its own.
  std::thread([] {
    const int core = sched_getcpu();
    ASSERT_GE(core, 0);
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
    EXPECT_EQ(core_count(), 1);
  }).join();
}

}  // namespace
}  // namespace tessera
