#include "base/descriptors.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file.h"

namespace tessera {
namespace {

constexpr rlim_t kLimit = 256, kKept = 64;

void set_limit(rlim_t soft, rlim_t hard) {
  const rlimit limit{soft, hard};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &limit), 0);
}

rlim_t soft_limit() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  return limit.rlim_cur;
}

int open_one() { return open("/dev/null", O_RDONLY | O_CLOEXEC); }

/// As a flood of connections does: until there is none left.
int take_all() {
  int taken = 0;
  while (open_one() >= 0) ++taken;
  EXPECT_EQ(errno, EMFILE);
  return taken;
}

/// Each in a process of its own: a limit that was lowered cannot be raised again.
void in_child(void (*body)()) {
  EXPECT_EXIT(
      {
        body();
        const auto& result = *::testing::UnitTest::GetInstance()->current_test_info()->result();
        for (int i = 0; i < result.total_part_count(); ++i) {
          std::fprintf(stderr, "%s\n", result.GetTestPartResult(i).message());
        }
        _exit(result.Failed() ? 1 : 0);
      },
      ::testing::ExitedWithCode(0), "");
}

TEST(SpareDescriptorsDeathTest, AreThereWhenAllOthersAreTaken) {
  in_child([] {
    set_limit(100, kLimit);
    keep_spare_descriptors();
    EXPECT_EQ(soft_limit(), kLimit - kKept);
    take_all();
    int spare = -1;
    {
      const SpareDescriptors outer;
      {
        const SpareDescriptors inner;
        spare = open_one();
      }
      EXPECT_EQ(soft_limit(), kLimit);  // the outer one still holds it
    }
    ASSERT_GE(spare, static_cast<int>(kLimit - kKept));
    EXPECT_EQ(open_one(), -1);
    EXPECT_EQ(errno, EMFILE);
    char byte;
    EXPECT_EQ(read(spare, &byte, 1), 0);  // it stays open
    {
      const SpareDescriptors all;
      EXPECT_GT(take_all(), 0);
    }
  });
}

TEST(SpareDescriptorsDeathTest, AreThereForFilesThatAreReadAndWritten) {
  in_child([] {
    set_limit(kLimit, kLimit);
    const std::string path =
        (std::filesystem::temp_directory_path() / "tessera-descriptors-test").string() +
        std::to_string(getpid());
    keep_spare_descriptors();
    take_all();
    write_output_file(path, "a picture");
    EXPECT_EQ(read_input_file(path, 100), "a picture");
    std::filesystem::remove(path);
  });
}

TEST(SpareDescriptorsDeathTest, AQuarterIsKeptWhereThereAreFew) {
  in_child([] {
    set_limit(80, 80);
    { const SpareDescriptors none_is_kept; }
    EXPECT_EQ(soft_limit(), 80u);
    keep_spare_descriptors();
    EXPECT_EQ(soft_limit(), 60u);
    keep_spare_descriptors();
    EXPECT_EQ(soft_limit(), 60u);
  });
}

TEST(SpareDescriptorsDeathTest, DoNotCountAsLeftForConnections) {
  in_child([] {
    set_limit(kLimit, kLimit);
    keep_spare_descriptors();
    int last = -1, one;
    while ((one = open_one()) >= 0) last = one;
    for (int i = 0; i < 10; ++i) close(last - i);
    check_room_for_descriptors(9);  // to count them takes one
    try {
      check_room_for_descriptors(11);
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("of 192 file descriptors are in use, beside "
                                                     "64 that are kept for files; expected 11"));
    }
    // One that was opened from the reserve takes none of the others.
    {
      const SpareDescriptors spare;
      while (open_one() >= 0) continue;
    }
    for (int i = 0; i < 10; ++i) close(last - i);
    check_room_for_descriptors(9);
  });
}

}  // namespace
}  // namespace tessera
