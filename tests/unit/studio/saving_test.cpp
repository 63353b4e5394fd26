#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "base/file.h"
#include "studio/files/folder.h"
#include "tests/error_of.h"
#include "tests/file_size_limit.h"
#include "tests/temporary_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

class StudioSaving : public testing::Test {
 protected:
  StudioSaving() { write("a.tessera", "old text"); }

  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(place(name), std::ios::binary) << bytes;
  }
  fs::path place(const std::string& name) const { return root_.path() / name; }
  std::string content(const std::string& name) const {
    return read_input_file(place(name).string(), 1 << 20);
  }
  struct stat status(const std::string& name) const {
    struct stat out {};
    EXPECT_EQ(lstat(place(name).c_str(), &out), 0);
    return out;
  }
  size_t files() const {
    return static_cast<size_t>(
        std::distance(fs::directory_iterator(root_.path()), fs::directory_iterator()));
  }
  std::string failure(const std::string& name, const std::string& bytes) const {
    return error_of([&] { folder_.save(name, bytes, std::nullopt); }, ExitCode::render_failed);
  }

  TemporaryFolder root_;
  Folder folder_{root_.path()};
};

TEST_F(StudioSaving, ReplacesWhatWasRead) {
  FileVersion version = folder_.read("a.tessera", 100).version;
  const ino_t before = status("a.tessera").st_ino;
  const SaveResult saved = folder_.save("a.tessera", "new", version);
  EXPECT_EQ(saved.state, FileState::same);
  EXPECT_EQ(saved.version.hash, Digest::of("new"));
  EXPECT_EQ(content("a.tessera"), "new");
  EXPECT_NE(status("a.tessera").st_ino, before);  // not written where it lay
  version = saved.version;
  EXPECT_EQ(folder_.state("a.tessera", version), FileState::same);
  EXPECT_EQ(folder_.save("a.tessera", "", version).state, FileState::same);
  EXPECT_EQ(status("a.tessera").st_size, 0);
  EXPECT_EQ(files(), 1u);
}

TEST_F(StudioSaving, RefusesAFileThatChangedOnDisk) {
  const FileVersion version = folder_.read("a.tessera", 100).version;
  write("a.tessera", "NEW TEXT");  // as long as before
  EXPECT_EQ(folder_.save("a.tessera", "mine", version).state, FileState::changed);
  EXPECT_EQ(content("a.tessera"), "NEW TEXT");
  EXPECT_EQ(folder_.save("a.tessera", "mine", std::nullopt).state, FileState::same);
  EXPECT_EQ(content("a.tessera"), "mine");
  fs::remove(place("a.tessera"));
  EXPECT_EQ(folder_.save("a.tessera", "again", version).state, FileState::deleted);
  EXPECT_EQ(files(), 0u);
  EXPECT_EQ(folder_.save("a.tessera", "again", std::nullopt).state, FileState::same);
  EXPECT_EQ(content("a.tessera"), "again");
}

TEST_F(StudioSaving, KeepsModeOwnerAndAttributes) {
  fs::permissions(place("a.tessera"), fs::perms(0640));
  const bool is_root = geteuid() == 0;
  if (is_root) {
    ASSERT_EQ(chown(place("a.tessera").c_str(), 1234, 4321), 0);
  }
  const bool has_attributes = setxattr(place("a.tessera").c_str(), "user.note", "kept", 4, 0) == 0;
  folder_.save("a.tessera", "new", std::nullopt);
  const struct stat now = status("a.tessera");
  EXPECT_EQ(now.st_mode & 07777, 0640u);
  if (is_root) {
    EXPECT_EQ(now.st_uid, 1234u);
    EXPECT_EQ(now.st_gid, 4321u);
  }
  char value[8] = {};
  if (has_attributes) {
    EXPECT_EQ(getxattr(place("a.tessera").c_str(), "user.note", value, sizeof value), 4);
    EXPECT_STREQ(value, "kept");
  }
}

TEST_F(StudioSaving, ALinkStaysAndItsTargetIsReplaced) {
  fs::create_symlink("a.tessera", place("link.tessera"));
  const FileVersion version = folder_.read("link.tessera", 100).version;
  EXPECT_EQ(folder_.save("link.tessera", "new", version).state, FileState::same);
  EXPECT_TRUE(fs::is_symlink(place("link.tessera")));
  EXPECT_EQ(content("a.tessera"), "new");
}

TEST_F(StudioSaving, HardLinksStayOneFile) {
  fs::create_hard_link(place("a.tessera"), place("b.tessera"));
  const FileVersion version = folder_.read("a.tessera", 100).version;
  const SaveResult saved = folder_.save("a.tessera", "new", version);
  EXPECT_EQ(saved.state, FileState::same);
  EXPECT_EQ(content("b.tessera"), "new");
  EXPECT_EQ(status("a.tessera").st_nlink, 2u);
  EXPECT_EQ(files(), 2u);  // the copy is gone
  folder_.save("b.tessera", "longer than that", std::nullopt);
  EXPECT_EQ(content("a.tessera"), "longer than that");
}

TEST_F(StudioSaving, OnAFullDiskTheOldFileIsWhole) {
  const std::string large(100000, 'x');
  fs::create_hard_link(place("a.tessera"), place("b.tessera"));
  write("c.tessera", "old text");
  {
    const FileSizeLimit limit(5000);
    for (const char* name : {"a.tessera", "c.tessera"})
      EXPECT_EQ(failure(name, large),
                "'" + std::string(name) + "' cannot be written: File too large");
    EXPECT_NE(error_of([&] { folder_.create("d.tessera", large); }, ExitCode::render_failed),
              "no error");
  }
  for (const char* name : {"a.tessera", "b.tessera", "c.tessera"})
    EXPECT_EQ(content(name), "old text");
  EXPECT_EQ(files(), 3u);
}

TEST_F(StudioSaving, WhatCannotBeCopiedIsNotWrittenWhereItLies) {
  // The new text would fit, the copy of the old one does not.
  write("a.tessera", std::string(8000, 'o'));
  fs::create_hard_link(place("a.tessera"), place("b.tessera"));
  {
    const FileSizeLimit limit(5000);
    EXPECT_NE(failure("a.tessera", "short"), "no error");
  }
  EXPECT_EQ(content("a.tessera"), std::string(8000, 'o'));
  EXPECT_EQ(files(), 2u);
}

TEST_F(StudioSaving, ReadOnlyRefusesEveryWrite) {
  const Folder folder(root_.path(), Folder::Access::read_only);
  EXPECT_TRUE(folder.is_read_only());
  EXPECT_EQ(folder.read("a.tessera", 100).bytes, "old text");
  const auto refusal = [](const auto& action) { return error_of(action, ExitCode::render_failed); };
  EXPECT_EQ(refusal([&] { folder.save("a.tessera", "new", std::nullopt); }),
            "'a.tessera' cannot be written: everything is for reading only");
  EXPECT_NE(refusal([&] { folder.create("b.tessera", "new"); }), "no error");
  EXPECT_NE(refusal([&] { folder.start("b.tessera"); }), "no error");
  EXPECT_NE(refusal([&] { folder.make_folder("b"); }), "no error");
  EXPECT_EQ(content("a.tessera"), "old text");
  EXPECT_EQ(files(), 1u);
}

TEST_F(StudioSaving, NewFilesReplaceNothing) {
  EXPECT_EQ(folder_.create("b.tessera", "text").hash, Digest::of("text"));
  EXPECT_EQ(content("b.tessera"), "text");
  EXPECT_EQ(error_of([&] { folder_.create("a.tessera", "x"); }, ExitCode::render_failed),
            "'a.tessera' cannot be written: there is one of that name");
  EXPECT_EQ(error_of([&] { folder_.create("none/a.tessera", "x"); }, ExitCode::render_failed),
            "'none/a.tessera' cannot be written: its folder is not there");
  // One that comes meanwhile.
  NewFile file = folder_.start("c.tessera");
  file.append("mine");
  write("c.tessera", "theirs");
  EXPECT_NE(error_of([&] { file.finish(); }, ExitCode::render_failed), "no error");
  EXPECT_EQ(content("c.tessera"), "theirs");
  EXPECT_EQ(content("a.tessera"), "old text");
}

TEST_F(StudioSaving, AFileThatIsNotFinishedIsNotThere) {
  {
    NewFile file = folder_.start("b.tessera");
    file.append("half");
    NewFile moved = std::move(file);
    moved.append(" of it");
    EXPECT_FALSE(fs::exists(place("b.tessera")));
    EXPECT_EQ(folder_.list().entries.size(), 1u);
  }
  EXPECT_EQ(files(), 1u);
  NewFile file = folder_.start("b.tessera");
  file.append("all ");
  file.append("of it");
  file.finish();
  EXPECT_EQ(content("b.tessera"), "all of it");
  EXPECT_EQ(files(), 2u);
}

TEST_F(StudioSaving, MakesFoldersInThoseThatAreThere) {
  folder_.make_folder("models");
  folder_.create("models/b.obj", "x");
  EXPECT_EQ(content("models/b.obj"), "x");
  EXPECT_NE(error_of([&] { folder_.make_folder("models"); }, ExitCode::render_failed), "no error");
  EXPECT_NE(error_of([&] { folder_.make_folder("x/y"); }, ExitCode::render_failed), "no error");
}

/// Runs `action` in a child, which ends with what it returns.
template <typename Action>
int in_child(const Action& action) {
  const pid_t child = fork();
  if (child == 0) _exit(action());
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_F(StudioSaving, WithoutTheRightTheOldFileIsWhole) {
  if (geteuid() != 0) GTEST_SKIP() << "it takes root to become somebody else";
  fs::permissions(root_.path(), fs::perms(0777));
  chmod(place("a.tessera").c_str(), 0444);
  write("b.tessera", "old text");
  chmod(place("b.tessera").c_str(), 0666);
  const ino_t before = status("b.tessera").st_ino;
  EXPECT_EQ(in_child([&] {
              if (setgid(65534) != 0 || setuid(65534) != 0) return 2;
              const std::string why = failure("a.tessera", "new");
              if (why != "'a.tessera' cannot be written: Permission denied") return 3;
              // Another's file that may be written stays the other's.
              folder_.save("b.tessera", "new", std::nullopt);
              return 0;
            }),
            0);
  EXPECT_EQ(content("a.tessera"), "old text");
  EXPECT_EQ(content("b.tessera"), "new");
  EXPECT_EQ(status("b.tessera").st_uid, 0u);
  EXPECT_EQ(status("b.tessera").st_ino, before);
  EXPECT_EQ(files(), 2u);
  // In a folder that may not be written not even that: there is no place for a copy.
  fs::permissions(root_.path(), fs::perms(0755));
  EXPECT_EQ(in_child([&] {
              if (setgid(65534) != 0 || setuid(65534) != 0) return 2;
              return failure("b.tessera", "newer") == "no error" ? 3 : 0;
            }),
            0);
  EXPECT_EQ(content("b.tessera"), "new");
}

TEST_F(StudioSaving, OnASmallFileSystemTheOldFileIsWhole) {
  const fs::path small = root_.path() / "small";
  fs::create_directory(small);
  if (mount("none", small.c_str(), "tmpfs", 0, "size=64k") != 0)
    GTEST_SKIP() << "no small disk can be mounted here, by root alone: " << std::strerror(errno);
  {
    const Folder folder(small);
    folder.create("a.tessera", std::string(30000, 'o'));
    fs::create_hard_link(small / "a.tessera", small / "b.tessera");
    folder.create("c.tessera", "old");
    for (const char* name : {"a.tessera", "c.tessera"}) {
      EXPECT_EQ(error_of([&] { folder.save(name, std::string(60000, 'n'), std::nullopt); },
                         ExitCode::render_failed),
                "'" + std::string(name) + "' cannot be written: No space left on device");
    }
    EXPECT_EQ(folder.read("b.tessera", 1 << 20).bytes, std::string(30000, 'o'));
    EXPECT_EQ(folder.read("c.tessera", 1 << 20).bytes, "old");
    EXPECT_EQ(std::distance(fs::directory_iterator(small), fs::directory_iterator()), 3);
    ASSERT_EQ(mount("none", small.c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr), 0);
    EXPECT_EQ(
        error_of([&] { folder.save("c.tessera", "new", std::nullopt); }, ExitCode::render_failed),
        "'c.tessera' cannot be written: Read-only file system");
  }
  EXPECT_EQ(umount(small.c_str()), 0);
}

}  // namespace
}  // namespace tessera
