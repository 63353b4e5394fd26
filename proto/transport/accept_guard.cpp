#include "proto/transport/accept_guard.h"

#include <fcntl.h>
#include <sched.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <utility>

namespace tessera {
namespace {

/// Runs in a process with a table of descriptors of its own, where there is room for one more.
int end_all_that_wait(void* argument) {
  const int listener = *static_cast<int*>(argument);
  if (listener > 0) close_range(0, static_cast<unsigned>(listener) - 1, 0);
  close_range(static_cast<unsigned>(listener) + 1, ~0U, 0);
  while (true) {
    const int unwanted = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (unwanted < 0) return 0;
    close(unwanted);
  }
}

}  // namespace

AcceptGuard::AcceptGuard(zmq::context_t& context, zmq::socket_t& watched)
    : monitor_(context, watched, ZMQ_EVENT_LISTENING | ZMQ_EVENT_ACCEPT_FAILED) {}

void AcceptGuard::act() {
  bool failed = false;
  while (const auto seen = monitor_.next()) {
    if (seen->event == ZMQ_EVENT_LISTENING) {
      listener_ = static_cast<int>(seen->value);
      // Somebody else may take the last that waits.
      fcntl(listener_, F_SETFL, fcntl(listener_, F_GETFL) | O_NONBLOCK);
    }
    failed |=
        seen->event == ZMQ_EVENT_ACCEPT_FAILED && (seen->value == EMFILE || seen->value == ENFILE);
  }
  if (failed) turn_away();
}

void AcceptGuard::turn_away() {
  if (listener_ < 0) return;
  // All that wait, since each would wake the thread that accepts again. Not here: a descriptor
  // given up for that purpose could be taken at once by that thread. The child has our memory but
  // not our descriptors, and this thread stands still until it has ended.
  alignas(16) std::array<char, 64 << 10> stack;
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);  // no handler of ours shall run in it
  const pid_t child =
      clone(end_all_that_wait, stack.data() + stack.size(), CLONE_VM | CLONE_VFORK, &listener_);
  if (child > 0) waitpid(child, nullptr, __WALL);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (std::exchange(told_, true)) return;
  spdlog::warn(
      "no file descriptor is left for another connection: whoever comes is turned away; expected a "
      "higher limit (ulimit -n)");
}

}  // namespace tessera
