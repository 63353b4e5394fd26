#include "base/shared_arena.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace tessera {
namespace {

void put(SharedArena::Claim& claim, std::string_view text) {
  const std::array parts{std::as_bytes(std::span(text))};
  claim.publish(parts);
}

/// What is there, or nothing, which claims it.
std::string get(const SharedArena::Claim& claim) {
  std::string text(claim.size().value_or(0), '\0');
  EXPECT_EQ(claim.read(0, std::as_writable_bytes(std::span(text))), claim.size().has_value());
  return text;
}

const Digest kOne = Digest::of("one"), kTwo = Digest::of("two");

TEST(SharedArena, GivesWhatWasPutThere) {
  const OwnedDescriptor memory = SharedArena::create();
  const SharedArena arena(memory.get());
  for (const auto& [key, text] : {std::pair{kOne, "first"}, std::pair{kTwo, "the second"}}) {
    SharedArena::Claim claim = arena.claim(key);
    EXPECT_FALSE(claim.size());
    put(claim, text);
  }
  EXPECT_EQ(get(arena.claim(kOne)), "first");
  EXPECT_EQ(get(arena.claim(kTwo)), "the second");
  std::byte beyond[7];
  EXPECT_FALSE(arena.claim(kOne).read(4, std::span(beyond).first(2)));
  EXPECT_FALSE(arena.claim(kOne).read(6, std::span(beyond).first(0)));
}

TEST(SharedArena, IsMadeByOneAlone) {
  const OwnedDescriptor memory = SharedArena::create();
  std::atomic<int> makers{0};
  std::vector<std::string> got(8);
  {
    std::vector<std::jthread> threads;
    for (std::string& mine : got) {
      threads.emplace_back([&] {
        const SharedArena arena(memory.get());
        SharedArena::Claim claim = arena.claim(kOne);
        if (!claim.size()) {
          ++makers;
          std::this_thread::sleep_for(std::chrono::milliseconds(5));
          put(claim, "made");
        }
        mine = get(arena.claim(kOne));
      });
    }
  }
  EXPECT_EQ(makers, 1);
  for (const std::string& text : got) EXPECT_EQ(text, "made");
}

TEST(SharedArena, WhoDiesOverAThingMakesWay) {
  const OwnedDescriptor memory = SharedArena::create();
  const SharedArena arena(memory.get());
  std::array<int, 2> claimed{};
  ASSERT_EQ(pipe(claimed.data()), 0);
  const pid_t child = fork();
  if (child == 0) {
    const SharedArena::Claim claim = arena.claim(kOne);
    [[maybe_unused]] const ssize_t told = write(claimed[1], "x", 1);
    pause();
    _exit(0);
  }
  char sign;
  ASSERT_EQ(read(claimed[0], &sign, 1), 1);
  std::jthread killer([child] { kill(child, SIGKILL); });
  SharedArena::Claim claim = arena.claim(kOne);
  EXPECT_FALSE(claim.size());
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  put(claim, "by another");
  EXPECT_EQ(get(arena.claim(kOne)), "by another");
  for (const int end : claimed) close(end);
}

TEST(SharedArena, WhereThereIsNoneEverybodyMakesTheirOwn) {
  const SharedArena arena(-1);
  SharedArena::Claim claim = arena.claim(kOne);
  EXPECT_FALSE(claim.size());
  put(claim, "lost");
  EXPECT_FALSE(arena.claim(kOne).size());
}

}  // namespace
}  // namespace tessera
