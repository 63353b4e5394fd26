#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "web/http_message.h"

namespace tessera {

/// The server's end of a WebSocket, by which messages are sent. May be used from any thread, and be
/// kept for longer than the connection and the server live: then nothing is sent.
class WebSocket {
 public:
  virtual ~WebSocket() = default;
  /// Queues a message, which may be shared with other connections. Returns false and drops it where
  /// the connection has ended or close() was called, or where WebSocketLimits::queued_bytes or more
  /// are queued: one message of any size passes. Text must be UTF-8.
  virtual bool send(std::shared_ptr<const std::string> message, bool binary) = 0;
  /// The bytes of messages that the system's socket has not taken yet.
  virtual size_t queued_bytes() const = 0;
  /// Closes the connection once what is queued was sent. `code` is one of RFC 6455, or from 4000 to
  /// 4999; `reason` is cut at 123 bytes. From then on no message is received.
  virtual void close(uint16_t code, std::string_view reason) = 0;
  /// Whether it neither has ended nor was closed by close().
  virtual bool is_open() const = 0;
};

/// Receives what comes over one WebSocket. All its functions, and its destructor, are called on the
/// server's thread, so they should be quick. What they throw is logged and ends the connection with
/// code 1011.
class WebSocketPeer {
 public:
  virtual ~WebSocketPeer() = default;
  /// A whole message, which is valid during the call. Text is valid UTF-8.
  virtual void on_message(std::string_view message, bool binary) = 0;
  /// Called once, as the last, however the connection has ended.
  virtual void on_close() = 0;
  /// Whether it is known who is there; see WebSocketLimits::unknown.
  virtual bool is_known() const { return true; }
};

struct WebSocketLimits {
  /// Of the route, without those that close() was called for; further ones are answered 503. As
  /// many more may be closing: of more, those that came first end at once.
  size_t connections = 32;
  /// Of these, whose peers are not known (yet). For one more the one that came first ends.
  size_t unknown = 8;
  size_t message_bytes = 16 << 20;  ///< received; a larger one ends the connection with 1009
  size_t queued_bytes = 16 << 20;   ///< see WebSocket::send()
  std::chrono::milliseconds idle_timeout{10'000};  ///< the connection ends when nothing comes for
                                                   ///< so long; after half of it a ping is sent
  std::chrono::milliseconds to_take{30'000};  ///< for the system's socket to take one whole message
  std::chrono::milliseconds to_close{3'000};  ///< for the handshakes of opening and closing
};

/// Where a WebServer accepts WebSockets.
struct WebSocketRoute {
  std::string path;         ///< "/studio"
  std::string subprotocol;  ///< which the client must offer
  /// Decides about Host and Origin: WebAccess::refuse_upgrade(). Called on the server's thread.
  std::function<std::optional<HttpResponse>(const HttpRequest&)> refuse;
  /// Makes the receiver of a connection that was accepted, on the server's thread.
  std::function<std::unique_ptr<WebSocketPeer>(const HttpRequest&, std::shared_ptr<WebSocket>)>
      make_peer;
  WebSocketLimits limits{};
};

}  // namespace tessera
