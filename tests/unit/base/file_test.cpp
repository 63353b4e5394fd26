#include "base/file.h"
#include "tests/temporary_folder.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "tests/error_of.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

TEST(InputFile, APointerOfGitLfsIsNotTheFile) {
  const TemporaryFolder temporary;
  const std::string path = (temporary.path() / "model.ply").string();
  const std::string pointer =
      "version https://git-lfs.github.com/spec/v1\noid sha256:" + std::string(64, 'a') +
      "\nsize 123\n";
  const auto check = [&](const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
    return error_of([&] { check_input_file(path, 100); });
  };
  EXPECT_EQ(check(pointer), path +
                                ": a Git LFS pointer in place of the file's content; expected the "
                                "content, which 'git lfs pull' fetches");
  EXPECT_EQ(error_of([&] { read_input_file(path, 10); }), check(pointer));
  EXPECT_EQ(check("version https://git-lfs.github.io/not/that\n"), "no error");
  EXPECT_EQ(check(pointer + std::string(1024, '\n')),
            path + ": the file has 1152 bytes; expected at most 100")
      << "no pointer is as long";
}

/// folder/ with scene.tessera and textures/wood.png, beside it secret.png and folder-2/other.png.
class ResolveInside : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder() / "textures");
    fs::create_directories(top / "folder-2");
    for (const char* name :
         {"folder/scene.tessera", "folder/textures/wood.png", "secret.png", "folder-2/other.png"}) {
      std::ofstream(top / name) << "x";
    }
  }

  fs::path folder() const { return top / "folder"; }
  std::optional<fs::path> resolve(const std::string& reference) const {
    return resolve_inside(folder(), reference);
  }

  const TemporaryFolder temporary;
  const fs::path top = temporary.path();
};

TEST_F(ResolveInside, FindsWhatLiesInTheFolder) {
  EXPECT_EQ(resolve("scene.tessera"), folder() / "scene.tessera");
  EXPECT_EQ(resolve("./textures/wood.png"), folder() / "textures/wood.png");
  EXPECT_EQ(resolve("textures/../scene.tessera"), folder() / "scene.tessera");
  EXPECT_EQ(resolve("not/there/yet.png"), folder() / "not/there/yet.png");
  EXPECT_EQ(resolve("..scene"), folder() / "..scene") << "a name, not the folder above";
}

TEST_F(ResolveInside, LeavesTheFolderByNoName) {
  for (const char* reference :
       {"..", "../secret.png", "textures/../../secret.png", "../folder-2/other.png",
        "nowhere/../../secret.png", "textures/./.././../secret.png", "../../../../etc/passwd"}) {
    EXPECT_FALSE(resolve(reference)) << reference;
  }
  EXPECT_FALSE(resolve("/etc/passwd"));
  EXPECT_FALSE(resolve((folder() / "scene.tessera").string())) << "absolute, though inside";
}

TEST_F(ResolveInside, LeavesTheFolderByNoLink) {
  fs::create_symlink(top / "secret.png", folder() / "file-out");
  fs::create_symlink("..", folder() / "folder-out");
  fs::create_symlink("file-out", folder() / "link-to-link");
  fs::create_symlink("textures", folder() / "folder-in");
  EXPECT_FALSE(resolve("file-out"));
  EXPECT_FALSE(resolve("folder-out/secret.png"));
  EXPECT_FALSE(resolve("folder-out/folder-2/not-there.png"));
  EXPECT_FALSE(resolve("link-to-link"));
  EXPECT_FALSE(resolve("folder-in/../../secret.png"));
  EXPECT_EQ(resolve("folder-in/wood.png"), folder() / "textures/wood.png");
}

TEST_F(ResolveInside, FollowsNoLinkToNothing) {
  fs::create_symlink(top / "not-there-yet", folder() / "dangling-out");
  fs::create_symlink("loop", folder() / "loop");
  // Whoever can make its target later would choose what is read.
  EXPECT_FALSE(resolve("dangling-out"));
  EXPECT_FALSE(resolve("dangling-out/more.png"));
  EXPECT_FALSE(resolve("loop"));
}

TEST_F(ResolveInside, TakesNoNonsense) {
  EXPECT_FALSE(resolve(""));
  EXPECT_FALSE(resolve(std::string("scene.tessera\0.png", 18)));
  EXPECT_FALSE(resolve(std::string(100'000, 'x')));
}

TEST_F(ResolveInside, TheFolderMayItselfBeALink) {
  fs::create_directory_symlink(folder(), top / "alias");
  EXPECT_EQ(resolve_inside(top / "alias", "scene.tessera"), folder() / "scene.tessera");
  EXPECT_FALSE(resolve_inside(top / "alias", "../secret.png"));
}

TEST(WriteOutputFile, LeavesWhatAnotherProcessIsWriting) {
  // In containers and on several machines processes have the same numbers.
  const TemporaryFolder folder;
  const fs::path others = folder.path() / (".tessera-" + std::to_string(getpid()) + ".part");
  std::ofstream(others) << "half a picture";
  write_output_file(folder.path() / "a.txt", "whole");
  EXPECT_EQ(fs::file_size(others), 14u);
  EXPECT_EQ(fs::file_size(folder.path() / "a.txt"), 5u);
}

}  // namespace
}  // namespace tessera
