#include "proto/transport/zmq_transport.h"

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <deque>
#include <span>
#include <utility>
#include <zmq.hpp>

#include "base/error.h"
#include "proto/transport/endpoint.h"
#include "proto/transport/socket_file.h"

namespace tessera {
namespace {

constexpr int kHighWater = 256;
// Of what is kept for a connection that takes nothing. Nothing depends on delivery.
constexpr size_t kMaxKept = 1024, kMaxKeptBytes = size_t{256} << 20;
constexpr int kLingerMs = 500;
constexpr int kHandshakeMs = 5000;
constexpr int kReconnectMs = 50, kReconnectMaxMs = 5000;
constexpr int kZmtpHeartbeatMs = 2000, kZmtpTimeoutMs = 10000;

/// Interrupts a wait from another thread.
class WakeUp {
 public:
  WakeUp() : descriptor_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (descriptor_ < 0) throw render_error("no file descriptor is left for an event");
  }
  ~WakeUp() { close(descriptor_); }
  WakeUp(const WakeUp&) = delete;
  WakeUp& operator=(const WakeUp&) = delete;
  int descriptor() const { return descriptor_; }
  // Both can only fail where there is nothing to do: it is awake already, or was not woken.
  void wake() { [[maybe_unused]] const int failed = eventfd_write(descriptor_, 1); }
  void clear() {
    eventfd_t count;
    [[maybe_unused]] const int failed = eventfd_read(descriptor_, &count);
  }

 private:
  int descriptor_;
};

void configure(zmq::socket_t& socket, Channel channel) {
  socket.set(zmq::sockopt::maxmsgsize, static_cast<int64_t>(max_message_bytes(channel)));
  socket.set(zmq::sockopt::linger, kLingerMs);
  socket.set(zmq::sockopt::sndhwm, kHighWater);
  socket.set(zmq::sockopt::rcvhwm, kHighWater);
  socket.set(zmq::sockopt::handshake_ivl, kHandshakeMs);
  socket.set(zmq::sockopt::heartbeat_ivl, kZmtpHeartbeatMs);
  socket.set(zmq::sockopt::heartbeat_timeout, kZmtpTimeoutMs);
  socket.set(zmq::sockopt::tcp_keepalive, 1);
}

/// Gives the bytes to zmq without copying them; its I/O thread frees them.
zmq::message_t wrap(MessageBytes bytes) {
  auto* owner = new MessageBytes(std::move(bytes));
  return zmq::message_t(
      owner->data(), owner->size(),
      [](void*, void* hint) { delete static_cast<MessageBytes*>(hint); }, owner);
}

ReceivedMessage received(Channel channel, PeerId peer, zmq::message_t& part) {
  const auto owner = std::make_shared<zmq::message_t>(std::move(part));
  return {channel, std::move(peer), {owner->data<std::byte>(), owner->size()}, owner};
}

/// All parts of the next message, or none.
std::vector<zmq::message_t> receive_parts(zmq::socket_t& socket) {
  std::vector<zmq::message_t> parts;
  try {
    do {
      zmq::message_t part;
      if (!socket.recv(part, zmq::recv_flags::dontwait)) return {};
      parts.push_back(std::move(part));
    } while (parts.back().more());
  } catch (const zmq::error_t& error) {
    if (error.num() != EINTR) throw;
    return {};
  }
  return parts;
}

void poll(std::span<zmq::pollitem_t> items, std::chrono::milliseconds timeout) {
  try {
    zmq::poll(items.data(), items.size(), timeout);
  } catch (const zmq::error_t& error) {
    if (error.num() != EINTR) throw;
  }
}

class ZmqServer final : public ServerTransport {
 public:
  explicit ZmqServer(const Endpoint& endpoint)
      : control_(context_, zmq::socket_type::router), bulk_(context_, zmq::socket_type::router) {
    for (const auto& [socket, channel] :
         {std::pair{&control_, Channel::control}, std::pair{&bulk_, Channel::bulk}}) {
      configure(*socket, channel);
      socket->set(zmq::sockopt::router_mandatory, 1);
      if (endpoint.host.starts_with("[")) socket->set(zmq::sockopt::ipv6, 1);
    }
    Endpoint bulk = endpoint;
    if (!endpoint.tcp) bulk.path += ".bulk";
    if (endpoint.tcp && endpoint.port != 0) ++bulk.port;
    // Both, before anything is bound: a bound socket takes the place of what is at its path.
    for (const Endpoint& each : {endpoint, bulk}) {
      if (has_file(each)) SocketFile::check_free(each.path);
    }
    endpoint_ = bind(control_, endpoint, control_file_);
    bulk = parse_endpoint(bind(bulk_, bulk, bulk_file_));
    bulk_endpoint_ = bulk.tcp ? fmt::format("tcp://:{}", bulk.port) : bulk.str();
  }

  std::string endpoint() const override { return endpoint_; }
  std::string bulk_endpoint() const override { return bulk_endpoint_; }

  void wait(std::chrono::milliseconds timeout) override {
    std::array<zmq::pollitem_t, 3> items = {{{control_.handle(), 0, ZMQ_POLLIN, 0},
                                             {bulk_.handle(), 0, ZMQ_POLLIN, 0},
                                             {nullptr, wake_.descriptor(), ZMQ_POLLIN, 0}}};
    poll(items, timeout);
    wake_.clear();
  }

  std::optional<ReceivedMessage> receive() override {
    for (const Channel channel : {Channel::control, Channel::bulk}) {
      while (true) {
        auto parts = receive_parts(channel == Channel::control ? control_ : bulk_);
        if (parts.empty()) break;
        // Our own clients send one part behind the name of their connection.
        if (parts.size() != 2) continue;
        return received(channel, parts[0].to_string(), parts[1]);
      }
    }
    return std::nullopt;
  }

  SendResult send(Channel channel, const PeerId& peer, MessageBytes bytes) override {
    zmq::socket_t& socket = channel == Channel::control ? control_ : bulk_;
    constexpr auto kFlags = zmq::send_flags::dontwait;
    try {
      if (!socket.send(zmq::buffer(peer), kFlags | zmq::send_flags::sndmore)) {
        return SendResult::full;
      }
      return socket.send(wrap(std::move(bytes)), kFlags) ? SendResult::sent : SendResult::full;
    } catch (const zmq::error_t& error) {
      if (error.num() == EHOSTUNREACH) return SendResult::gone;
      if (error.num() == EINTR) return SendResult::full;
      throw;
    }
  }

  void wake() override { wake_.wake(); }

 private:
  /// Not those in the abstract name space.
  static bool has_file(const Endpoint& endpoint) {
    return !endpoint.tcp && !endpoint.path.starts_with("@");
  }

  static std::string bind(zmq::socket_t& socket, const Endpoint& endpoint, SocketFile& file) {
    try {
      socket.bind(endpoint.str());
    } catch (const zmq::error_t& error) {
      throw usage_error(
          fmt::format("cannot bind endpoint '{}': {}; expected one that is free and "
                      "on this machine",
                      endpoint.str(), error.what()));
    }
    if (has_file(endpoint)) file.own(endpoint.path);
    return socket.get(zmq::sockopt::last_endpoint);
  }

  zmq::context_t context_{1};
  zmq::socket_t control_, bulk_;
  SocketFile control_file_, bulk_file_;
  WakeUp wake_;
  std::string endpoint_, bulk_endpoint_;
};

class ZmqClient final : public ClientTransport {
 public:
  explicit ZmqClient(const Endpoint& endpoint) : endpoint_(endpoint) { reconnect(); }

  void reconnect() override {
    control_.kept.clear();
    control_.kept_bytes = 0;
    open(control_, endpoint_, Channel::control);
  }

  void connect_bulk(const std::string& text) override {
    if (text == bulk_endpoint_) return;
    bulk_endpoint_ = text;
    // "tcp://:PORT" is at the host that control was reached by.
    constexpr std::string_view kSameHost = "tcp://:";
    const std::string full =
        text.starts_with(kSameHost) && endpoint_.tcp
            ? fmt::format("tcp://{}:{}", endpoint_.host, text.substr(kSameHost.size()))
            : text;
    open(bulk_, parse_endpoint(full), Channel::bulk);
  }

  void wait(std::chrono::milliseconds timeout) override {
    std::array<zmq::pollitem_t, 3> items;
    size_t count = 0;
    items[count++] = {nullptr, wake_.descriptor(), ZMQ_POLLIN, 0};
    for (Line* line : {&control_, &bulk_}) {
      if (!line->socket) continue;
      const int events = ZMQ_POLLIN | (line->kept.empty() ? 0 : ZMQ_POLLOUT);
      items[count++] = {line->socket.handle(), 0, static_cast<short>(events), 0};
    }
    poll(std::span(items).first(count), timeout);
    wake_.clear();
    flush(control_);
    flush(bulk_);
  }

  std::optional<ReceivedMessage> receive() override {
    for (Line* line : {&control_, &bulk_}) {
      if (!line->socket) continue;
      while (true) {
        auto parts = receive_parts(line->socket);
        if (parts.empty()) break;
        if (parts.size() != 1) continue;
        return received(line == &control_ ? Channel::control : Channel::bulk, {}, parts[0]);
      }
    }
    return std::nullopt;
  }

  void send(Channel channel, MessageBytes bytes) override {
    Line& line = channel == Channel::control ? control_ : bulk_;
    flush(line);
    const bool full =
        line.kept.size() >= kMaxKept || line.kept_bytes + bytes.size() > kMaxKeptBytes;
    if (full && !line.kept.empty()) return;
    line.kept_bytes += bytes.size();
    line.kept.push_back(wrap(std::move(bytes)));
    flush(line);
  }

  void wake() override { wake_.wake(); }

 private:
  struct Line {
    zmq::socket_t socket;
    std::deque<zmq::message_t> kept;  ///< until the connection takes them
    size_t kept_bytes = 0;
  };

  void open(Line& line, const Endpoint& endpoint, Channel channel) {
    if (line.socket) line.socket.set(zmq::sockopt::linger, 0);
    line.socket = zmq::socket_t(context_, zmq::socket_type::dealer);
    configure(line.socket, channel);
    line.socket.set(zmq::sockopt::immediate, 1);
    line.socket.set(zmq::sockopt::reconnect_ivl, kReconnectMs);
    line.socket.set(zmq::sockopt::reconnect_ivl_max, kReconnectMaxMs);
    if (endpoint.host.starts_with("[")) line.socket.set(zmq::sockopt::ipv6, 1);
    // A signal may come at any moment; who is told to end by one shall do so in order.
    while (zmq_connect(line.socket.handle(), endpoint.str().c_str()) != 0) {
      const zmq::error_t error;
      if (error.num() == EINTR) continue;
      throw usage_error(
          fmt::format("cannot connect to endpoint '{}': {}; expected that of a "
                      "coordinator",
                      endpoint.str(), error.what()));
    }
  }

  static void flush(Line& line) {
    if (!line.socket) return;
    try {
      while (!line.kept.empty()) {
        const size_t size = line.kept.front().size();
        if (!line.socket.send(line.kept.front(), zmq::send_flags::dontwait)) return;
        line.kept.pop_front();
        line.kept_bytes -= size;
      }
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) throw;
    }
  }

  zmq::context_t context_{1};
  Endpoint endpoint_;
  std::string bulk_endpoint_;
  Line control_, bulk_;
  WakeUp wake_;
};

}  // namespace

std::unique_ptr<ServerTransport> bind_server(const std::string& endpoint) {
  const Endpoint parsed = parse_endpoint(endpoint);
  if (!parsed.loopback()) {
    throw usage_error(
        fmt::format("endpoint '{}' can be reached from other machines; expected a "
                    "loopback address such as tcp://127.0.0.1:PORT",
                    endpoint));
  }
  return std::make_unique<ZmqServer>(parsed);
}

std::unique_ptr<ClientTransport> connect_client(const std::string& endpoint) {
  const Endpoint parsed = parse_endpoint(endpoint);
  if (parsed.tcp && parsed.port == 0) {
    throw usage_error(fmt::format("endpoint '{}' has no port; expected tcp://HOST:PORT", endpoint));
  }
  return std::make_unique<ZmqClient>(parsed);
}

}  // namespace tessera
