#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <zmq.hpp>

#include "base/descriptors.h"
#include "base/error.h"
#include "base/monotonic.h"
#include "base/silence.h"
#include "proto/transport/address_finder.h"
#include "proto/transport/endpoint.h"
#include "proto/transport/handshake_monitor.h"
#include "proto/transport/socket_address.h"
#include "proto/transport/zmq_sockets.h"
#include "proto/transport/zmq_transport.h"

namespace tessera {
namespace {

// Of what is kept for a connection that takes nothing. Nothing depends on delivery.
constexpr size_t kMaxKept = 1024, kMaxKeptBytes = size_t{256} << 20;
constexpr int kReconnectMs = 50, kReconnectMaxMs = 5000;
constexpr std::chrono::seconds kRevivePause{1};
/// Where a wait lasts longer than it should by so much, this process did not run.
constexpr std::chrono::seconds kLongestDelay{1};
/// So long the bulk line may be away before it is trouble: a coordinator that is started anew is
/// not.
constexpr std::chrono::seconds kBulkPatience{3};
/// So long nothing may come on it after something was sent there, before it is opened anew: what is
/// in between may hold the connection and forward nothing. Each time in vain doubles that, for a
/// slow line needs long for a message, and to chunks that are sent nothing answers there.
constexpr std::chrono::seconds kBulkSilence{20};

class ZmqClient final : public ClientTransport {
 public:
  ZmqClient(const Endpoint& endpoint, const std::optional<ClientKeys>& keys, ResolveHost resolve)
      : keys_(keys),
        wake_(std::make_shared<WakeUp>()),
        host_(endpoint, std::move(resolve), wake_, monotonic_now()) {
    reconnect();
  }

  void reconnect() override {
    control_.kept.clear();
    control_.kept_bytes = 0;
    open_control();
    // Opened again with the next connect_bulk(): it may be as dead as the other one was.
    close(bulk_);
    bulk_endpoint_.clear();
    bulk_fault_.clear();
  }

  void connect_bulk(const std::string& text) override {
    // "tcp://:PORT" is at the host that control was reached by.
    constexpr std::string_view kSameHost = "tcp://:";
    const auto& control = host_.address();
    const std::string full =
        text.starts_with(kSameHost) && control && control->tcp
            ? fmt::format("tcp://{}:{}", control->host, text.substr(kSameHost.size()))
            : text;
    if (full == bulk_endpoint_) return;
    bulk_endpoint_ = full;
    bulk_absence_.heard(monotonic_now());
    bulk_fault_.clear();
    try {
      const Endpoint bulk = parse_endpoint(bulk_endpoint_);
      if (bulk.tcp && !socket_address(bulk.host, bulk.port)) {
        throw usage_error(fmt::format(
            "scenes and pictures go by '{}'; expected the address of that host", bulk_endpoint_));
      }
      open(bulk_, bulk, Channel::bulk);
    } catch (const Error& error) {  // what the other side says ends nobody
      close(bulk_);
      bulk_fault_ = error.what();
    }
  }

  void wait(std::chrono::milliseconds timeout) override {
    std::array<zmq::pollitem_t, 3> items;
    size_t count = 0;
    items[count++] = {nullptr, wake_->descriptor(), ZMQ_POLLIN, 0};
    for (Line* line : {&control_, &bulk_}) {
      if (!line->socket) continue;
      const int events = ZMQ_POLLIN | (line->kept.empty() ? 0 : ZMQ_POLLOUT);
      items[count++] = {line->socket.handle(), 0, static_cast<short>(events), 0};
    }
    const Time due = monotonic_now() + timeout + kLongestDelay;
    poll_sockets(std::span(items).first(count), timeout);
    bulk_silence_.listen(due, monotonic_now());
    bulk_absence_.listen(due, monotonic_now());
    wake_->clear();
    for (Line* line : {&control_, &bulk_}) {
      if (line->monitor) line->monitor->read();
    }
    const bool connected = control_.monitor && control_.monitor->connected();
    if (host_.update(connected, monotonic_now())) open_control();
    if (!bulk_.monitor || bulk_.monitor->connected()) bulk_absence_.heard(monotonic_now());
    revive_bulk();
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
        ReceivedMessage message;
        message.channel = line == &control_ ? Channel::control : Channel::bulk;
        if (line == &bulk_) {
          is_bulk_asked_ = false;
          bulk_patience_ = kBulkSilence;
        }
        take_bytes(message, parts[0]);
        return message;
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
    if (channel == Channel::bulk && !std::exchange(is_bulk_asked_, true)) {
      bulk_silence_.heard(monotonic_now());
    }
    line.kept_bytes += bytes.size();
    line.kept.push_back(wrap(std::move(bytes)));
    flush(line);
  }

  std::optional<ConnectionTrouble> trouble() const override {
    if (control_.monitor && control_.monitor->trouble()) return control_.monitor->trouble();
    if (!control_.monitor || !control_.monitor->connected()) {
      if (auto trouble = host_.trouble(monotonic_now())) return trouble;
    }
    if (!bulk_fault_.empty()) return ConnectionTrouble{.why = bulk_fault_};
    const Time away = bulk_absence_.length(monotonic_now());
    if (!bulk_.monitor || away < kBulkPatience) return std::nullopt;
    // Never refused: the other line is there, and this one is tried for ever.
    return ConnectionTrouble{
        .why = fmt::format("scenes and pictures go by {}, which does not answer", bulk_endpoint_)};
  }

  std::optional<std::string> resolved_endpoint() const override {
    if (!host_.address()) return std::nullopt;
    return host_.address()->str();
  }

  void wake() override { wake_->wake(); }

 private:
  struct Line {
    zmq::socket_t socket;
    std::deque<zmq::message_t> kept;  ///< until the connection takes them
    size_t kept_bytes = 0;
    std::optional<HandshakeMonitor> monitor;  ///< over TCP
    Time opened{};
  };

  static void close(Line& line) {
    if (!line.socket) return;
    line.socket.set(zmq::sockopt::linger, 0);
    line.monitor.reset();
    line.socket.close();
  }

  /// libzmq tries no more once it was refused; the coordinator may have changed its mind since. The
  /// control line is opened again by who misses its messages.
  void revive_bulk() {
    if (!bulk_.monitor) return;
    const Time now = monotonic_now();
    const bool refused = bulk_.monitor->trouble() && now - bulk_.opened >= kRevivePause;
    const bool silent = is_bulk_asked_ && bulk_silence_.length(now) >= bulk_patience_;
    if (!refused && !silent) return;
    if (silent) {
      is_bulk_asked_ = false;
      bulk_patience_ *= 2;
    }
    open(bulk_, parse_endpoint(bulk_endpoint_), Channel::bulk);
  }

  /// Where the host's address is not known yet, there is no socket, and messages are kept.
  void open_control() {
    if (host_.address()) {
      open(control_, *host_.address(), Channel::control);
    } else {
      close(control_);
    }
  }

  /// `endpoint` by address: names would be resolved by the thread that serves all sockets.
  void open(Line& line, const Endpoint& endpoint, Channel channel) {
    close(line);
    line.opened = monotonic_now();
    line.socket = zmq::socket_t(context_, zmq::socket_type::dealer);
    configure(line.socket, channel);
    line.socket.set(zmq::sockopt::immediate, 1);
    line.socket.set(zmq::sockopt::reconnect_ivl, kReconnectMs);
    line.socket.set(zmq::sockopt::reconnect_ivl_max, kReconnectMaxMs);
    if (endpoint.host.starts_with("[")) line.socket.set(zmq::sockopt::ipv6, 1);
    if (keys_) protect(line.socket, *keys_);
    if (endpoint.tcp) line.monitor.emplace(context_, line.socket, keys_.has_value());
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

  static void protect(zmq::socket_t& socket, const ClientKeys& keys) {
    const auto buffer = [](const Key& key) { return zmq::const_buffer(key.data(), key.size()); };
    socket.set(zmq::sockopt::curve_serverkey, buffer(keys.server));
    socket.set(zmq::sockopt::curve_publickey, buffer(keys.own.public_key));
    socket.set(zmq::sockopt::curve_secretkey, buffer(keys.own.secret_key));
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
  std::optional<ClientKeys> keys_;
  std::shared_ptr<WakeUp> wake_;  ///< shared with threads that resolve the host's name
  AddressFinder host_;
  std::string bulk_endpoint_;
  std::string bulk_fault_;  ///< why there can be no bulk line
  Line control_, bulk_;
  Silence bulk_absence_{Time{0}};  ///< since it was last connected, or had no need to be
  bool is_bulk_asked_ = false;     ///< something was sent there, and nothing came since
  Silence bulk_silence_{Time{0}};  ///< since then
  Time bulk_patience_ = kBulkSilence;
};

}  // namespace

std::unique_ptr<ClientTransport> connect_client(const std::string& endpoint,
                                                const std::optional<ClientKeys>& keys,
                                                ResolveHost resolve) {
  const Endpoint parsed = parse_endpoint(endpoint);
  if (parsed.tcp && parsed.port == 0) {
    throw usage_error(fmt::format("endpoint '{}' has no port; expected tcp://HOST:PORT", endpoint));
  }
  check_zone(parsed);
  check_room_for_descriptors(kTransportDescriptors);
  return std::make_unique<ZmqClient>(parsed, keys, std::move(resolve));
}

}  // namespace tessera
