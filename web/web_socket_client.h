#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace tessera {

/// The client's end of a WebSocket to a server of this machine, for who waits for answers. Used by
/// one thread. Its functions throw render_error once the connection cannot be made or has
/// ended.
class WebSocketClient {
 public:
  struct Headers {
    std::string origin{}, subprotocol{};  ///< empty: the header is not sent
  };
  struct Message {
    bool binary = false;
    std::string content;
  };

  /// `address`: "127.0.0.1:PORT"; `path` begins with "/".
  WebSocketClient(const std::string& address, const std::string& path, const Headers& headers);
  ~WebSocketClient();
  WebSocketClient(const WebSocketClient&) = delete;
  WebSocketClient& operator=(const WebSocketClient&) = delete;

  void send(std::string_view text);
  /// The next message, or nothing once that time is over.
  std::optional<Message> receive(std::chrono::nanoseconds patience);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
