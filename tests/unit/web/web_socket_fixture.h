#pragma once

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/unit/web/web_client.h"
#include "web/web_access.h"
#include "web/web_server.h"
#include "web/web_socket.h"

namespace tessera::testing {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;

inline constexpr char kProtocol[] = "test.1";

inline std::shared_ptr<const std::string> shared(std::string content) {
  return std::make_shared<const std::string>(std::move(content));
}

/// What became of all peers of a route, and their sockets.
struct Record {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::shared_ptr<WebSocket>> sockets;
  std::vector<std::string> messages;
  std::vector<std::thread::id> threads;  ///< that called a peer
  size_t closed = 0, destroyed = 0;

  template <typename Change>
  void note(Change change) {
    const std::lock_guard lock(mutex);
    threads.push_back(std::this_thread::get_id());
    change();
    changed.notify_all();
  }
  /// Waits for what is to come; a test that fails does so after a minute.
  template <typename Condition>
  bool wait(Condition condition) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, std::chrono::seconds(60), condition);
  }
  std::shared_ptr<WebSocket> socket(size_t index = 0) {
    wait([&] { return sockets.size() > index; });
    const std::lock_guard lock(mutex);
    return sockets.at(index);
  }
};

/// Sends back what comes, but for some words.
class Echo : public WebSocketPeer {
 public:
  Echo(std::shared_ptr<Record> record, std::shared_ptr<WebSocket> socket)
      : record_(std::move(record)), socket_(std::move(socket)) {
    record_->note([&] { record_->sockets.push_back(socket_); });
  }
  ~Echo() override {
    record_->note([&] { ++record_->destroyed; });
  }
  void on_message(std::string_view message, bool binary) override {
    record_->note([&] { record_->messages.emplace_back(message); });
    if (message == "throw") throw std::runtime_error("as asked");
    if (message == "close") {
      socket_->send(shared("last words"), false);
      socket_->close(4401, "no token");
      EXPECT_FALSE(socket_->send(shared("too late"), false));
      return;
    }
    if (message == "a stranger") is_known_ = false;
    socket_->send(shared(std::string(message)), binary);
  }
  void on_close() override {
    record_->note([&] { ++record_->closed; });
  }
  bool is_known() const override { return is_known_; }

 private:
  std::shared_ptr<Record> record_;
  std::shared_ptr<WebSocket> socket_;
  bool is_known_ = true;
};

class WebSockets : public ::testing::Test {
 protected:
  void serve(const WebSocketLimits& limits = {}) {
    WebSocketRoute route;
    route.path = "/talk";
    route.subprotocol = kProtocol;
    route.limits = limits;
    route.refuse = [](const HttpRequest& request) { return WebAccess().refuse_upgrade(request); };
    route.make_peer = [record = record](const HttpRequest& request,
                                        std::shared_ptr<WebSocket> socket) {
      EXPECT_EQ(request.path, "/talk");
      return std::make_unique<Echo>(record, std::move(socket));
    };
    server.emplace(
        "127.0.0.1:0",
        [](const HttpRequest&, const HttpReply& reply) {
          reply([] { return HttpResponse{200, "text/plain", shared("page"), {}}; });
        },
        WebLimits{}, std::vector{route});
  }
  std::string host() const { return server->address(); }
  std::string upgrade(const std::string& origin = "", const std::string& more = "") const {
    return "GET /talk HTTP/1.1\r\nHost: " + host() +
           "\r\nOrigin: " + (origin.empty() ? "http://" + host() : origin) +
           "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: other, test.1"
           "\r\n" +
           more + "\r\n";
  }
  /// The answer to what may be an upgrade.
  std::string answer(const std::string& request) const {
    WebClient client(host());
    client.send(request);
    return client.receive_one();
  }

  std::shared_ptr<Record> record = std::make_shared<Record>();
  std::optional<WebServer> server;
};

/// A client that does all as it should.
class WebSocketClient {
 public:
  explicit WebSocketClient(const std::string& address, bool take_slowly = false,
                           const std::string& path = "/talk", const char* protocol = kProtocol) {
    const size_t colon = address.find(':');
    auto& socket = stream_.next_layer();
    socket.open(asio::ip::tcp::v4());
    if (take_slowly) socket.set_option(asio::socket_base::receive_buffer_size(4096));
    socket.connect({asio::ip::make_address("127.0.0.1"),
                    static_cast<uint16_t>(std::stoi(address.substr(colon + 1)))});
    websocket::permessage_deflate deflate;
    deflate.client_enable = true;
    stream_.set_option(deflate);
    stream_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      request.set(beast::http::field::origin, "http://" + address);
      request.set(beast::http::field::sec_websocket_protocol, protocol);
    }));
    stream_.handshake(response, address, path);
  }
  void send(const std::string& message, bool binary = false) {
    stream_.binary(binary);
    stream_.write(asio::buffer(message));
  }
  /// The next message; "closed CODE REASON" or "lost" where there is none.
  std::string receive() {
    beast::flat_buffer buffer;
    beast::error_code error;
    stream_.read(buffer, error);
    if (error == websocket::error::closed) {
      return "closed " + std::to_string(stream_.reason().code) + " " +
             std::string(stream_.reason().reason.c_str());
    }
    return error ? "lost" : beast::buffers_to_string(buffer.data());
  }
  bool got_binary() const { return stream_.got_binary(); }
  websocket::stream<asio::ip::tcp::socket>& stream() { return stream_; }

  websocket::response_type response;

 private:
  asio::io_context context_;
  websocket::stream<asio::ip::tcp::socket> stream_{context_};
};

}  // namespace tessera::testing
