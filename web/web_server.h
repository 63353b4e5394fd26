#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "web/http_message.h"
#include "web/web_socket.h"

namespace tessera {

/// What one who connects may take up. A message that exceeds its share ends the connection.
struct WebLimits {
  /// Of more, those that ask nothing for the longest are closed; where all ask, whoever comes.
  size_t connections = 512;
  uint32_t header_bytes = 8 << 10;
  uint64_t body_bytes = 4 << 10;
  std::chrono::milliseconds to_ask{15'000};    ///< for a whole request, from the last answer on
  std::chrono::milliseconds to_answer{5'000};  ///< for the handler; then 503
  std::chrono::milliseconds to_take{20'000};   ///< for the whole answer to be taken
};

/// An HTTP/1.1 and WebSocket server over TCP on a thread of its own, which is all that one who
/// stalls or floods can slow. All answers forbid other sites to frame, read or guess at them.
class WebServer {
 public:
  /// Binds "ADDRESS:PORT", the address in digits or "localhost", IPv6 in brackets; port 0: any that
  /// is free. Throws temporary_error where it is in use, usage_error where it cannot be bound for
  /// another reason. `handler` is called on the server's thread. `routes` accept WebSockets, whose
  /// connections are counted by their own limits; with any of them an upgrade at another path is
  /// refused.
  WebServer(const std::string& address, HttpHandler handler, const WebLimits& limits = {},
            std::vector<WebSocketRoute> routes = {});
  /// Ends all connections. Replies and messages that come later go nowhere.
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// "127.0.0.1:8080", as it was bound.
  std::string address() const;
  /// Whether that address is of this machine alone.
  static bool is_loopback(const std::string& address);

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace tessera
