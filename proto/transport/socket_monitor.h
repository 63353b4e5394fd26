#pragma once

#include <cstdint>
#include <optional>
#include <zmq.hpp>

namespace tessera {

/// What libzmq's I/O thread tells of a socket: it keeps all that was not read yet, so that this
/// thread never waits for whoever reads. Internal to proto/transport; made and destroyed by the
/// socket's thread, before the socket is closed, and read by one thread.
class SocketMonitor {
 public:
  struct Event {
    uint16_t event = 0;  ///< ZMQ_EVENT_*
    uint32_t value = 0;
  };

  /// `events` of ZMQ_EVENT_*.
  SocketMonitor(zmq::context_t& context, zmq::socket_t& watched, int events);
  ~SocketMonitor();
  SocketMonitor(const SocketMonitor&) = delete;
  SocketMonitor& operator=(const SocketMonitor&) = delete;

  /// Becomes readable when there is an event.
  zmq::socket_t& socket() { return events_; }
  /// The next event, or none. Does not block.
  std::optional<Event> next();

 private:
  void* watched_;
  zmq::socket_t events_;
};

}  // namespace tessera
