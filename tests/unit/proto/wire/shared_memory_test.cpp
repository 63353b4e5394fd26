#include "proto/wire/shared_memory.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace tessera {
namespace {

std::vector<std::byte> some_bytes(size_t size) {
  std::vector<std::byte> bytes(size);
  for (size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 31 >> 3);
  return bytes;
}

/// Bytes of the mapping at `address` that are shared with another process, as the kernel tells.
size_t shared_bytes(const std::byte* address) {
  std::ifstream maps("/proc/self/smaps");
  char start[32];
  std::snprintf(start, sizeof start, "%lx-", reinterpret_cast<unsigned long>(address));
  bool found = false;
  for (std::string line; std::getline(maps, line);) {
    if (line.starts_with(start)) found = true;
    unsigned long kibibytes = 0;
    if (found && std::sscanf(line.c_str(), "Shared_Clean: %lu", &kibibytes) == 1 && kibibytes > 0)
      return kibibytes * 1024;
    if (found && std::sscanf(line.c_str(), "Shared_Dirty: %lu", &kibibytes) == 1)
      return kibibytes * 1024;
  }
  return 0;
}

TEST(SharedMemory, LargeBlobsMoveAndAnotherProcessHasTheSamePages) {
  constexpr size_t kSize = 1'000'000;
  BlobStore store;
  const Digest large = store.put(some_bytes(kSize)), small = store.put(some_bytes(1000));
  share_large_blobs(store);
  const BlobData blob = store.find(large);
  ASSERT_GE(blob->descriptor(), 0);
  EXPECT_EQ(store.find(small)->descriptor(), -1);
  EXPECT_EQ(Digest::of(*blob), large);
  share_large_blobs(store);
  EXPECT_EQ(store.find(large), blob) << "once is enough";

  const BlobPlace place{getpid(), blob->descriptor()};
  const pid_t child = fork();
  if (child == 0) {
    const BlobData there = map_shared_blob(place, kSize);
    if (!there || Digest::of(*there) != large) _exit(1);
    _exit(shared_bytes(there->data()) >= kSize / 2 ? 0 : 2);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(SharedMemory, NobodyCanChangeIt) {
  BlobStore store;
  const Digest digest = store.put(some_bytes(1'000'000));
  share_large_blobs(store);
  const int descriptor = store.find(digest)->descriptor();
  EXPECT_LT(ftruncate(descriptor, 10), 0);
  EXPECT_LT(write(descriptor, "x", 1), 0);
  EXPECT_EQ(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0), MAP_FAILED);
}

TEST(SharedMemory, OnlyWhatCannotChangeIsMapped) {
  // An ordinary file, memory without seals, a pipe, nothing, no process: made-up places do no harm.
  const int ordinary = open("/proc/self/exe", O_RDONLY), open_memory = memfd_create("x", 0);
  ASSERT_EQ(ftruncate(open_memory, 4096), 0);
  int pipes[2];
  ASSERT_EQ(pipe(pipes), 0);
  for (const int descriptor : {ordinary, open_memory, pipes[0], 9999, -1}) {
    EXPECT_FALSE(map_shared_blob({getpid(), descriptor}, 4096)) << descriptor;
  }
  EXPECT_FALSE(map_shared_blob({getpid(), ordinary}, std::filesystem::file_size("/proc/self/exe")));
  EXPECT_FALSE(map_shared_blob({0, 3}, 4096));
  EXPECT_FALSE(map_shared_blob({-7, 3}, 4096));
  for (const int descriptor : {ordinary, open_memory, pipes[0], pipes[1]}) close(descriptor);
  BlobStore store;
  const Digest digest = store.put(some_bytes(1'000'000));
  share_large_blobs(store);
  const BlobPlace place{getpid(), store.find(digest)->descriptor()};
  EXPECT_FALSE(map_shared_blob(place, 999'999));
  EXPECT_FALSE(map_shared_blob(place, 0));
  EXPECT_TRUE(map_shared_blob(place, 1'000'000));
}

}  // namespace
}  // namespace tessera
