#include "image/sandbox/sandbox.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <thread>

#include "tests/temporary_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// What became of a system call: 0, or why it failed.
int outcome(long result) { return result < 0 ? errno : 0; }

/// The exit code of `work` in a process of its own, in a sandbox where `readable` can be read.
int in_sandbox(const std::vector<fs::path>& readable, const std::function<int()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    enter_sandbox(readable);
    _exit(work());
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status)) << status;
  return WEXITSTATUS(status);
}

bool kernel_has_landlock() {
  return syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) > 0;
}

class SandboxTest : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* folder : {"inside", "outside"}) {
      fs::create_directory(temporary_.path() / folder);
      std::ofstream(temporary_.path() / folder / "file") << "text";
    }
  }

  const TemporaryFolder temporary_;
  const fs::path inside_ = temporary_.path() / "inside", outside_ = temporary_.path() / "outside";
};

TEST_F(SandboxTest, says_what_holds) {
  const int held = in_sandbox({}, [] {
    const Sandbox again = enter_sandbox({});
    return (again.holds_files ? 1 : 0) | (again.holds_calls ? 2 : 0);
  });
  EXPECT_EQ(held, kernel_has_landlock() ? 3 : 2);
}

/// Fails from now on with ENOSYS, as in a kernel without it.
void lose_call(long call) {
  sock_filter filter[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<uint32_t>(call), 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog program{.len = std::size(filter), .filter = filter};
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
}

TEST_F(SandboxTest, each_half_holds_without_the_other) {
  for (const long lost : {SYS_landlock_create_ruleset, SYS_seccomp}) {
    const pid_t child = fork();
    if (child == 0) {
      lose_call(lost);
      const Sandbox sandbox = enter_sandbox({});
      const bool opens = open("/etc/passwd", O_RDONLY) >= 0;
      const bool connects = socket(AF_INET, SOCK_STREAM, 0) >= 0;
      _exit((sandbox.holds_files ? 1 : 0) | (sandbox.holds_calls ? 2 : 0) | (opens ? 4 : 0) |
            (connects ? 8 : 0));
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    const int only_files = kernel_has_landlock() ? 1 | 8 : 4 | 8;
    EXPECT_EQ(WEXITSTATUS(status), lost == SYS_seccomp ? only_files : 2 | 4);
  }
}

TEST_F(SandboxTest, only_the_named_files_are_read) {
  if (!kernel_has_landlock()) GTEST_SKIP() << "this kernel has no Landlock";
  const auto opened = [](const fs::path& file, int how) {
    return [file, how] { return outcome(open(file.c_str(), how, 0600)); };
  };
  EXPECT_EQ(in_sandbox({inside_}, opened(inside_ / "file", O_RDONLY)), 0);
  EXPECT_EQ(in_sandbox({inside_ / "file"}, opened(inside_ / "file", O_RDONLY)), 0);
  EXPECT_EQ(in_sandbox({inside_, "/nowhere"}, opened(outside_ / "file", O_RDONLY)), EACCES);
  EXPECT_EQ(in_sandbox({inside_}, opened(outside_, O_RDONLY | O_DIRECTORY)), EACCES);
  EXPECT_EQ(in_sandbox({}, opened("/etc/passwd", O_RDONLY)), EACCES);
  EXPECT_EQ(in_sandbox(library_places(), opened("/etc/passwd", O_RDONLY)), EACCES);
  EXPECT_EQ(in_sandbox({}, opened("/proc/self/environ", O_RDONLY)), EACCES);
}

TEST_F(SandboxTest, no_file_is_changed) {
  if (!kernel_has_landlock()) GTEST_SKIP() << "this kernel has no Landlock";
  for (const int how : {O_WRONLY, O_RDWR, O_WRONLY | O_TRUNC}) {
    EXPECT_EQ(in_sandbox({"/"}, [&] { return outcome(open((inside_ / "file").c_str(), how)); }),
              EACCES);
  }
  EXPECT_EQ(in_sandbox(
                {"/"},
                [&] { return outcome(open((inside_ / "new").c_str(), O_WRONLY | O_CREAT, 0600)); }),
            EACCES);
  EXPECT_EQ(fs::file_size(inside_ / "file"), 4u);
  EXPECT_FALSE(fs::exists(inside_ / "new"));
}

TEST_F(SandboxTest, calls_beyond_memory_and_threads_are_refused) {
  const std::string file = inside_ / "file", other = inside_ / "other";
  char* const nothing[] = {nullptr};
  const std::pair<const char*, std::function<long()>> calls[] = {
      {"socket", [] { return socket(AF_INET, SOCK_STREAM, 0); }},
      {"unix socket", [] { return socket(AF_UNIX, SOCK_STREAM, 0); }},
      {"connect", [] { return connect(0, nullptr, 0); }},
      {"fork", [] { return fork(); }},
      {"clone", [] { return syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0); }},
      {"execve", [&] { return execve("/bin/true", nothing, nothing); }},
      {"kill", [] { return kill(getppid(), 0); }},
      {"tgkill", [] { return syscall(SYS_tgkill, getppid(), getppid(), 0); }},
      {"prlimit", [] { return prlimit(getppid(), RLIMIT_NOFILE, nullptr, nullptr); }},
      {"shmget", [] { return shmget(IPC_PRIVATE, 1, 0600); }},
      {"typing", [] { return ioctl(memfd_create("memory", 0), TIOCSTI, "x"); }},
      {"signals by the kernel", [] { return fcntl(memfd_create("a", 0), F_SETOWN, getppid()); }},
      {"unlink", [&] { return unlink(file.c_str()); }},
      {"rename", [&] { return rename(file.c_str(), other.c_str()); }},
      {"chmod", [&] { return chmod(file.c_str(), 0); }},
      {"truncate", [&] { return truncate(file.c_str(), 0); }},
      {"symlink", [&] { return symlink("/etc/passwd", other.c_str()); }},
      {"io_uring", [] { return syscall(SYS_io_uring_setup, 1, nullptr); }},
  };
  for (const auto& [name, call] : calls) {
    EXPECT_EQ(in_sandbox({"/"}, [&call = call] { return outcome(call()); }), EPERM) << name;
  }
  EXPECT_EQ(fs::file_size(file), 4u);
}

TEST_F(SandboxTest, memory_and_threads_and_open_sockets_stay) {
  int ends[2];
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  const int done = in_sandbox({}, [&] {
    int found = 0;
    std::thread([&found] { found = open("/etc/passwd", O_RDONLY) < 0 ? errno : 0; }).join();
    if (kernel_has_landlock() && found != EACCES) return 1;
    const int memory = memfd_create("memory", MFD_CLOEXEC);
    if (write(memory, "abc", 3) != 3) return 2;
    const std::string path = "/proc/self/fd/" + std::to_string(memory);
    for (const int how : {O_RDONLY, O_RDWR | O_CREAT | O_TRUNC}) {
      if (open(path.c_str(), how, 0600) < 0) return 3;
    }
    if (send(ends[1], "x", 1, 0) != 1) return 4;
    return 0;
  });
  EXPECT_EQ(done, 0);
  char byte = 0;
  EXPECT_EQ(recv(ends[0], &byte, 1, MSG_DONTWAIT), 1);
  close(ends[0]);
  close(ends[1]);
}

TEST_F(SandboxTest, a_process_can_still_abort) {
  const pid_t child = fork();
  if (child == 0) {
    enter_sandbox({});
    std::signal(SIGABRT, SIG_DFL);
    std::abort();
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGABRT);
}

}  // namespace
}  // namespace tessera
