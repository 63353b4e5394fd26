#include "studio/scene_reading.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/fs.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <thread>

#include "tests/temporary_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

TEST(SceneReading, NoLinkIsFollowedOutHoweverLateItTakesAFilesPlace) {
  const TemporaryFolder folder;
  const fs::path opened = folder / "opened";
  fs::create_directory(opened);
  const std::string own = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  std::ofstream(folder / "secret.obj") << own << "f 3 2 1\n";
  std::ofstream(opened / "own.obj") << own;
  std::ofstream(opened / "a.tessera") << "includes { file: \"own.obj\" }\n";
  fs::create_symlink(folder / "secret.obj", opened / "link");
  // Now the file has the name, now the link.
  std::atomic<bool> ends{false};
  std::atomic<int> exchanged{0};
  std::thread other([&] {
    while (!ends)
      if (syscall(SYS_renameat2, AT_FDCWD, (opened / "own.obj").c_str(), AT_FDCWD,
                  (opened / "link").c_str(), RENAME_EXCHANGE) == 0)
        ++exchanged;
  });
  constexpr int kReadings = 2000;
  int read = 0, leaked = 0;
  for (int i = 0; i < kReadings; ++i) {
    ReadOrder order;
    order.file = "a.tessera";
    const SceneReading reading = read_for_studio(order, {.folder = opened.string()});
    if (!reading.scene) continue;
    ++read;
    for (const SceneSummary::Count& each : reading.summary.counts)
      leaked += each.what == "triangles" && each.count > 1;
  }
  ends = true;
  other.join();
  EXPECT_GT(exchanged, 0);
  EXPECT_GT(read, 0);
  EXPECT_EQ(leaked, 0);
}

TEST(SceneReading, HiddenFilesAreNotRead) {
  const TemporaryFolder folder;
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  fs::create_directory(folder / ".keys");
  for (const char* name : {"seen.obj", ".env.obj", ".keys/id.obj"}) {
    std::ofstream(folder / name) << triangle;
    std::ofstream(folder / "a.tessera") << "includes { file: \"" << name << "\" }\n";
    ReadOrder order;
    order.file = "a.tessera";
    const SceneReading reading = read_for_studio(order, {.folder = folder.path().string()});
    EXPECT_EQ(reading.scene != nullptr, std::string(name) == "seen.obj") << name;
  }
}

TEST(SceneReading, AFileWhoseBeginningAloneIsOpenIsReadWhole) {
  const TemporaryFolder folder;
  const std::string text =
      std::string(Document::kMostBytes - 10, '#') + "\nnodes { shape { sphere { radius: 2 } } }\n";
  std::ofstream(folder / "a.tessera") << text;
  ReadOrder order;
  order.file = "a.tessera";
  order.texts.emplace("a.tessera", Document(text.substr(0, Document::kMostBytes), false));
  const SceneReading reading = read_for_studio(order, {.folder = folder.path().string()});
  ASSERT_TRUE(reading.scene) << reading.problems.at(0).message;
  EXPECT_EQ(reading.scene->loaded.scene.nodes_size(), 1);
}

SceneReading read_crt(const TemporaryFolder& folder, const std::string& text) {
  std::ofstream(folder / "a.crt") << text;
  ReadOrder order;
  order.file = "a.crt";
  return read_for_studio(order, {.folder = folder.path().string()});
}

TEST(SceneReading, AnErrorShowsNoSourceLines) {
  const TemporaryFolder folder;
  const SceneReading reading = read_crt(folder, "Scene {\n  Nonsense {}\n}\n");
  ASSERT_EQ(reading.problems.size(), 1u);
  EXPECT_NE(reading.problems[0].message.find("Nonsense"), std::string::npos);
  EXPECT_EQ(reading.problems[0].message.find('\n'), std::string::npos);
}

TEST(SceneReading, EachOfSeveralErrorsIsToldAlone) {
  const TemporaryFolder folder;
  const SceneReading reading = read_crt(folder, "Scene {\n  Nonsense1 {}\n  Nonsense2 {}\n}\n");
  ASSERT_GE(reading.problems.size(), 2u);
  for (const Problem& problem : reading.problems) {
    const bool has_first = problem.message.find("Nonsense1") != std::string::npos;
    const bool has_second = problem.message.find("Nonsense2") != std::string::npos;
    EXPECT_FALSE(has_first && has_second) << problem.message;
    EXPECT_NE(problem.message, "");
  }
  EXPECT_NE(reading.problems[0].message, reading.problems[1].message);
}

}  // namespace
}  // namespace tessera
