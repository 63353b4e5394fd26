#include "base/open_input.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "base/error.h"
#include "base/file.h"
#include "tests/temporary_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// A folder that is opened, beside a file that nobody is to read.
class InputRootsTest : public testing::Test {
 protected:
  InputRootsTest() {
    fs::create_directories(opened_ / "part");
    std::ofstream(opened_ / "part/own.obj") << "own";
    std::ofstream(opened_ / "other.obj") << "other";
    std::ofstream(top_ / "secret") << "secret";
  }
  /// What is read of a file that was found inside; "refused" where it is not opened.
  static std::string read(const fs::path& path) {
    try {
      return read_input_file(path.string(), 100);
    } catch (const Error&) {
      return "refused";
    }
  }
  fs::path found(const std::string& name) const {
    return resolve_inside(opened_, name).value_or(fs::path());
  }

  const TemporaryFolder folder_;
  const fs::path top_ = fs::canonical(folder_.path()), opened_ = top_ / "opened";
};

TEST_F(InputRootsTest, ALinkThatTookAFilesPlaceSinceItWasFoundIsNotFollowedOut) {
  const fs::path own = found("part/own.obj"), other = found("other.obj");
  fs::remove(own);
  fs::create_symlink(top_ / "secret", own);
  EXPECT_EQ(read(own), "secret") << "without roots it is";
  const InputRoots roots({opened_});
  EXPECT_EQ(read(own), "refused");
  EXPECT_EQ(read(other), "other");
  EXPECT_EQ(read(top_ / "secret"), "refused");
  fs::remove_all(opened_ / "part");
  fs::create_directory(top_ / "elsewhere");
  std::ofstream(top_ / "elsewhere/own.obj") << "secret";
  fs::create_directory_symlink(top_ / "elsewhere", opened_ / "part");
  EXPECT_EQ(read(own), "refused") << "nor is one that took its folder's";
}

TEST_F(InputRootsTest, LinksWithinTheFolderAndFurtherFoldersAreRead) {
  fs::create_symlink("part/own.obj", opened_ / "link.obj");
  fs::create_directory(top_ / "assets");
  std::ofstream(top_ / "assets/a.obj") << "asset";
  const InputRoots roots({opened_, top_ / "assets"});
  EXPECT_EQ(read(opened_ / "link.obj"), "own");
  EXPECT_EQ(read(top_ / "assets/a.obj"), "asset");
}

TEST_F(InputRootsTest, APipeInAFilesPlaceMakesNobodyWait) {
  const fs::path pipe = opened_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_LT(open_input(pipe.string()).get(), 0);
  EXPECT_EQ(open_input_file(pipe.string()), nullptr);
}

}  // namespace
}  // namespace tessera
