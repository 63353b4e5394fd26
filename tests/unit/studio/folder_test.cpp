#include "studio/files/folder.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "base/file.h"
#include "base/open_beneath.h"
#include "tests/error_of.h"
#include "tests/temporary_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

std::vector<std::string> names(const FileList& list) {
  std::vector<std::string> out;
  for (const FileEntry& entry : list.entries) out.push_back(entry.name);
  return out;
}

/// A folder with a file beside it that nobody may reach.
class StudioFolder : public testing::Test {
 protected:
  StudioFolder() {
    write(outer_.path() / "secret.tessera", "secret");
    write(root_ / "a.tessera", "scene");
    write(root_ / "sub/b.obj", "model");
  }

  std::string refusal(const std::string& name) const {
    return error_of([&] { folder().read(name, 100); });
  }
  std::string write_refusal(const std::string& name) const {
    std::string why;
    for (const ExitCode code : {ExitCode::bad_scene, ExitCode::render_failed}) {
      try {
        folder().save(name, "x", std::nullopt);
        return "no error";
      } catch (const Error& error) {
        if (error.code() == code) why = error.what();
      }
    }
    return why;
  }
  Folder folder() const { return Folder(root_); }

  TemporaryFolder outer_;
  fs::path root_ = outer_.path() / "root";
};

TEST_F(StudioFolder, ListsWhatIsReadByKind) {
  for (const char* name :
       {"c.CRT", "d.x3d.gz", "e.glb", "e.mtl", "f.JPG", "notes.txt", "g.gz", ".hidden.crt",
        ".git/h.crt", "sub/deep/i.png", "text/j.txt", "z", "sub.tessera"})
    write(root_ / name, "12");
  fs::create_directories(root_ / "new");
  const FileList list = folder().list();
  EXPECT_FALSE(list.is_truncated);
  const std::vector<FileEntry> expected{{"a.tessera", FileKind::scene, 5},
                                        {"c.CRT", FileKind::scene, 2},
                                        {"d.x3d.gz", FileKind::scene, 2},
                                        {"e.glb", FileKind::model, 2},
                                        {"e.mtl", FileKind::model, 2},
                                        {"f.JPG", FileKind::picture, 2},
                                        {"new", FileKind::folder, 0},
                                        {"sub", FileKind::folder, 0},
                                        {"sub/b.obj", FileKind::model, 5},
                                        {"sub/deep", FileKind::folder, 0},
                                        {"sub/deep/i.png", FileKind::picture, 2},
                                        {"sub.tessera", FileKind::scene, 2}};
  EXPECT_EQ(list.entries, expected);
}

TEST_F(StudioFolder, ListsWhereLinksLeadAndNeverOut) {
  fs::create_directory_symlink(root_ / "sub", root_ / "linked");
  fs::create_symlink("a.tessera", root_ / "again.tessera");
  fs::create_symlink(outer_.path() / "secret.tessera", root_ / "out.tessera");
  fs::create_directory_symlink(outer_.path(), root_ / "outer");
  fs::create_directory_symlink("..", root_ / "sub/up");
  fs::create_directory_symlink(".", root_ / "sub/self");
  fs::create_symlink("nothing.crt", root_ / "broken.crt");
  write(root_ / ".git/x.crt", "");
  fs::create_symlink(".git/x.crt", root_ / "hidden.crt");
  mkfifo((root_ / "fifo.crt").c_str(), 0600);
  EXPECT_EQ(names(folder().list()),
            (std::vector<std::string>{"a.tessera", "again.tessera", "linked", "linked/b.obj", "sub",
                                      "sub/b.obj"}));
}

TEST_F(StudioFolder, ListsSoManyAndSoDeep) {
  std::string deep = "d1";
  for (int i = 2; i < Folder::kMostDepth; ++i) deep += "/d" + std::to_string(i);
  write(root_ / deep / "8.crt", "");
  EXPECT_FALSE(folder().list().is_truncated);
  write(root_ / deep / "d8/9.crt", "");
  const FileList too_deep = folder().list();
  EXPECT_TRUE(too_deep.is_truncated);
  const auto found = names(too_deep);
  EXPECT_NE(std::find(found.begin(), found.end(), deep + "/8.crt"), found.end());
  EXPECT_EQ(std::find(found.begin(), found.end(), deep + "/d8/9.crt"), found.end());

  fs::remove_all(root_ / "d1");
  for (size_t i = 0; i < Folder::kMostEntries; ++i)
    write(root_ / "many" / (std::to_string(i) + ".crt"), "");
  const FileList too_many = folder().list();
  EXPECT_TRUE(too_many.is_truncated);
  EXPECT_EQ(too_many.entries.size(), Folder::kMostEntries);
  // What is near the top stays.
  EXPECT_EQ(too_many.entries.front().name, "a.tessera");
}

TEST_F(StudioFolder, ReadsAFileOrItsBeginning) {
  const FileContent whole = folder().read("sub/b.obj", 5);
  EXPECT_EQ(whole.bytes, "model");
  EXPECT_TRUE(whole.is_whole);
  EXPECT_EQ(whole.version.hash, Digest::of("model"));
  const FileContent head = folder().read("sub/b.obj", 4);
  EXPECT_EQ(head.bytes, "mode");
  EXPECT_FALSE(head.is_whole);
  EXPECT_EQ(head.size, 5u);
  FileVersion version = head.version;
  EXPECT_EQ(folder().state("sub/b.obj", version), FileState::same);
  write(root_ / "sub/b.obj", "longer model");
  EXPECT_EQ(folder().state("sub/b.obj", version), FileState::changed);
}

TEST_F(StudioFolder, RefusesHostileNames) {
  write(root_ / ".hidden.tessera", "hidden");
  write(root_ / ".git/config.crt", "hidden");
  const std::string long_part(256, 'x');
  for (const std::string& name :
       {std::string(), std::string("../secret.tessera"), std::string("sub/../../secret.tessera"),
        std::string("sub/../a.tessera"), std::string("./a.tessera"), std::string("sub//b.obj"),
        std::string("sub/"), std::string("/etc/passwd"),
        (outer_.path() / "secret.tessera").string(), std::string(".hidden.tessera"),
        std::string(".git/config.crt"), std::string("."), std::string(".."),
        std::string("a.tessera\0.png", 14), std::string("a\nb.tessera"), std::string("caf\xE9.crt"),
        long_part + ".crt", std::string(1025, 'a')}) {
    EXPECT_NE(refusal(name), "no error") << name;
    EXPECT_NE(write_refusal(name), "no error") << name;
    FileVersion version;
    EXPECT_THROW(folder().state(name, version), Error) << name;
    EXPECT_THROW(folder().make_folder(name), Error) << name;
  }
  EXPECT_EQ(read_input_file(outer_ / "secret.tessera", 100), "secret");
}

TEST_F(StudioFolder, FollowsLinksThatStayInside) {
  fs::create_symlink("sub/b.obj", root_ / "near.obj");
  fs::create_symlink(root_ / "sub/b.obj", root_ / "absolute.obj");
  fs::create_directory_symlink("sub", root_ / "dir");
  for (const char* name : {"near.obj", "absolute.obj", "dir/b.obj"}) {
    EXPECT_EQ(folder().read(name, 100).bytes, "model") << name;
    EXPECT_EQ(folder().canonical(name), "sub/b.obj") << name;
  }
}

TEST_F(StudioFolder, RefusesLinksThatLeadOutOrToHiddenFiles) {
  write(root_ / ".git/x.crt", "hidden");
  fs::create_symlink("../secret.tessera", root_ / "out.tessera");
  fs::create_symlink(outer_.path() / "secret.tessera", root_ / "absolute.tessera");
  fs::create_directory_symlink(outer_.path(), root_ / "outer");
  fs::create_symlink(".git/x.crt", root_ / "hidden.crt");
  fs::create_symlink("nothing.crt", root_ / "broken.crt");
  fs::create_symlink("loop.crt", root_ / "loop.crt");
  fs::create_symlink("/proc/self/root/etc/passwd", root_ / "magic.crt");
  for (const char* name : {"out.tessera", "absolute.tessera", "outer/secret.tessera", "hidden.crt",
                           "broken.crt", "loop.crt", "magic.crt"}) {
    EXPECT_NE(refusal(name), "no error") << name;
    EXPECT_NE(write_refusal(name), "no error") << name;
  }
  EXPECT_EQ(read_input_file(outer_ / "secret.tessera", 100), "secret");
  EXPECT_FALSE(fs::exists(root_ / "nothing.crt"));
}

TEST_F(StudioFolder, RefusesWhatIsNoRegularFile) {
  ASSERT_EQ(mkfifo((root_ / "fifo.crt").c_str(), 0600), 0);
  const int socket_ = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  (root_ / "socket.crt").string().copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  mknod((root_ / "device.crt").c_str(), S_IFCHR | 0600, makedev(1, 5));  // root alone can
  for (const char* name : {"fifo.crt", "socket.crt", "device.crt", "sub"}) {
    EXPECT_NE(refusal(name), "no error") << name;
    EXPECT_NE(write_refusal(name), "no error") << name;
  }
  EXPECT_EQ(refusal("fifo.crt"), "'fifo.crt' cannot be read: it is no regular file");
  EXPECT_EQ(refusal("missing/x.crt"), "'missing/x.crt' cannot be read: No such file or directory");
  close(socket_);
}

TEST_F(StudioFolder, ALinkThatIsPutThereAfterTheCheckLeadsNowhere) {
  const OwnedDescriptor root(open(root_.c_str(), O_PATH | O_DIRECTORY));
  fs::create_symlink("../secret.tessera", root_ / "link.tessera");
  fs::create_symlink("a.tessera", root_ / "inner.tessera");
  fs::create_directory_symlink("..", root_ / "up");
  fs::create_directory_symlink("sub", root_ / "dir");
  for (const auto& opens : {open_beneath, open_beneath_by_steps}) {
    EXPECT_GE(opens(root.get(), "a.tessera", O_RDONLY).get(), 0);
    EXPECT_GE(opens(root.get(), "sub/b.obj", O_RDONLY).get(), 0);
    EXPECT_GE(opens(root.get(), "sub/b.obj", O_PATH).get(), 0);
    EXPECT_GE(opens(root.get(), "sub", O_RDONLY | O_DIRECTORY).get(), 0);
    EXPECT_GE(opens(root.get(), "", O_RDONLY | O_DIRECTORY).get(), 0);
    for (const char* path :
         {"link.tessera", "inner.tessera", "up/secret.tessera", "dir/b.obj", "up", "..",
          "../secret.tessera", "sub/../../secret.tessera", "/etc/passwd"}) {
      EXPECT_LT(opens(root.get(), path, O_RDONLY).get(), 0) << path;
      EXPECT_LT(opens(root.get(), path, O_PATH).get(), 0) << path;
    }
  }
}

TEST_F(StudioFolder, LinksThatAreSwappedMeanwhileNeverLeadOut) {
  fs::create_directory(root_ / "flip");
  write(root_ / "flip/secret.tessera", "inside");
  const fs::path flip = root_ / "flip", aside = root_ / "aside", link = root_ / "link";
  fs::create_directory_symlink(outer_.path(), link);
  std::atomic<bool> ends{false};
  std::thread swapper([&] {
    while (!ends) renameat2(AT_FDCWD, flip.c_str(), AT_FDCWD, link.c_str(), RENAME_EXCHANGE);
  });
  int inside = 0, refused = 0;
  for (int i = 0; i < 20000 && (i < 500 || inside == 0 || refused == 0); ++i) {
    try {
      EXPECT_EQ(folder().read("flip/secret.tessera", 100).bytes, "inside");
      ++inside;
      folder().save("flip/secret.tessera", "inside", std::nullopt);
    } catch (const Error&) {
      ++refused;
    }
  }
  ends = true;
  swapper.join();
  EXPECT_GT(inside, 0);
  EXPECT_GT(refused, 0);
  EXPECT_EQ(read_input_file(outer_ / "secret.tessera", 100), "secret");
  for (const auto& entry : fs::directory_iterator(outer_.path()))
    EXPECT_FALSE(is_unfinished_output(entry.path().filename().string()));
}

TEST_F(StudioFolder, IsNoFileAndMustBeThere) {
  usage_error_of([&] { Folder(root_ / "a.tessera"); });
  EXPECT_NE(usage_error_of([&] { Folder(root_ / "a.tessera"); }), "no error");
  EXPECT_NE(usage_error_of([&] { Folder(root_ / "none"); }), "no error");
}

TEST_F(StudioFolder, OutlastsItsPathBeingMadeAnew) {
  const Folder opened = folder();
  fs::remove_all(root_);
  EXPECT_NE(error_of([&] { opened.read("a.tessera", 10); }), "no error");
  EXPECT_TRUE(opened.list().entries.empty());
  write(root_ / "a.tessera", "new");
  EXPECT_EQ(opened.read("a.tessera", 10).bytes, "new");
}

TEST_F(StudioFolder, TellsSameChangedAndDeleted) {
  FileVersion version = folder().read("a.tessera", 100).version;
  EXPECT_EQ(folder().state("a.tessera", version), FileState::same);
  // Written anew with what was in it.
  write(root_ / "a.tessera", "scene");
  EXPECT_EQ(folder().state("a.tessera", version), FileState::same);
  write(root_ / "a.tessera", "SCENE");
  EXPECT_EQ(folder().state("a.tessera", version), FileState::changed);
  FileVersion by_hash{Digest::of("SCENE"), {}};
  EXPECT_EQ(folder().state("a.tessera", by_hash), FileState::same);
  fs::remove(root_ / "a.tessera");
  EXPECT_EQ(folder().state("a.tessera", version), FileState::deleted);
  fs::remove_all(root_ / "sub");
  EXPECT_EQ(folder().state("sub/b.obj", version), FileState::deleted);
  fs::create_directory(root_ / "a.tessera");
  EXPECT_EQ(folder().state("a.tessera", version), FileState::changed);
}

TEST_F(StudioFolder, AnOldStampSparesReading) {
  const timespec old[2]{{1000, 0}, {1000, 0}};
  ASSERT_EQ(utimensat(AT_FDCWD, (root_ / "a.tessera").c_str(), old, 0), 0);
  FileVersion version = folder().read("a.tessera", 100).version;
  // Just now its inode was changed: its times prove nothing.
  EXPECT_FALSE(version.stamp.is_proof);
  version.stamp.is_proof = true;
  FileStamp now = version.stamp;
  EXPECT_TRUE(now.proves_same_as(version.stamp));
  now.changed += 1;
  EXPECT_FALSE(now.proves_same_as(version.stamp));
}

}  // namespace
}  // namespace tessera
