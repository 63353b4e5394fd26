#include "base/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "base/error.h"

namespace tessera {
namespace {

class SpawnSettings {
 public:
  explicit SpawnSettings(const ProcessStreams& streams) {
    posix_spawn_file_actions_init(&actions_);
    if (streams.standard_input >= 0) {
      posix_spawn_file_actions_adddup2(&actions_, streams.standard_input, STDIN_FILENO);
    } else {
      posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    }
    if (streams.standard_output >= 0) {
      posix_spawn_file_actions_adddup2(&actions_, streams.standard_output, STDOUT_FILENO);
    } else if (streams.discards_output) {
      posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    }
    posix_spawnattr_init(&attributes_);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setpgroup(&attributes_, 0);
    constexpr int kFlags = POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP;
    posix_spawnattr_setflags(&attributes_, kFlags);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  const posix_spawn_file_actions_t* actions() const { return &actions_; }
  const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

}  // namespace

pid_t start_process(const std::string& program, std::vector<std::string> arguments,
                    const ProcessStreams& streams) {
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  const SpawnSettings settings(streams);
  pid_t process = 0;
  const int failure = posix_spawnp(&process, program.c_str(), settings.actions(),
                                   settings.attributes(), pointers.data(), environ);
  if (failure != 0) {
    throw render_error(fmt::format("'{}' cannot be started: {}", program, std::strerror(failure)));
  }
  return process;
}

void check_room_for_threads(int count) {
  constexpr size_t kHeap = size_t{1} << 20;  // of each, for what it works with
  pthread_attr_t attributes;
  size_t stack = 0;
  pthread_attr_init(&attributes);
  pthread_attr_getstacksize(&attributes, &stack);
  pthread_attr_destroy(&attributes);
  const size_t needed = static_cast<size_t>(count) * (stack + kHeap);
  void* const room = mmap(nullptr, needed, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (room == MAP_FAILED) {
    throw render_error(fmt::format("out of memory: {} threads need {} MB of addresses (ulimit -v)",
                                   count, needed >> 20));
  }
  munmap(room, needed);
}

void lower_priority(int nice) {
  // Between 0 and 19 it cannot fail, and more is taken for 19.
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + std::max(nice, 0));
}

int wait_for_process(pid_t process) {
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

std::string how_it_ended(int status) {
  if (!WIFSIGNALED(status)) return fmt::format("exit code {}", WEXITSTATUS(status));
  return name_of_signal(WTERMSIG(status));
}

std::string name_of_signal(int signal) {
  const char* name = sigabbrev_np(signal);
  return fmt::format("signal {} ({})", signal, name ? name : "?");
}

}  // namespace tessera
