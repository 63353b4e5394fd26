#include "web/web_server.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <list>
#include <optional>
#include <thread>
#include <utility>

#include "base/error.h"
#include "base/lower_case.h"
#include "web/web_access.h"
#include "web/web_socket_session.h"

namespace tessera {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using Tcp = asio::ip::tcp;

/// From one who is answered for the last time: for so long, and so much.
constexpr std::chrono::seconds kIgnored{1};
constexpr size_t kMostIgnored = 1 << 20;

Tcp::endpoint parse_address(const std::string& text) {
  const auto wrong = [&text] {
    return usage_error(
        fmt::format("--http: '{}'; expected ADDRESS:PORT such as 127.0.0.1:8080, the "
                    "address in digits or localhost",
                    text));
  };
  const size_t colon = text.rfind(':');
  if (colon == std::string::npos) throw wrong();
  std::string host = text.substr(0, colon);
  const std::string port = text.substr(colon + 1);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string::npos) {
    throw wrong();
  }
  if (host == "localhost") host = "127.0.0.1";
  const bool digits =
      !port.empty() && port.size() <= 5 &&
      std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!digits || std::stoi(port) > 65535) throw wrong();
  boost::system::error_code error;
  const auto address = asio::ip::make_address(host, error);
  if (error) throw wrong();
  return {address, static_cast<uint16_t>(std::stoi(port))};
}

/// All but the body.
HttpRequest plain(const HttpMessage& message) {
  HttpRequest request;
  request.method = std::string(message.method_string());
  split_target(std::string(message.target()), request);
  for (const auto& field : message) {
    request.headers.emplace(lower_case(std::string(field.name_string())),
                            std::string(field.value()));
  }
  return request;
}

/// What we decide by must not be there twice: others on the way may have gone by the other one.
bool is_ambiguous(const HttpMessage& message) {
  const auto fields = {http::field::host,
                       http::field::origin,
                       http::field::authorization,
                       http::field::content_type,
                       http::field::if_none_match,
                       http::field::upgrade,
                       http::field::sec_websocket_key,
                       http::field::sec_websocket_protocol,
                       http::field::sec_websocket_version};
  return std::any_of(fields.begin(), fields.end(),
                     [&](http::field field) { return message.count(field) > 1; });
}

using Answer = http::response<http::span_body<const char>>;

void add_protection(Answer& answer) {
  answer.set("Content-Security-Policy",
             "default-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  answer.set("X-Content-Type-Options", "nosniff");
  answer.set("Referrer-Policy", "no-referrer");
  answer.set("Cross-Origin-Resource-Policy", "same-origin");
  answer.set("Cross-Origin-Opener-Policy", "same-origin");
}

}  // namespace

class WebServer::Impl : public std::enable_shared_from_this<WebServer::Impl> {
 public:
  Impl(const std::string& address, HttpHandler handler, const WebLimits& limits,
       std::vector<WebSocketRoute> routes)
      : handler_(std::move(handler)), limits_(limits), acceptor_(context_) {
    for (WebSocketRoute& route : routes) routes_.push_back({std::move(route), {}});
    const Tcp::endpoint endpoint = parse_address(address);
    try {
      acceptor_.open(endpoint.protocol());
      acceptor_.set_option(asio::socket_base::reuse_address(true));
      acceptor_.bind(endpoint);
      acceptor_.listen();
    } catch (const boost::system::system_error& error) {
      const std::string what =
          fmt::format("--http: '{}' cannot be bound: {}", address, error.code().message());
      throw error.code() == asio::error::address_in_use ? temporary_error(what) : usage_error(what);
    }
  }

  void start() {
    accept();
    thread_ = std::thread([this] { run(); });
  }
  void stop() {
    asio::post(context_, [this] {
      end_web_sockets();
      context_.stop();
    });
    thread_.join();
  }
  std::string address() const {
    const Tcp::endpoint bound = acceptor_.local_endpoint();
    const std::string host = bound.address().to_string();
    return fmt::format(fmt::runtime(bound.address().is_v6() ? "[{}]:{}" : "{}:{}"), host,
                       bound.port());
  }

 private:
  class Session;

  void run() {
    while (true) {
      try {
        context_.run();
        return;
      } catch (const std::exception& error) {
        // Of one request, such as no memory for it: the others are served on.
        spdlog::warn("the web page: {}", error.what());
      }
    }
  }
  void accept();
  bool make_room();
  void end_web_sockets();

  HttpHandler handler_;
  WebLimits limits_;
  std::list<WebSocketRouteState> routes_;
  size_t connections_ = 0;
  std::list<Session*> asking_;   ///< whose requests have not come in full, the longest first
  asio::io_context context_{1};  ///< keeps the sessions, which use the above
  Tcp::acceptor acceptor_;
  asio::steady_timer pause_{context_};
  std::thread thread_;
};

/// One connection: requests and answers in turn.
class WebServer::Impl::Session : public std::enable_shared_from_this<Session> {
 public:
  Session(Tcp::socket socket, Impl& server)
      : server_(server), stream_(std::move(socket)), patience_(stream_.get_executor()) {
    ++server_.connections_;
  }
  ~Session() {
    end_asking();
    --server_.connections_;
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  void hang_up() {
    end_asking();
    stream_.close();
  }

  void read() {
    asking_ = server_.asking_.insert(server_.asking_.end(), this);
    parser_.emplace();
    parser_->header_limit(server_.limits_.header_bytes);
    parser_->body_limit(server_.limits_.body_bytes);
    stream_.expires_after(server_.limits_.to_ask);
    http::async_read(
        stream_, buffer_, *parser_, [self = shared_from_this()](beast::error_code error, size_t) {
          self->end_asking();
          if (!error) return self->handle();
          if (error == http::error::body_limit || error == http::error::header_limit) {
            self->keep_alive_ = false;
            self->answer({413, "text/plain", std::make_shared<const std::string>("too large\n")});
          }
        });
  }

 private:
  void end_asking() {
    if (asking_) server_.asking_.erase(*asking_);
    asking_.reset();
  }

  void handle() {
    keep_alive_ = parser_->get().keep_alive();
    head_ = parser_->get().method() == http::verb::head;
    if (!server_.routes_.empty() && asks_for_web_socket(parser_->get())) return upgrade();
    if (is_ambiguous(parser_->get())) {
      keep_alive_ = false;
      return answer({400, "text/plain", std::make_shared<const std::string>("a field twice\n")});
    }
    stream_.expires_never();
    const uint64_t turn = ++turn_;
    // Also keeps this while nothing else does.
    patience_.expires_after(server_.limits_.to_answer);
    patience_.async_wait([self = shared_from_this(), turn](beast::error_code error) {
      if (error || self->turn_ != turn) return;
      self->answer({503, "text/plain", std::make_shared<const std::string>("no answer in time\n")});
    });
    HttpRequest request = plain(parser_->get());
    request.body = std::move(parser_->get().body());
    // Weak: a reply may be kept for longer than the server lives.
    server_.handler_(std::move(request),
                     [weak = weak_from_this(), server = server_.weak_from_this(),
                      turn](std::function<HttpResponse()> make) {
                       const auto there = server.lock();
                       if (!there) return;
                       asio::post(there->context_, [weak, turn, make = std::move(make)] {
                         const auto self = weak.lock();
                         if (self && self->turn_ == turn) self->answer(make());
                       });
                     });
  }

  /// Gives the connection to a WebSocketSession, or answers why not.
  void upgrade() {
    const HttpMessage message = parser_->release();
    HttpRequest request = plain(message);
    const auto state = std::find_if(
        server_.routes_.begin(), server_.routes_.end(),
        [&](const WebSocketRouteState& known) { return known.route.path == request.path; });
    keep_alive_ = false;
    if (state == server_.routes_.end()) return answer(http_error(404, "there is no WebSocket"));
    // What follows the request would be lost; a client has nothing to send before it is accepted.
    if (is_ambiguous(message) || buffer_.size() > 0) {
      return answer(http_error(400, "a field twice, or more than a request"));
    }
    if (const auto refused = refuse_upgrade(*state, message, request)) return answer(*refused);
    std::make_shared<WebSocketSession>(std::move(stream_), *state, server_.context_,
                                       server_.weak_from_this())
        ->accept(message, std::move(request));
  }

  void answer(const HttpResponse& response) {
    ++turn_;
    patience_.cancel();
    static const auto kNothing = std::make_shared<const std::string>();
    body_ = response.body ? response.body : kNothing;
    answer_.emplace();
    answer_->result(static_cast<unsigned>(response.status));
    answer_->version(11);
    answer_->keep_alive(keep_alive_);
    if (!response.type.empty()) answer_->set(http::field::content_type, response.type);
    answer_->set(http::field::cache_control, "no-store");
    add_protection(*answer_);
    for (const auto& [name, value] : response.headers) answer_->set(name, value);
    answer_->content_length(body_->size());
    if (!head_) answer_->body() = {body_->data(), body_->size()};
    serializer_.emplace(*answer_);
    stream_.expires_after(server_.limits_.to_take);
    const auto taken = [self = shared_from_this()](beast::error_code error, size_t) {
      if (error) return;
      self->body_.reset();
      if (self->keep_alive_) return self->read();
      self->stream_.socket().shutdown(Tcp::socket::shutdown_send, error);
      self->ignore_rest(kMostIgnored);
    };
    if (head_) {
      http::async_write_header(stream_, *serializer_, taken);
    } else {
      http::async_write(stream_, *serializer_, taken);
    }
  }

  /// A socket that is closed with bytes unread takes back what was just sent.
  void ignore_rest(size_t most) {
    stream_.expires_after(kIgnored);
    buffer_.clear();
    stream_.async_read_some(
        buffer_.prepare(std::min(most, buffer_.max_size())),
        [self = shared_from_this(), most](beast::error_code error, size_t size) {
          if (!error && size < most) self->ignore_rest(most - size);
        });
  }

  Impl& server_;
  beast::tcp_stream stream_;
  asio::steady_timer patience_;
  beast::flat_buffer buffer_{64 << 10};
  std::optional<http::request_parser<http::string_body>> parser_;
  std::shared_ptr<const std::string> body_;
  std::optional<Answer> answer_;
  std::optional<http::response_serializer<http::span_body<const char>>> serializer_;
  std::optional<std::list<Session*>::iterator> asking_;
  uint64_t turn_ = 0;
  bool keep_alive_ = false, head_ = false;
};

/// Whoever floods has no way to keep those away who ask something, such as whether all is well.
bool WebServer::Impl::make_room() {
  if (connections_ < limits_.connections) return true;
  if (asking_.empty()) return false;
  asking_.front()->hang_up();
  return true;
}

void WebServer::Impl::accept() {
  acceptor_.async_accept([this](beast::error_code error, Tcp::socket socket) {
    if (!error && make_room()) {
      std::make_shared<Session>(std::move(socket), *this)->read();
    }
    if (!error) return accept();
    if (error == asio::error::operation_aborted) return;
    // No descriptor is free: trying on at once would take a whole core.
    pause_.expires_after(std::chrono::milliseconds(100));
    pause_.async_wait([this](beast::error_code stopped) {
      if (!stopped) accept();
    });
  });
}

void WebServer::Impl::end_web_sockets() {
  for (const WebSocketRouteState& state : routes_) {
    // Its end takes it from the set, at once or when its operations have come to an end.
    const auto sessions = state.sessions;
    for (WebSocketSession* session : sessions) session->end();
  }
}

WebServer::WebServer(const std::string& address, HttpHandler handler, const WebLimits& limits,
                     std::vector<WebSocketRoute> routes)
    : impl_(std::make_shared<Impl>(address, std::move(handler), limits, std::move(routes))) {
  impl_->start();
}

WebServer::~WebServer() { impl_->stop(); }

std::string WebServer::address() const { return impl_->address(); }

bool WebServer::is_loopback(const std::string& address) {
  return parse_address(address).address().is_loopback();
}

}  // namespace tessera
