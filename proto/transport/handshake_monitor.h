#pragma once

#include <optional>
#include <zmq.hpp>

#include "proto/transport/socket_monitor.h"
#include "proto/transport/transport.h"

namespace tessera {

/// Finds out why a client's socket gets no connection. Internal to proto/transport; used by the
/// socket's thread, and to be made again with each new socket.
class HandshakeMonitor {
 public:
  HandshakeMonitor(zmq::context_t& context, zmq::socket_t& watched, bool has_keys);

  /// Takes notice of what has happened since. Does not block.
  void read();
  const std::optional<ConnectionTrouble>& trouble() const { return trouble_; }
  /// Whether the other side is there, and agreed to talk.
  bool connected() const { return connected_; }

 private:
  SocketMonitor monitor_;
  bool has_keys_;
  std::optional<ConnectionTrouble> trouble_;
  bool connected_ = false;
};

}  // namespace tessera
