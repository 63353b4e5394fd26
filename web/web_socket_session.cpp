#include "web/web_socket_session.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <exception>
#include <utility>

#include "web/web_access.h"

namespace tessera {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;

/// Of the memory that a large message took, so much is kept for the next.
constexpr size_t kBufferKept = 256 << 10;
constexpr size_t kReadAtOnce = 64 << 10;
constexpr char kInternalError[] = "internal error";

/// Ends what stands in the way of one more connection; returns why there is no room where known
/// ones take it all.
std::optional<HttpResponse> make_room(const WebSocketRouteState& state) {
  using Standing = WebSocketSession::Standing;
  const WebSocketLimits& limits = state.route.limits;
  const auto count = [&](Standing standing) {
    return static_cast<size_t>(
        std::ranges::count(state.sessions, standing, &WebSocketSession::standing));
  };
  const auto end_first = [&](Standing standing) {
    const auto first = std::ranges::find(state.sessions, standing, &WebSocketSession::standing);
    if (first != state.sessions.end()) (*first)->end();
  };
  const size_t known = count(Standing::known);
  if (known >= limits.connections)
    return http_error(503, fmt::format("{} connections are open", known));
  const size_t unknown = count(Standing::unknown);
  if (unknown >= limits.unknown || known + unknown >= limits.connections)
    end_first(Standing::unknown);
  if (count(Standing::closing) >= limits.connections) end_first(Standing::closing);
  return std::nullopt;
}

bool has_token(const HttpMessage& message, http::field field, const std::string& token) {
  return http::token_list(message[field]).exists(token);
}

}  // namespace

bool asks_for_web_socket(const HttpMessage& message) {
  return has_token(message, http::field::upgrade, "websocket");
}

std::optional<HttpResponse> refuse_upgrade(const WebSocketRouteState& state,
                                           const HttpMessage& message, const HttpRequest& request) {
  if (message.method() != http::verb::get) return http_error(405, "expected GET");
  if (message[http::field::sec_websocket_version] != "13") {
    HttpResponse response = http_error(426, "expected Sec-WebSocket-Version: 13");
    response.headers.emplace_back("Sec-WebSocket-Version", "13");
    return response;
  }
  if (!websocket::is_upgrade(message)) return http_error(400, "this is no upgrade to a WebSocket");
  if (auto refused = state.route.refuse(request)) return refused;
  const std::string& subprotocol = state.route.subprotocol;
  if (!has_token(message, http::field::sec_websocket_protocol, subprotocol)) {
    return http_error(400, fmt::format("expected Sec-WebSocket-Protocol: {}", subprotocol));
  }
  return make_room(state);
}

WebSocketSession::WebSocketSession(beast::tcp_stream stream, WebSocketRouteState& state,
                                   asio::io_context& context, std::weak_ptr<void> server)
    : state_(state),
      context_(context),
      server_(std::move(server)),
      stream_(std::move(stream)),
      patience_(context) {
  place_ = state_.sessions.insert(state_.sessions.end(), this);
}

WebSocketSession::~WebSocketSession() { state_.sessions.erase(place_); }

WebSocketSession::Standing WebSocketSession::standing() const {
  if (has_ended_) return Standing::ended;
  if (outbox_ && !outbox_->is_open()) return Standing::closing;
  return peer_ && peer_->is_known() ? Standing::known : Standing::unknown;
}

void WebSocketSession::accept(const HttpMessage& message, HttpRequest request) {
  const WebSocketLimits& limits = state_.route.limits;
  // Small messages are not to wait until those before are acknowledged.
  beast::error_code ignored;
  beast::get_lowest_layer(stream_).socket().set_option(asio::ip::tcp::no_delay(true), ignored);
  beast::get_lowest_layer(stream_).expires_never();
  stream_.set_option(websocket::stream_base::timeout{limits.to_close, limits.idle_timeout, true});
  stream_.set_option(websocket::stream_base::decorator(
      [subprotocol = state_.route.subprotocol](websocket::response_type& response) {
        response.set(http::field::sec_websocket_protocol, subprotocol);
      }));
  stream_.read_message_max(limits.message_bytes);
  stream_.auto_fragment(false);
  stream_.async_accept(
      message, [self = shared_from_this(), request = std::move(request)](beast::error_code error) {
        if (!error && !self->has_ended_) self->open(request);
      });
}

void WebSocketSession::open(const HttpRequest& request) {
  outbox_ = std::make_shared<WebSocketOutbox>(
      state_.route.limits.queued_bytes,
      [weak = weak_from_this(), server = server_, &context = context_] {
        const auto alive = server.lock();
        if (!alive) return;
        asio::post(context, [weak] {
          if (const auto self = weak.lock()) self->write();
        });
      });
  call_peer([&] { peer_ = state_.route.make_peer(request, outbox_); });
  read();
}

void WebSocketSession::end() {
  has_ended_ = true;
  ++turn_;
  patience_.cancel();
  beast::get_lowest_layer(stream_).close();
  if (outbox_) outbox_->end();
  if (const auto peer = std::move(peer_)) call_peer([&] { peer->on_close(); });
}

void WebSocketSession::read() {
  // In parts, since Beast makes room for all that a message is said to have.
  stream_.async_read_some(buffer_, kReadAtOnce,
                          [self = shared_from_this()](beast::error_code error, size_t) {
                            if (error) return self->end();
                            if (self->stream_.is_message_done()) self->receive();
                            self->read();
                          });
}

void WebSocketSession::receive() {
  if (peer_ && outbox_->is_open()) {
    const auto bytes = buffer_.cdata();
    call_peer([&] {
      peer_->on_message({static_cast<const char*>(bytes.data()), bytes.size()},
                        stream_.got_binary());
    });
  }
  buffer_.clear();
  if (buffer_.capacity() > kBufferKept) buffer_.shrink_to_fit();
}

void WebSocketSession::write() {
  WebSocketOutbox::Next next = outbox_->take();
  if (next.message) {
    sent_ = std::move(next.message);
    limit_time();
    stream_.binary(next.binary);
    return stream_.async_write(asio::buffer(*sent_),
                               [self = shared_from_this()](beast::error_code error, size_t) {
                                 self->sent_.reset();
                                 if (error) return self->end();
                                 self->write();
                               });
  }
  ++turn_;
  patience_.cancel();
  if (!next.closing) return;
  websocket::close_reason reason(next.closing->code);
  reason.reason = next.closing->reason;
  stream_.async_close(reason, [self = shared_from_this()](beast::error_code) { self->end(); });
}

void WebSocketSession::limit_time() {
  const auto until = std::chrono::steady_clock::now() + state_.route.limits.to_take;
  // After close() the messages that are left share the time of one.
  if (!outbox_->is_open() && !last_by_) last_by_ = until;
  patience_.expires_at(last_by_.value_or(until));
  patience_.async_wait([weak = weak_from_this(), turn = ++turn_](beast::error_code error) {
    const auto self = weak.lock();
    if (!error && self && self->turn_ == turn) self->end();
  });
}

template <typename Action>
void WebSocketSession::call_peer(Action action) {
  try {
    action();
  } catch (const std::exception& error) {
    spdlog::warn("the web page: {}", error.what());
    outbox_->close(websocket::internal_error, kInternalError);
  }
}

}  // namespace tessera
