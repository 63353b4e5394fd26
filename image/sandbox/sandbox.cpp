#include "image/sandbox/sandbox.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <linux/sockios.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "base/owned_descriptor.h"

namespace tessera {
namespace {

/// The kernel's landlock_ruleset_attr as of the sixth version; older headers have its beginning.
/// A kernel takes what it does not know where that is zero.
struct LandlockRules {
  uint64_t files = 0, network = 0, scopes = 0;
};

/// How many rights to files the versions 1, 2, ... of Landlock know.
constexpr std::array<int, 5> kFileRights{13, 14, 15, 15, 16};

/// A place that cannot be permitted stays one that cannot be read.
void permit_reading(int rules, const std::filesystem::path& place) {
  const OwnedDescriptor opened(open(place.c_str(), O_PATH | O_CLOEXEC));
  struct stat status {};
  if (opened.get() < 0 || fstat(opened.get(), &status) != 0) return;
  landlock_path_beneath_attr rule{};
  rule.parent_fd = opened.get();
  rule.allowed_access = LANDLOCK_ACCESS_FS_READ_FILE;
  if (S_ISDIR(status.st_mode)) rule.allowed_access |= LANDLOCK_ACCESS_FS_READ_DIR;
  syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
}

bool restrict_files(const std::vector<std::filesystem::path>& readable) {
  const long version =
      syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) return false;
  const auto known = std::min(static_cast<size_t>(version), kFileRights.size());
  LandlockRules wanted{.files = (uint64_t{1} << kFileRights[known - 1]) - 1};
  if (version >= 4) wanted.network = 0b11;  // to bind TCP ports, to connect to them
  if (version >= 6) wanted.scopes = 0b11;   // abstract sockets and signals of processes outside
  const OwnedDescriptor rules(
      static_cast<int>(syscall(SYS_landlock_create_ruleset, &wanted, sizeof wanted, 0)));
  if (rules.get() < 0) return false;
  for (const auto& place : readable) permit_reading(rules.get(), place);
  return syscall(SYS_landlock_restrict_self, rules.get(), 0) == 0;
}

#if defined(__x86_64__)
constexpr uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr uint32_t kArchitecture = 0;
#endif

/// Calls that Debian 12's headers do not know yet, by their numbers, which all processors share:
/// fchmodat2, setxattrat, removexattrat, file_setattr.
constexpr int kFchmodat2 = 452, kSetxattrat = 463, kRemovexattrat = 466, kFileSetattr = 469;

constexpr std::array kRefusedCalls{
    // the network
    SYS_socket, SYS_socketpair, SYS_connect, SYS_bind, SYS_listen, SYS_accept, SYS_accept4,
    // programs and processes; clone() is looked at more closely
    SYS_execve, SYS_execveat,
#ifdef SYS_fork
    SYS_fork, SYS_vfork,
#endif
    SYS_kill, SYS_tkill, SYS_rt_sigqueueinfo, SYS_rt_tgsigqueueinfo, SYS_ptrace,
    SYS_process_vm_readv, SYS_process_vm_writev, SYS_process_madvise, SYS_pidfd_open,
    SYS_pidfd_getfd, SYS_pidfd_send_signal, SYS_kcmp, SYS_unshare, SYS_setns, SYS_setpgid,
    SYS_setsid, SYS_shmget, SYS_msgget, SYS_semget, SYS_mq_open,
    // the file system
    SYS_mkdirat, SYS_mknodat, SYS_unlinkat, SYS_linkat, SYS_symlinkat, SYS_renameat, SYS_renameat2,
    SYS_truncate, SYS_fchmod, SYS_fchmodat, SYS_fchown, SYS_fchownat, SYS_utimensat, SYS_setxattr,
    SYS_lsetxattr, SYS_fsetxattr, SYS_removexattr, SYS_lremovexattr, SYS_fremovexattr, SYS_chroot,
    SYS_pivot_root, SYS_mount, SYS_umount2, SYS_open_tree, SYS_move_mount, SYS_fsopen, SYS_fsmount,
    SYS_mount_setattr, SYS_open_by_handle_at, SYS_fanotify_init, kFchmodat2, kSetxattrat,
    kRemovexattrat, kFileSetattr,
#ifdef __x86_64__
    SYS_mkdir, SYS_mknod, SYS_unlink, SYS_rmdir, SYS_link, SYS_symlink, SYS_rename, SYS_chmod,
    SYS_chown, SYS_lchown, SYS_utime, SYS_utimes, SYS_futimesat,
#endif
    // what goes around these rules, and what a kernel's faults are mostly reached by
    SYS_io_uring_setup, SYS_io_uring_enter, SYS_io_uring_register, SYS_bpf, SYS_perf_event_open,
    SYS_userfaultfd, SYS_add_key, SYS_request_key, SYS_keyctl, SYS_init_module, SYS_finit_module,
    SYS_kexec_load, SYS_reboot, SYS_swapon, SYS_swapoff};

/// Calls refused for one value of their second argument: what types for the user at a terminal, and
/// what has the kernel send signals to other processes.
struct RefusedRequest {
  long call;
  uint32_t request;
};
constexpr std::array<RefusedRequest, 6> kRefusedRequests{{{SYS_ioctl, TIOCSTI},
                                                          {SYS_ioctl, TIOCLINUX},
                                                          {SYS_ioctl, FIOSETOWN},
                                                          {SYS_ioctl, SIOCSPGRP},
                                                          {SYS_fcntl, F_SETOWN},
                                                          {SYS_fcntl, F_SETOWN_EX}}};

constexpr sock_filter load(size_t offset) {
  return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<uint32_t>(offset));
}

/// Skips the instruction that follows unless the loaded word is `value`.
constexpr sock_filter unless_equal_skip(uint32_t value) {
  return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1);
}

constexpr sock_filter give(uint32_t verdict) { return BPF_STMT(BPF_RET | BPF_K, verdict); }

constexpr sock_filter refuse(int error) {
  return give(SECCOMP_RET_ERRNO | static_cast<uint32_t>(error));
}

std::vector<sock_filter> call_filter() {
  std::vector<sock_filter> filter{load(offsetof(seccomp_data, arch)),
                                  BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0),
                                  refuse(EPERM), load(offsetof(seccomp_data, nr))};
#ifdef __x86_64__
  // The calls of x32, which have numbers of their own.
  filter.insert(filter.end(),
                {BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, 0x40000000, 0, 1), refuse(EPERM)});
#endif
  for (const long call : kRefusedCalls) {
    filter.insert(filter.end(), {unless_equal_skip(static_cast<uint32_t>(call)), refuse(EPERM)});
  }
  // A filter cannot see the flags of clone3(). Without it the C library takes clone(), whose flags
  // have to be those of a thread.
  filter.insert(filter.end(), {unless_equal_skip(SYS_clone3), refuse(ENOSYS)});
  // Of arguments the lower halves, which are first in memory.
  constexpr size_t kFirstArgument = offsetof(seccomp_data, args);
  constexpr size_t kSecondArgument = kFirstArgument + sizeof(uint64_t);
  for (const RefusedRequest& refused : kRefusedRequests) {
    filter.insert(filter.end(),
                  {BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<uint32_t>(refused.call), 0, 4),
                   load(kSecondArgument), unless_equal_skip(refused.request), refuse(EPERM),
                   load(offsetof(seccomp_data, nr))});
  }
  constexpr uint32_t kHas = BPF_JSET, kIs = BPF_JEQ;
  const auto permit_only = [&](uint32_t call, uint32_t relation, uint32_t value) {
    filter.insert(filter.end(),
                  {BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 4), load(kFirstArgument),
                   BPF_JUMP(BPF_JMP | BPF_K | relation, value, 1, 0), refuse(EPERM),
                   give(SECCOMP_RET_ALLOW)});
  };
  permit_only(SYS_clone, kHas, CLONE_THREAD);
  permit_only(SYS_tgkill, kIs, static_cast<uint32_t>(getpid()));  // as abort() sends it
  permit_only(SYS_prlimit64, kIs, 0);                             // limits of this process
  filter.push_back(give(SECCOMP_RET_ALLOW));
  return filter;
}

bool restrict_calls() {
  if (kArchitecture == 0) return false;
  std::vector<sock_filter> filter = call_filter();
  const sock_fprog program{.len = static_cast<unsigned short>(filter.size()),
                           .filter = filter.data()};
  // Older kernels would slow the process down, to hide memory that a sandboxed decoder may know.
  return syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_SPEC_ALLOW, &program) ==
         0;
}

}  // namespace

Sandbox enter_sandbox(const std::vector<std::filesystem::path>& readable) {
  // Without it neither is for processes without privileges.
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return {};
  const bool holds_files = restrict_files(readable);
  return {holds_files, restrict_calls()};
}

std::vector<std::filesystem::path> library_places() {
  std::vector<std::filesystem::path> places{
      "/lib",           "/lib64",           "/usr/lib",        "/usr/lib64",
      "/usr/local/lib", "/usr/local/lib64", "/etc/ld.so.cache"};
  const char* const named = std::getenv("LD_LIBRARY_PATH");
  std::string_view rest = named ? named : "";
  while (!rest.empty()) {
    const size_t end = std::min(rest.find_first_of(":;"), rest.size());
    if (end > 0) places.emplace_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return places;
}

}  // namespace tessera
