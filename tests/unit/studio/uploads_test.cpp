#include "studio/files/uploads.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "base/file.h"
#include "tests/error_of.h"
#include "tests/temporary_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

class StudioUploads : public testing::Test {
 protected:
  std::string write_error(const std::function<void()>& action) {
    return error_of(action, ExitCode::render_failed);
  }
  size_t files() const {
    const fs::recursive_directory_iterator all(root_.path());
    return static_cast<size_t>(std::distance(begin(all), end(all)));
  }

  TemporaryFolder root_;
  Folder folder_{root_.path()};
};

TEST_F(StudioUploads, APieceAtATimeMakesAFile) {
  Uploads uploads(folder_);
  uploads.begin(1, 7, "a.obj", 5);
  EXPECT_EQ(uploads.append(1, 7, "v 1", false).received, 3u);
  EXPECT_FALSE(fs::exists(root_ / "a.obj"));
  const Uploads::State state = uploads.append(1, 7, " 2", true);
  EXPECT_TRUE(state.is_whole);
  EXPECT_EQ(state.name, "a.obj");
  EXPECT_EQ(read_input_file(root_ / "a.obj", 100), "v 1 2");
  EXPECT_EQ(files(), 1u);
}

TEST_F(StudioUploads, NoFileIsWrittenOver) {
  write_output_file(root_ / "a.obj", "mine");
  fs::create_symlink("nowhere", root_ / "a-2.obj");
  Uploads uploads(folder_);
  uploads.begin(1, 1, "a.obj", 3);
  EXPECT_EQ(uploads.append(1, 1, "new", true).name, "a-3.obj");
  EXPECT_EQ(read_input_file(root_ / "a.obj", 100), "mine");
  uploads.begin(1, 2, "b.obj", 3);
  write_output_file(root_ / "b.obj", "mine");
  EXPECT_NE(write_error([&] { uploads.append(1, 2, "new", true); }), "no error");
  EXPECT_EQ(read_input_file(root_ / "b.obj", 100), "mine");
  EXPECT_EQ(files(), 4u) << "what was given up leaves nothing";
}

TEST_F(StudioUploads, TheNumbersOfAModelAreTaken) {
  Uploads uploads(folder_);
  for (const char* const name : {"a.gltf", "a.bin", "b.BIN"}) {
    uploads.begin(1, 1, name, 1);
    EXPECT_TRUE(uploads.append(1, 1, "1", true).is_whole);
  }
  EXPECT_EQ(files(), 3u);
}

TEST_F(StudioUploads, WhatIsGivenUpLeavesNothing) {
  Uploads uploads(folder_);
  uploads.begin(1, 1, "a.obj", 5);
  uploads.begin(2, 1, "b.obj", 5);
  EXPECT_EQ(files(), 2u);
  uploads.drop(1);
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(write_error([&] { uploads.append(1, 1, "12345", true); }),
            "no file with number 1 is expected");
  EXPECT_EQ(write_error([&] { uploads.append(2, 1, "123456", false); }),
            "'b.obj': 6 bytes came; expected 5");
  EXPECT_EQ(files(), 0u);
  uploads.begin(2, 1, "b.obj", 5);
  EXPECT_EQ(write_error([&] { uploads.append(2, 1, "1234", true); }),
            "'b.obj': 4 bytes came; expected 5");
  EXPECT_EQ(files(), 0u);
}

TEST_F(StudioUploads, HiddenLargeAndOtherFilesAreRefused) {
  Uploads uploads(folder_);
  EXPECT_EQ(write_error([&] { uploads.begin(1, 1, "a.obj", (uint64_t{256} << 20) + 1); }),
            "'a.obj' has 268435457 bytes; expected at most 256 MiB");
  EXPECT_NE(write_error([&] { uploads.begin(1, 1, "a.sh", 1); }), "no error");
  EXPECT_NE(error_of([&] { uploads.begin(1, 1, ".a.obj", 1); }), "no error");
  EXPECT_NE(error_of([&] { uploads.begin(1, 1, "../a.obj", 1); }), "no error");
  EXPECT_NE(write_error([&] { uploads.begin(1, 1, "none/a.obj", 1); }), "no error");
  for (uint32_t i = 0; i < Uploads::kMostOpen; ++i) uploads.begin(1, i, "a.obj", 1);
  EXPECT_NE(write_error([&] { uploads.begin(1, 9, "a.obj", 1); }), "no error");
  const Folder sealed(root_.path(), Folder::Access::read_only);
  Uploads none(sealed);
  EXPECT_NE(write_error([&] { none.begin(1, 1, "a.obj", 1); }), "no error");
}

TEST_F(StudioUploads, WhatAKilledProgramLeftIsRemovedAndWhatIsWrittenStays) {
  fs::create_directories(root_ / "models");
  const auto left = [&](const std::string& name) { std::ofstream(root_ / name) << "half"; };
  left(".tessera-abcdefghijklmnop.part");
  left("models/.tessera-abcdefghijklmnop.part");
  left("models/a.obj");
  left(".mine.part");
  Uploads uploads(folder_);
  uploads.begin(1, 1, "b.obj", 3);
  folder_.remove_unfinished();
  EXPECT_TRUE(uploads.append(1, 1, "new", true).is_whole);
  EXPECT_TRUE(fs::exists(root_ / ".mine.part"));
  EXPECT_TRUE(fs::exists(root_ / "models/a.obj"));
  EXPECT_EQ(files(), 4u);
}

}  // namespace
}  // namespace tessera
