#pragma once

#include <zmq.hpp>

#include "proto/transport/socket_monitor.h"

namespace tessera {

/// What a bound socket does while this process has no file descriptor left for another connection:
/// who waits for one is turned away, instead of being tried again and again in circles by a busy
/// thread. Those that are connected notice nothing. For this room alone; used by the socket's
/// thread.
class AcceptGuard {
 public:
  /// To be made before the socket is bound.
  AcceptGuard(zmq::context_t& context, zmq::socket_t& watched);

  /// Becomes readable when there is something to do.
  zmq::socket_t& socket() { return monitor_.socket(); }
  /// Takes notice of what has happened since. Does not block.
  void act();

 private:
  void turn_away();

  SocketMonitor monitor_;
  int listener_ = -1;  ///< the socket's own
  bool told_ = false;
};

}  // namespace tessera
