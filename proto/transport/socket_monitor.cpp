#include "proto/transport/socket_monitor.h"

#include <fmt/format.h>

#include <atomic>
#include <cstring>

#include "proto/transport/zmq_sockets.h"

namespace tessera {

SocketMonitor::SocketMonitor(zmq::context_t& context, zmq::socket_t& watched, int events)
    : watched_(watched.handle()), events_(context, zmq::socket_type::pair) {
  events_.set(zmq::sockopt::linger, 0);
  events_.set(zmq::sockopt::rcvhwm, 0);
  static std::atomic<uint64_t> count{0};
  const std::string endpoint = fmt::format("inproc://monitor-{}", ++count);
  if (zmq_socket_monitor(watched_, endpoint.c_str(), events) != 0) throw zmq::error_t();
  events_.connect(endpoint);
}

// First nothing is told any more: without anybody to read it, libzmq's thread would wait for ever,
// and with it all that the context's sockets send and receive.
SocketMonitor::~SocketMonitor() { zmq_socket_monitor(watched_, nullptr, 0); }

std::optional<SocketMonitor::Event> SocketMonitor::next() {
  while (true) {
    const auto parts = receive_parts(events_);
    if (parts.empty()) return std::nullopt;
    Event event;
    if (parts[0].size() < sizeof event.event + sizeof event.value) continue;
    std::memcpy(&event.event, parts[0].data(), sizeof event.event);
    std::memcpy(&event.value, parts[0].data<char>() + sizeof event.event, sizeof event.value);
    return event;
  }
}

}  // namespace tessera
