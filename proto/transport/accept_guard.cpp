#include "proto/transport/accept_guard.h"

#include <fcntl.h>
#include <sched.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "proto/transport/signals_blocked.h"

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

constexpr int kGuardEvents = ZMQ_EVENT_LISTENING | ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_ACCEPT_FAILED |
                             ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_DISCONNECTED;

}  // namespace

AcceptGuard::Watched::Watched(zmq::context_t& context, zmq::socket_t& socket)
    : monitor(context, socket, kGuardEvents) {}

AcceptGuard::AcceptGuard(zmq::context_t& context, const std::vector<zmq::socket_t*>& watched,
                         bool has_keys)
    : waiting_(has_keys) {
  for (zmq::socket_t* socket : watched) {
    watched_.emplace_back(context, *socket);
  }
  const SignalsBlocked blocked;  // they interrupt the server's thread
  thread_ = std::thread([this] { run(); });
}

AcceptGuard::~AcceptGuard() {
  end_.wake();
  thread_.join();
}

void AcceptGuard::run() {
  std::vector<zmq::pollitem_t> items{{nullptr, end_.descriptor(), ZMQ_POLLIN, 0}};
  for (Watched& each : watched_) {
    items.push_back({each.monitor.socket().handle(), 0, ZMQ_POLLIN, 0});
  }
  while (true) {
    poll_sockets(items, std::chrono::milliseconds(-1));
    if (items[0].revents != 0) return;
    for (Watched& each : watched_) read(each);
    waiting_.enforce();
  }
}

// All there is: libzmq tells that a connection has ended before it closes the descriptor. If the
// descriptor of one just added is another file's by now, that it ended is read here too. To read
// takes a small part of the time that it takes libzmq to accept, so that it does come to an end.
void AcceptGuard::read(Watched& watched) {
  bool failed = false;
  while (const auto seen = watched.monitor.next()) {
    const int value = static_cast<int>(seen->value);
    switch (seen->event) {
      case ZMQ_EVENT_LISTENING:
        watched.listener = value;
        // Somebody else may take the last that waits.
        fcntl(value, F_SETFL, fcntl(value, F_GETFL) | O_NONBLOCK);
        break;
      case ZMQ_EVENT_ACCEPTED:
        waiting_.add(watched.listener, value);
        break;
      case ZMQ_EVENT_DISCONNECTED:
        waiting_.remove(watched.listener, value);
        break;
      case ZMQ_EVENT_HANDSHAKE_SUCCEEDED:
        waiting_.note_admission();
        break;
      case ZMQ_EVENT_ACCEPT_FAILED:
        failed |= value == EMFILE || value == ENFILE;
        break;
    }
  }
  if (failed) turn_away(watched.listener);
}

void AcceptGuard::turn_away(int listener) {
  if (listener < 0) return;
  // All that wait, since each would wake the thread that accepts again. Not here: a descriptor
  // given up for that purpose could be taken at once by that thread. The child has our memory but
  // not our descriptors, and this thread stands still until it has ended.
  alignas(16) std::array<char, 64 << 10> stack;
  const pid_t child =
      clone(end_all_that_wait, stack.data() + stack.size(), CLONE_VM | CLONE_VFORK, &listener);
  if (child > 0) waitpid(child, nullptr, __WALL);
  if (std::exchange(told_, true)) return;
  spdlog::warn(
      "no file descriptor is left for another connection: whoever comes is turned away; expected a "
      "higher limit (ulimit -n)");
}

}  // namespace tessera
