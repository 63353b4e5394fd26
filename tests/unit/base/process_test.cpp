#include "base/process.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "base/core_count.h"
#include "tests/temporary_folder.h"

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

/// Control groups as the kernel shows them, in a folder of their own.
class CpuQuota : public testing::Test {
 protected:
  void write(const std::string& file, const std::string& text) const {
    const std::filesystem::path path = folder_.path() / file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  std::optional<int> quota(const std::string& membership) const {
    write("cgroup", membership);
    return cpu_quota(folder_.path() / "cgroup", folder_.path() / "fs");
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(CpuQuota, IsRoundedUp) {
  EXPECT_EQ(quota("0::/\n"), std::nullopt) << "there is no group";
  write("fs/cpu.max", "max 100000\n");
  EXPECT_EQ(quota("0::/\n"), std::nullopt);
  for (const auto& [text, cores] : {std::pair("100000 100000", 1),
                                    {"150000 100000", 2},
                                    {"10000 100000", 1},
                                    {"400000 100000", 4},
                                    {"75000 50000", 2}}) {
    write("fs/cpu.max", text);
    EXPECT_EQ(quota("0::/\n"), cores) << text;
  }
  for (const char* odd : {"", "-1 100000", "0 100000", "100000 0", "100000", "many"}) {
    write("fs/cpu.max", odd);
    EXPECT_EQ(quota("0::/\n"), std::nullopt) << odd;
  }
}

TEST_F(CpuQuota, OfNestedGroupsTheSmallestCounts) {
  write("fs/slice/cpu.max", "250000 100000\n");
  write("fs/slice/pod/cpu.max", "800000 100000\n");
  write("fs/slice/pod/box/cpu.max", "max 100000\n");
  EXPECT_EQ(quota("0::/slice/pod/box\n"), 3);
  write("fs/slice/pod/box/cpu.max", "100000 100000\n");
  EXPECT_EQ(quota("0::/slice/pod/box\n"), 1);
  EXPECT_EQ(quota("0::/slice/pod\n"), 3);
  EXPECT_EQ(quota("0::/other\n"), std::nullopt);
}

TEST_F(CpuQuota, OfAContainerItsOwnGroupIsAtTheTop) {
  write("fs/cpu.max", "200000 100000\n");
  EXPECT_EQ(quota("0::/docker/0123\n"), 2);
  EXPECT_EQ(quota("0::/../../outside\n"), 2);
}

TEST_F(CpuQuota, IsReadFromVersionOneToo) {
  write("fs/cpu/cpu.cfs_period_us", "100000\n");
  write("fs/cpu/cpu.cfs_quota_us", "-1\n");
  write("fs/cpu/box/cpu.cfs_period_us", "50000\n");
  write("fs/cpu/box/cpu.cfs_quota_us", "120000\n");
  write("fs/cpu/cpuset/cpu.cfs_quota_us", "1\n");
  EXPECT_EQ(quota("5:cpuset:/cpuset\n4:cpu,cpuacct:/box\n0::/\n"), 3);
  EXPECT_EQ(quota("4:cpu,cpuacct:/\n"), std::nullopt);
  for (const char* odd : {"", "x", ":", "::", "4:cpu", "4:cpu:box"})
    EXPECT_EQ(quota(odd), std::nullopt);
}

}  // namespace
}  // namespace tessera
