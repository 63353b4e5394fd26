#include "proto/transport/accept_guard.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <utility>

#include "proto/transport/zmq_sockets.h"

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
    : events_(context, zmq::socket_type::pair) {
  events_.set(zmq::sockopt::linger, 0);
  static std::atomic<uint64_t> count{0};
  const std::string endpoint = fmt::format("inproc://accepts-{}", ++count);
  constexpr int kEvents = ZMQ_EVENT_LISTENING | ZMQ_EVENT_ACCEPT_FAILED;
  if (zmq_socket_monitor(watched.handle(), endpoint.c_str(), kEvents) != 0) throw zmq::error_t();
  events_.connect(endpoint);
}

void AcceptGuard::act() {
  bool failed = false;
  while (true) {
    const auto parts = receive_parts(events_);
    if (parts.empty()) break;
    uint16_t event = 0;
    uint32_t value = 0;
    if (parts[0].size() < sizeof event + sizeof value) continue;
    std::memcpy(&event, parts[0].data(), sizeof event);
    std::memcpy(&value, parts[0].data<char>() + sizeof event, sizeof value);
    if (event == ZMQ_EVENT_LISTENING) {
      listener_ = static_cast<int>(value);
      // Somebody else may take the last that waits.
      fcntl(listener_, F_SETFL, fcntl(listener_, F_GETFL) | O_NONBLOCK);
    }
    failed |= event == ZMQ_EVENT_ACCEPT_FAILED && (value == EMFILE || value == ENFILE);
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
