#pragma once

#include <list>
#include <thread>
#include <vector>
#include <zmq.hpp>

#include "proto/transport/socket_monitor.h"
#include "proto/transport/waiting_connections.h"
#include "proto/transport/zmq_sockets.h"

namespace tessera {

/// Keeps those who are not let in from using up this process's descriptors by connections to the
/// bound sockets of a server. The oldest of too many that wait to be let in are ended (see
/// WaitingConnections). Where no descriptor is left all the same, whoever comes is turned away,
/// instead of being tried again and again in circles by libzmq's busy thread. Those that are let in
/// notice nothing. For this module alone.
///
/// It has a thread of its own, for libzmq accepts connections while the server's thread is busy.
class AcceptGuard {
 public:
  /// To be made before the sockets are bound, and destroyed before they are closed, by their
  /// thread.
  AcceptGuard(zmq::context_t& context, const std::vector<zmq::socket_t*>& watched, bool has_keys);
  ~AcceptGuard();
  AcceptGuard(const AcceptGuard&) = delete;
  AcceptGuard& operator=(const AcceptGuard&) = delete;

 private:
  struct Watched {
    Watched(zmq::context_t& context, zmq::socket_t& socket);
    SocketMonitor monitor;
    int listener = -1;  ///< the socket's own
  };

  void run();
  /// Reads everything that was told of a socket.
  void read(Watched& watched);
  void turn_away(int listener);

  std::list<Watched> watched_;
  WaitingConnections waiting_;
  bool told_ = false;
  WakeUp end_;
  std::thread thread_;
};

}  // namespace tessera
