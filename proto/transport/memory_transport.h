#pragma once

#include <memory>

#include "proto/transport/transport.h"

namespace tessera {

/// A farm inside one process: one server and any number of clients, each used by its own thread.
/// Nothing is lost, re-ordered or limited. Copies share the same network.
class MemoryNetwork {
 public:
  MemoryNetwork();
  /// At most once.
  std::unique_ptr<ServerTransport> server();
  /// Any time before or after server(). A destroyed client is `gone` to the server.
  std::unique_ptr<ClientTransport> client();

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace tessera
