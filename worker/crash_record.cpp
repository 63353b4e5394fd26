#include "worker/crash_record.h"

#include <errno.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "base/error.h"
#include "base/process.h"

namespace tessera {
namespace {

constexpr uint64_t kMagic = 0x3164726f63657243;
constexpr size_t kThreads = 1024;
constexpr size_t kFrameIdBytes = 16;
// Beyond these the oldest are forgotten, and may crash the worker once more.
constexpr uint32_t kFramesKept = 1024;
// Of threads that have no number: one that may help to build, and the one that serves the socket.
constexpr int kSomeThread = -1, kSocketThread = -2;
constexpr std::array kCrashes = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS};

using Activity = CrashRecord::Activity;

static_assert(std::atomic<uint32_t>::is_always_lock_free, "they are used in a signal handler");

}  // namespace

/// All of it may be written by a program that goes wrong, and is read as such.
struct CrashRecord::Shared {
  using FrameId = std::array<char, kFrameIdBytes>;
  struct Thread {
    std::atomic<Activity> activity;
    FrameId frame;
  };
  struct CrashedFrame {
    FrameId frame;
    int signal;
  };

  uint64_t magic;
  std::atomic<int> signal;     ///< of the crash; 0: there was none since the program was started
  std::atomic<int> thread;     ///< that crashed: its number, or one of those below
  std::atomic<uint32_t> vain;  ///< crashes since a tile was traced
  std::array<Thread, kThreads> threads;
  uint32_t frames_noted;  ///< the last kFramesKept of them are here
  std::array<CrashedFrame, kFramesKept> frames;
};

namespace {

/// What the handler needs, made before.
struct Restart {
  CrashRecord::Shared* shared = nullptr;
  int file = -1;
  const std::atomic<bool>* stop = nullptr;
  sigset_t mask{};
  std::vector<std::string> arguments{};
  std::vector<char*> pointers{};  ///< to them, and null
};
Restart* restart = nullptr;
std::atomic_flag crashed = ATOMIC_FLAG_INIT;
thread_local int own_thread = kSomeThread;

/// Uses nothing but what a signal handler may. It returns only where the process is to end by the
/// signal: what crashed crashes again, and then nobody handles that.
void on_crash(int signal) {
  // Of several threads that crash one goes on; the others end with the program.
  while (crashed.test_and_set()) pause();
  struct sigaction by_default {};
  by_default.sa_handler = SIG_DFL;
  // From here on a request to end does that, rather than set a flag that nobody will read.
  for (const int each : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now {};
    if (sigaction(each, nullptr, &now) == 0 && now.sa_handler == SIG_IGN) continue;
    sigaction(each, &by_default, nullptr);
  }
  if (!*restart->stop) {
    restart->shared->signal = signal;
    restart->shared->thread = own_thread;
    fcntl(restart->file, F_SETFD, 0);
    sigprocmask(SIG_SETMASK, &restart->mask, nullptr);
    execve("/proc/self/exe", restart->pointers.data(), environ);
  }
  sigaction(signal, &by_default, nullptr);
  raise(signal);
}

std::vector<std::string> own_arguments() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> arguments;
  for (std::string argument; std::getline(file, argument, '\0');) arguments.push_back(argument);
  return arguments;
}

}  // namespace

CrashRecord::CrashRecord() : file_(memfd_create("tessera-crashes", MFD_CLOEXEC)) {
  if (file_.get() < 0 || ftruncate(file_.get(), sizeof(Shared)) != 0) {
    throw render_error(fmt::format("no shared memory can be had: {}", std::strerror(errno)));
  }
  map();
  shared_->magic = kMagic;
}

CrashRecord::CrashRecord(int descriptor) {
  struct stat status {};
  if (fstat(descriptor, &status) != 0 || status.st_size != sizeof(Shared) ||
      fcntl(descriptor, F_SETFD, FD_CLOEXEC) != 0) {
    throw usage_error("--crash-record: no descriptor of a record; expected none");
  }
  file_ = OwnedDescriptor(descriptor);
  map();
  if (shared_->magic != kMagic) throw usage_error("--crash-record: damaged; expected a record");
  take_up_crash();
}

CrashRecord::~CrashRecord() {
  if (shared_) munmap(shared_, sizeof(Shared));
}

void CrashRecord::map() {
  void* const memory =
      mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED, file_.get(), 0);
  if (memory == MAP_FAILED) {
    throw render_error(fmt::format("out of memory: {}", std::strerror(errno)));
  }
  shared_ = static_cast<Shared*>(memory);
}

void CrashRecord::take_up_crash() {
  const int signal = shared_->signal.exchange(0);
  if (signal == 0) return;
  ++shared_->vain;
  const int number = shared_->thread;
  const bool is_known = number >= 0 && number < static_cast<int>(kThreads);
  const Activity last =
      is_known ? shared_->threads[static_cast<size_t>(number)].activity.load() : Activity::none;
  // A thread that traces crashes by what it traces; another may help any of those that build.
  const bool may_build = last != Activity::trace && number != kSocketThread;
  size_t built = 0;
  for (Shared::Thread& thread : shared_->threads) {
    if (thread.activity.exchange(Activity::none) != Activity::build) continue;
    if (!may_build) continue;
    shared_->frames[shared_->frames_noted++ % kFramesKept] = {thread.frame, signal};
    ++built;
  }
  last_crash_ = fmt::format("{} while it {}", name_of_signal(signal),
                            last == Activity::trace ? "traced a tile"
                            : built > 0             ? "built a scene, which it builds no more"
                                                    : "neither built a scene nor traced a tile");
}

uint32_t CrashRecord::crashes_in_vain() const { return shared_->vain; }

CrashedFrames CrashRecord::crashed_frames() const {
  CrashedFrames frames;
  for (uint32_t i = 0; i < std::min(shared_->frames_noted, kFramesKept); ++i) {
    const Shared::CrashedFrame& each = shared_->frames[i];
    frames[std::string(each.frame.begin(), each.frame.end())] = each.signal;
  }
  return frames;
}

void CrashRecord::start_anew_after_crashes(const std::atomic<bool>& stop) {
  // As it was called at first: started by another name, it would be called after that.
  prctl(PR_SET_NAME, program_invocation_short_name);
  own_thread = kSocketThread;
  static Restart made;
  made.shared = shared_;
  made.file = file_.get();
  made.stop = &stop;
  pthread_sigmask(SIG_SETMASK, nullptr, &made.mask);
  made.arguments = own_arguments();
  const std::array added = {std::string("--crash-record"), std::to_string(file_.get())};
  // Started anew, it has these already.
  if (std::search(made.arguments.begin(), made.arguments.end(), added.begin(), added.end()) ==
      made.arguments.end()) {
    made.arguments.insert(made.arguments.end(), added.begin(), added.end());
  }
  for (std::string& argument : made.arguments) made.pointers.push_back(argument.data());
  made.pointers.push_back(nullptr);
  restart = &made;
  struct sigaction action {};
  action.sa_handler = on_crash;
  action.sa_flags = SA_ONSTACK;
  sigfillset(&action.sa_mask);
  for (const int signal : kCrashes) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if ((before.sa_flags & SA_SIGINFO) == 0 && before.sa_handler == SIG_DFL) {
      sigaction(signal, &action, nullptr);
    }
  }
}

CrashRecord::Note::Note(CrashRecord* record, int thread, Activity activity,
                        const std::string& frame_id)
    : record_(record), thread_(thread) {
  const bool fits =
      thread >= 0 && thread < static_cast<int>(kThreads) && frame_id.size() == kFrameIdBytes;
  if (!fits) record_ = nullptr;
  if (!record_) return;
  own_thread = thread;
  Shared::Thread& state = record_->shared_->threads[static_cast<size_t>(thread)];
  std::copy(frame_id.begin(), frame_id.end(), state.frame.begin());
  state.activity = activity;
}

CrashRecord::Note::~Note() {
  if (!record_) return;
  record_->shared_->threads[static_cast<size_t>(thread_)].activity = Activity::none;
}

void CrashRecord::note_traced() {
  if (shared_->vain != 0) shared_->vain = 0;
}

}  // namespace tessera
