#include "web/web_socket_client.h"

#include <fmt/format.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include "base/error.h"

namespace tessera {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;

constexpr std::chrono::seconds kToConnect{10};
constexpr size_t kMostBytesOfMessage = 256 << 20;

}  // namespace

class WebSocketClient::Impl {
 public:
  Impl(const std::string& address, const std::string& path, const Headers& headers)
      : address_(address) {
    const size_t colon = address.rfind(':');
    const asio::ip::tcp::endpoint endpoint{
        asio::ip::make_address(address.substr(0, colon)),
        static_cast<unsigned short>(std::stoi(address.substr(colon + 1)))};
    stream_.read_message_max(kMostBytesOfMessage);
    stream_.set_option(
        websocket::stream_base::decorator([headers](websocket::request_type& request) {
          if (!headers.origin.empty()) request.set(beast::http::field::origin, headers.origin);
          if (!headers.subprotocol.empty()) {
            request.set(beast::http::field::sec_websocket_protocol, headers.subprotocol);
          }
        }));
    beast::get_lowest_layer(stream_).async_connect(endpoint, [&, path](beast::error_code error) {
      if (error) return end(error);
      beast::get_lowest_layer(stream_).socket().set_option(asio::ip::tcp::no_delay(true));
      stream_.async_handshake(address, path, [this](beast::error_code failed) {
        if (failed) return end(failed);
        read();
      });
    });
    const auto deadline = std::chrono::steady_clock::now() + kToConnect;
    while (!is_reading_ && error_.empty() && context_.run_one_until(deadline) > 0) {
    }
    if (!is_reading_ && error_.empty()) error_ = "no answer";
    check();
  }

  void send(std::string_view text) {
    check();
    beast::error_code error;
    stream_.text(true);
    stream_.write(asio::buffer(text.data(), text.size()), error);
    if (error) end(error);
    check();
  }

  std::optional<Message> receive(std::chrono::nanoseconds patience) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    context_.restart();
    while (!message_ && error_.empty() && context_.run_one_until(deadline) > 0) {
    }
    if (message_) {
      std::optional<Message> message = std::exchange(message_, std::nullopt);
      read();
      return message;
    }
    check();
    return std::nullopt;
  }

 private:
  void read() {
    is_reading_ = true;
    stream_.async_read(buffer_, [this](beast::error_code error, size_t) {
      if (error) return end(error);
      message_ = Message{stream_.got_binary(), beast::buffers_to_string(buffer_.data())};
      buffer_.consume(buffer_.size());
    });
  }
  void end(beast::error_code error) { error_ = error.message(); }
  void check() const {
    if (!error_.empty()) {
      throw render_error(fmt::format("WebSocket to {}: {}", address_, error_));
    }
  }

  const std::string address_;
  asio::io_context context_;
  websocket::stream<beast::tcp_stream> stream_{context_};
  beast::flat_buffer buffer_;
  std::optional<Message> message_;
  bool is_reading_ = false;
  std::string error_;
};

WebSocketClient::WebSocketClient(const std::string& address, const std::string& path,
                                 const Headers& headers)
    : impl_(std::make_unique<Impl>(address, path, headers)) {}
WebSocketClient::~WebSocketClient() = default;
void WebSocketClient::send(std::string_view text) { impl_->send(text); }
std::optional<WebSocketClient::Message> WebSocketClient::receive(
    std::chrono::nanoseconds patience) {
  return impl_->receive(patience);
}

}  // namespace tessera
