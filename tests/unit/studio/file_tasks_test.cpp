#include "studio/file_tasks.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <variant>

#include "tests/temporary_folder.h"

namespace tessera {
namespace {

class FileTasks : public testing::Test {
 protected:
  FileFailed failure_of(const FileTask& task) {
    const auto result = do_file_task(task, {folder_, nullptr, settings_, samples_, uploads_});
    const auto* const failed = result ? std::get_if<FileFailed>(&*result) : nullptr;
    EXPECT_NE(failed, nullptr);
    return failed ? *failed : FileFailed();
  }

  TemporaryFolder root_;
  Folder folder_{root_.path()};
  StudioSettings settings_{std::filesystem::path()};
  Samples samples_{std::filesystem::path()};
  Uploads uploads_{folder_};
};

TEST_F(FileTasks, WhateverTheSystemRefusesIsAnAnswer) {
  const std::string too_long(300, 'x');
  const FileFailed failed =
      failure_of(CreateFiles{7, {{"a.tessera", "text"}, {too_long + ".mtl", "text"}}});
  EXPECT_EQ(failed.client, 7u);
  EXPECT_EQ(failed.request, "create");
  EXPECT_NE(failed.why, "");
}

TEST_F(FileTasks, WhatNoPictureCanReplaceIsKnownBeforeItIsTraced) {
  std::filesystem::create_directory(root_ / "folder.png");
  std::filesystem::create_directory(root_ / "sub");
  ASSERT_EQ(mkfifo((root_ / "pipe.png").c_str(), 0600), 0);
  CheckOutputs task{.client = 7, .wish = {}, .texts = {}};
  task.wish.file = "a.tessera";
  task.wish.force = true;
  for (const char* name : {"folder.png", "pipe.png", "none/a.png"}) {
    task.wish.outputs = {name};
    EXPECT_NE(failure_of(task).why, "") << name;
  }
  task.wish.outputs = {"a.png"};
  unsetenv("OCIO");
  task.wish.options = {{"ocio-view", "default"}};
  EXPECT_NE(failure_of(task).why.find("$OCIO"), std::string::npos);
}

TEST_F(FileTasks, AllFilesThatAPictureWouldReplaceAreKnownBeforeItIsTraced) {
  const auto make = [this](const char* name) { std::ofstream(root_ / name) << "old"; };
  for (const char* name : {"a.0002.png", "a.0004.png", "a.stats.0003.json", "all.gif", "b.png"})
    make(name);
  CheckOutputs task{.client = 7, .wish = {}, .texts = {}};
  task.wish.number = 5;
  task.wish.outputs = {"a.png", "all.gif"};
  task.wish.frames = FrameRange{1, 3};
  task.wish.statistics = true;
  FileFailed failed = failure_of(task);
  EXPECT_EQ(failed.number, 5u);
  EXPECT_EQ(failed.existing.first, "a.0002.png");
  EXPECT_EQ(failed.existing.count, 3u);
  task.wish.force = true;
  EXPECT_TRUE(std::holds_alternative<CheckOutputs>(
      *do_file_task(task, {folder_, nullptr, settings_, samples_, uploads_})));
  task.wish = {};
  task.wish.outputs = {"b.png"};
  failed = failure_of(task);
  EXPECT_EQ(failed.existing.count, 1u);
  EXPECT_EQ(failed.why, "'b.png' cannot be written: there is one of that name");
}

TEST_F(FileTasks, WhatALibraryThrowsIsAnAnswer) {
  EXPECT_EQ(failure_of(KeepSettings{"{"}).request, "settings");
}

}  // namespace
}  // namespace tessera
