#include "studio/files/draft_store.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/error_of.h"
#include "tests/file_size_limit.h"
#include "tests/temporary_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

TextDraft draft_of(const std::string& file, const std::string& text, int64_t saved_at = 1) {
  return {.folder = "/scenes",
          .file = file,
          .base = Digest::of("base"),
          .saved_at = saved_at,
          .text = text};
}

std::optional<TextDraft> newest(const DraftStore& drafts, const std::string& folder,
                                const std::string& file) {
  const std::vector<KeptDraft> found = drafts.find(folder, file);
  return found.empty() ? std::nullopt : std::optional(found.front().draft);
}

std::vector<fs::path> drafts_in(const fs::path& folder) {
  std::vector<fs::path> out;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".draft") out.push_back(entry.path());
  }
  return out;
}

/// Runs `action` in a process that is killed after it.
template <typename Action>
void in_killed_program(const Action& action) {
  const pid_t child = fork();
  if (child == 0) {
    action();
    kill(getpid(), SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status));
}

RC_GTEST_PROP(StudioDrafts, WhatWasPutIsFound, ()) {
  const TemporaryFolder folder;
  const auto names = rc::gen::container<std::string>(rc::gen::inRange<char>(1, 127));
  const TextDraft draft{.folder = *names,
                        .file = *names,
                        .base = Digest::of(*names),
                        .saved_at = *rc::gen::arbitrary<int64_t>(),
                        .text = *rc::gen::arbitrary<std::string>()};
  const DraftStore drafts(folder / "drafts");
  drafts.put(draft);
  RC_ASSERT(newest(drafts, draft.folder, draft.file) == draft);
  RC_ASSERT(!newest(drafts, draft.folder, draft.file + "x"));
  RC_ASSERT(!newest(drafts, draft.folder + "x", draft.file));
}

TEST(StudioDrafts, KeepTheLastTextUntilDropped) {
  const TemporaryFolder folder;
  const DraftStore drafts(folder / "a/drafts");
  EXPECT_EQ(newest(drafts, "/scenes", "a.crt"), std::nullopt);
  drafts.put(draft_of("a.crt", "one"));
  drafts.put(draft_of("b.crt", std::string("two\0\r\n", 6)));
  drafts.put(draft_of("a.crt", "three", 2));
  EXPECT_EQ(newest(drafts, "/scenes", "a.crt"), draft_of("a.crt", "three", 2));
  EXPECT_EQ(newest(drafts, "/scenes", "b.crt"), draft_of("b.crt", std::string("two\0\r\n", 6)));
  EXPECT_EQ(drafts_in(folder / "a/drafts").size(), 2u);
  drafts.drop_own("/scenes", "a.crt");
  EXPECT_EQ(newest(drafts, "/scenes", "a.crt"), std::nullopt);
  EXPECT_NE(newest(drafts, "/scenes", "b.crt"), std::nullopt);
}

TEST(StudioDrafts, NobodyElseCanReadThem) {
  const TemporaryFolder folder;
  const mode_t before = umask(0);
  const DraftStore drafts(folder / "drafts");
  drafts.put(draft_of("a.crt", "text"));
  umask(before);
  struct stat status;
  ASSERT_EQ(stat((folder / "drafts").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777, 0700u);
  for (const auto& entry : fs::directory_iterator(folder / "drafts")) {
    ASSERT_EQ(stat(entry.path().c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777, 0600u) << entry.path();
  }
}

TEST(StudioDrafts, OutliveAProgramThatIsKilled) {
  const TemporaryFolder folder;
  in_killed_program(
      [&] { DraftStore(folder / "drafts").put(draft_of("ended.crt", "by the way")); });
  in_killed_program([&] {
    const DraftStore drafts(folder / "drafts");
    drafts.put(draft_of("a.crt", "older", 5));
    kill(getpid(), SIGKILL);
  });
  in_killed_program([&] {
    const DraftStore drafts(folder / "drafts");
    drafts.put(draft_of("a.crt", "newer", 6));
    kill(getpid(), SIGKILL);
  });
  const DraftStore drafts(folder / "drafts");
  EXPECT_EQ(newest(drafts, "/scenes", "a.crt"), draft_of("a.crt", "newer", 6));
  EXPECT_EQ(newest(drafts, "/scenes", "ended.crt"), draft_of("ended.crt", "by the way"));
  drafts.put(draft_of("a.crt", "newest", 7));
  std::vector<KeptDraft> found = drafts.find("/scenes", "a.crt");
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].draft.text, "newest");
  EXPECT_EQ(found[1].draft.text, "newer");
  EXPECT_EQ(found[2].draft.text, "older");
  drafts.drop_own("/scenes", "a.crt");
  EXPECT_EQ(newest(drafts, "/scenes", "a.crt"), draft_of("a.crt", "newer", 6));
  drafts.drop("/scenes", "a.crt", {found[1].program});
  EXPECT_EQ(newest(drafts, "/scenes", "a.crt"), draft_of("a.crt", "older", 5));
  drafts.drop("/scenes", "a.crt", {found[2].program});
  EXPECT_EQ(newest(drafts, "/scenes", "a.crt"), std::nullopt);
  EXPECT_EQ(drafts_in(folder / "drafts").size(), 1u);
  size_t marks = 0;
  for (const auto& entry : fs::directory_iterator(folder / "drafts"))
    marks += entry.path().extension() == ".running";
  EXPECT_EQ(marks, 1u);
}

TEST(StudioDrafts, OfAProgramThatRunsAreLeftAlone) {
  const TemporaryFolder folder;
  auto first = std::make_unique<DraftStore>(folder / "drafts");
  const DraftStore second(folder / "drafts");
  first->put(draft_of("a.crt", "of the first", 9));
  EXPECT_EQ(newest(second, "/scenes", "a.crt"), std::nullopt);
  second.put(draft_of("a.crt", "of the second", 1));
  EXPECT_EQ(newest(second, "/scenes", "a.crt"), draft_of("a.crt", "of the second", 1));
  second.drop_own("/scenes", "a.crt");
  EXPECT_EQ(newest(*first, "/scenes", "a.crt"), draft_of("a.crt", "of the first", 9));
  first.reset();
  EXPECT_EQ(newest(second, "/scenes", "a.crt"), draft_of("a.crt", "of the first", 9));
}

TEST(StudioDrafts, DamagedOnesAreRemoved) {
  const TemporaryFolder folder;
  const DraftStore drafts(folder / "drafts");
  drafts.put(draft_of("a.crt", "some text"));
  const fs::path path = drafts_in(folder / "drafts").at(0);
  std::string bytes(fs::file_size(path), '\0');
  std::ifstream(path, std::ios::binary)
      .read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  const std::string head = bytes.substr(0, bytes.find('\n'));
  const std::vector<std::string> all{"",
                                     bytes.substr(0, bytes.size() - 1),
                                     bytes + "x",
                                     bytes.substr(1),
                                     head,
                                     "{}\nsome text",
                                     "[1]\nsome text",
                                     "null\nsome text",
                                     "\n",
                                     std::string(100000, '['),
                                     std::string(100000, 'x') + "\n",
                                     std::string(60000, '[') + "\n"};
  for (const std::string& damaged : all) {
    std::ofstream(path, std::ios::binary) << damaged;
    EXPECT_EQ(newest(drafts, "/scenes", "a.crt"), std::nullopt);
    EXPECT_FALSE(fs::exists(path));
  }
  // Under the name of another.
  drafts.put(draft_of("b.crt", "some text"));
  fs::rename(drafts_in(folder / "drafts").at(0), path);
  EXPECT_EQ(newest(drafts, "/scenes", "a.crt"), std::nullopt);
  EXPECT_FALSE(fs::exists(path));
  mkfifo(path.c_str(), 0600);
  EXPECT_EQ(newest(drafts, "/scenes", "a.crt"), std::nullopt);
  EXPECT_FALSE(fs::exists(path));
}

TEST(StudioDrafts, TheOldestGoBeyondALimit) {
  const TemporaryFolder folder;
  const std::string text(1000, 'x');
  const DraftStore running(folder / "drafts");
  running.put(draft_of("other.crt", text));
  const DraftStore drafts(folder / "drafts", 5000);
  for (const char* name : {"a.crt", "b.crt", "c.crt", "d.crt", "e.crt"}) {
    drafts.put(draft_of(name, text));
    // File systems' clocks are coarse.
    for (const auto& path : drafts_in(folder / "drafts"))
      fs::last_write_time(path, fs::last_write_time(path) - std::chrono::seconds(1));
  }
  EXPECT_EQ(newest(drafts, "/scenes", "a.crt"), std::nullopt);
  EXPECT_EQ(newest(drafts, "/scenes", "b.crt"), std::nullopt);
  for (const char* name : {"c.crt", "d.crt", "e.crt"})
    EXPECT_NE(newest(drafts, "/scenes", name), std::nullopt);
  // A text that replaces its own draft needs no place beside it.
  drafts.put(draft_of("c.crt", text));
  EXPECT_NE(newest(drafts, "/scenes", "d.crt"), std::nullopt);
  EXPECT_NE(newest(running, "/scenes", "other.crt"), std::nullopt);
  EXPECT_NE(error_of([&] { drafts.put(draft_of("f.crt", std::string(5000, 'x'))); },
                     ExitCode::render_failed),
            "no error");
}

TEST(StudioDrafts, OnAFullDiskTheOldOneStays) {
  const TemporaryFolder folder;
  const DraftStore drafts(folder / "drafts");
  drafts.put(draft_of("a.crt", "old"));
  {
    const FileSizeLimit limit(5000);
    EXPECT_NE(error_of([&] { drafts.put(draft_of("a.crt", std::string(10000, 'x'))); },
                       ExitCode::render_failed),
              "no error");
  }
  EXPECT_EQ(newest(drafts, "/scenes", "a.crt"), draft_of("a.crt", "old"));
  EXPECT_EQ(drafts_in(folder / "drafts").size(), 1u);
}

TEST(StudioDrafts, LieWhereTheUserKeepsState) {
  ASSERT_EQ(setenv("HOME", "/home/somebody", 1), 0);
  ASSERT_EQ(setenv("XDG_STATE_HOME", "/state", 1), 0);
  EXPECT_EQ(DraftStore::default_folder(), "/state/tessera/studio");
  ASSERT_EQ(setenv("XDG_STATE_HOME", "relative", 1), 0);
  EXPECT_EQ(DraftStore::default_folder(), "/home/somebody/.local/state/tessera/studio");
  unsetenv("XDG_STATE_HOME");
  unsetenv("HOME");
  EXPECT_EQ(DraftStore::default_folder(), "");
}

}  // namespace
}  // namespace tessera
