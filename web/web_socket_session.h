#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <list>
#include <memory>
#include <optional>

#include "web/web_socket.h"
#include "web/web_socket_outbox.h"

namespace tessera {

class WebSocketSession;

/// A route and its connections. Outlives these.
struct WebSocketRouteState {
  WebSocketRoute route;
  std::list<WebSocketSession*> sessions;  ///< the one that came first is the first
};

using HttpMessage = boost::beast::http::request<boost::beast::http::string_body>;

/// Whether a WebSocket is asked for, be it rightly or not.
bool asks_for_web_socket(const HttpMessage& message);
/// Returns why the route cannot accept that upgrade, or nullopt: then there is room for one more.
/// `request` is the same message.
std::optional<HttpResponse> refuse_upgrade(const WebSocketRouteState& state,
                                           const HttpMessage& message, const HttpRequest& request);

/// One WebSocket on the server's thread: what comes goes to its peer, what its outbox holds is
/// sent.
class WebSocketSession : public std::enable_shared_from_this<WebSocketSession> {
 public:
  /// `server` owns the context.
  WebSocketSession(boost::beast::tcp_stream stream, WebSocketRouteState& state,
                   boost::asio::io_context& context, std::weak_ptr<void> server);
  ~WebSocketSession();
  WebSocketSession(const WebSocketSession&) = delete;
  WebSocketSession& operator=(const WebSocketSession&) = delete;

  /// Answers the upgrade and serves the connection until it ends.
  void accept(const HttpMessage& message, HttpRequest request);
  /// Ends the connection at once.
  void end();
  /// As what it counts among those of its route.
  enum class Standing { unknown, known, closing, ended };
  Standing standing() const;

 private:
  void open(const HttpRequest& request);
  void read();
  void receive();
  void write();
  /// Ends the connection unless the message that is being sent was taken in time.
  void limit_time();
  /// Calls `action`, which calls the peer; closes the connection where that throws.
  template <typename Action>
  void call_peer(Action action);

  WebSocketRouteState& state_;
  std::list<WebSocketSession*>::iterator place_;  ///< in that
  boost::asio::io_context& context_;
  std::weak_ptr<void> server_;
  boost::beast::websocket::stream<boost::beast::tcp_stream, false> stream_;
  boost::asio::steady_timer patience_;
  boost::beast::flat_buffer buffer_;
  std::shared_ptr<WebSocketOutbox> outbox_;
  std::unique_ptr<WebSocketPeer> peer_;
  bool has_ended_ = false;
  std::shared_ptr<const std::string> sent_;                       ///< what is being sent
  uint64_t turn_ = 0;                                             ///< of `patience_`
  std::optional<std::chrono::steady_clock::time_point> last_by_;  ///< after close()
};

}  // namespace tessera
