#include "proto/transport/accept_guard.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>

#include "proto/transport/zmq_sockets.h"

namespace tessera {
namespace {

OwnedDescriptor make_spare() { return OwnedDescriptor(open("/dev/null", O_RDONLY | O_CLOEXEC)); }

}  // namespace

AcceptGuard::AcceptGuard(zmq::context_t& context, zmq::socket_t& watched)
    : events_(context, zmq::socket_type::pair), spare_(make_spare()) {
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
  // All that wait, since each would wake the thread that accepts again.
  while (listener_ >= 0) {
    spare_ = OwnedDescriptor();
    const OwnedDescriptor unwanted(
        accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (unwanted.get() < 0) break;
    if (turned_away_++ == 0) {
      spdlog::warn(
          "no file descriptor is left for another connection: whoever comes is turned "
          "away; expected a higher limit (ulimit -n)");
    }
  }
  spare_ = make_spare();
}

}  // namespace tessera
