#include <fmt/format.h>
#include <net/if.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <span>
#include <utility>
#include <vector>
#include <zmq.hpp>

#include "base/descriptors.h"
#include "base/error.h"
#include "base/owned_descriptor.h"
#include "proto/transport/accept_guard.h"
#include "proto/transport/endpoint.h"
#include "proto/transport/peer_connections.h"
#include "proto/transport/socket_address.h"
#include "proto/transport/socket_file.h"
#include "proto/transport/zap_handler.h"
#include "proto/transport/zmq_sockets.h"
#include "proto/transport/zmq_transport.h"

namespace tessera {
namespace {

/// Connections that the system keeps until libzmq accepts them, so that of many that come at once
/// none is dropped, which it would notice seconds later. The system may keep fewer (somaxconn).
constexpr int kBacklog = 4096;
/// Name servers may be slow when a machine starts.
constexpr std::chrono::seconds kResolvePatience{10};

class ZmqServer final : public ServerTransport {
 public:
  ZmqServer(const Endpoint& endpoint, ServerSecurity security)
      : control_(context_, zmq::socket_type::router), bulk_(context_, zmq::socket_type::router) {
    if (security.keys) zap_.emplace(context_).set_allowed(std::move(security.allowed));
    for (const auto& [socket, channel] :
         {std::pair{&control_, Channel::control}, std::pair{&bulk_, Channel::bulk}}) {
      configure(*socket, channel);
      socket->set(zmq::sockopt::router_mandatory, 1);
      socket->set(zmq::sockopt::backlog, kBacklog);
      if (security.keys) ZapHandler::protect(*socket, *security.keys);
      // A socket of IPv6 has `*` for both families, where the machine has IPv6 at all.
      if (endpoint.host.starts_with("[") || endpoint.host == "*") {
        socket->set(zmq::sockopt::ipv6, 1);
      }
    }
    guard_.emplace(context_, std::vector{&control_, &bulk_}, zap_.has_value());
    Endpoint bulk = endpoint;
    if (!endpoint.tcp) bulk.path += ".bulk";
    if (endpoint.tcp && endpoint.port != 0) ++bulk.port;
    // Both, before anything is bound: a bound socket takes the place of what is at its path.
    for (const Endpoint& each : {endpoint, bulk}) {
      if (has_file(each)) SocketFile::check_free(each.path);
    }
    endpoint_ = bind(control_, endpoint, control_file_);
    try {
      bulk = parse_endpoint(bind(bulk_, bulk, bulk_file_));
    } catch (const Error& error) {
      throw Error(error.code(), fmt::format("{} (scenes and pictures go there, beside '{}')",
                                            error.what(), endpoint.str()));
    }
    bulk_endpoint_ = bulk.tcp ? fmt::format("tcp://:{}", bulk.port) : bulk.str();
  }

  std::string endpoint() const override { return endpoint_; }
  std::string bulk_endpoint() const override { return bulk_endpoint_; }

  void wait(std::chrono::milliseconds timeout) override {
    std::vector<zmq::pollitem_t> items;
    add_waited_for(items);
    poll_sockets(items, timeout);
    end_wait();
  }
  /// What wait() waits for, for who waits for more than that, and calls end_wait() then.
  void add_waited_for(std::vector<zmq::pollitem_t>& items) {
    items.push_back({control_.handle(), 0, ZMQ_POLLIN, 0});
    items.push_back({bulk_.handle(), 0, ZMQ_POLLIN, 0});
    items.push_back({nullptr, wake_.descriptor(), ZMQ_POLLIN, 0});
    if (zap_) items.push_back({zap_->socket().handle(), 0, ZMQ_POLLIN, 0});
  }
  void end_wait() {
    wake_.clear();
    if (zap_) zap_->answer();
  }

  std::optional<ReceivedMessage> receive() override {
    for (const Channel channel : {Channel::control, Channel::bulk}) {
      while (true) {
        auto parts = receive_parts(channel == Channel::control ? control_ : bulk_);
        if (parts.empty()) break;
        // Our own clients send one part behind the name of their connection.
        if (parts.size() != 2) continue;
        ReceivedMessage message;
        message.channel = channel;
        message.peer = parts[0].to_string();
        if (zap_ && !admit(message, parts[1])) continue;
        take_bytes(message, parts[1]);
        return message;
      }
    }
    return std::nullopt;
  }

  SendResult send(Channel channel, const PeerId& peer, MessageBytes bytes) override {
    zmq::socket_t& socket = channel == Channel::control ? control_ : bulk_;
    if (zap_ && is_shut_out(channel, peer)) return SendResult::gone;
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

  std::vector<PeerId> set_allowed(AllowList allowed) override {
    if (!zap_) return {};
    zap_->set_allowed(std::move(allowed));
    return connections_.end_all_but(zap_->allowed());
  }

  std::string address(const PeerId& peer) const override {
    return connections_.address_of_peer(Channel::control, peer);
  }

  void wake() override { wake_.wake(); }

 private:
  /// Notes who sent it. False where that key was taken off the list since it was let in.
  bool admit(ReceivedMessage& message, const zmq::message_t& part) {
    const AllowedKey* const sender = zap_->sender(part);
    if (!sender) {
      PeerConnections::end(part);
      return false;
    }
    message.sender = *sender;
    connections_.note(message.channel, message.peer, part);
    return true;
  }

  bool is_shut_out(Channel channel, const PeerId& peer) const {
    const std::string& key = connections_.key_of_peer(channel, peer);
    return !key.empty() && !zap_->allowed().admitted(key);
  }

  /// Not those in the abstract name space.
  static bool has_file(const Endpoint& endpoint) {
    return !endpoint.tcp && !endpoint.path.starts_with("@");
  }

  static std::string bind(zmq::socket_t& socket, const Endpoint& endpoint, SocketFile& file) {
    try {
      socket.bind(endpoint.str());
    } catch (const zmq::error_t& error) {
      const std::string what = fmt::format(
          "cannot bind endpoint '{}': {}; expected one that is free and on this machine",
          endpoint.str(), error.what());
      throw error.num() == EADDRINUSE ? temporary_error(what) : usage_error(what);
    }
    if (has_file(endpoint)) file.own(endpoint.path);
    return socket.get(zmq::sockopt::last_endpoint);
  }

  zmq::context_t context_{1};
  std::optional<ZapHandler> zap_;  ///< where there are keys
  PeerConnections connections_;    ///< of those let in by a key
  zmq::socket_t control_, bulk_;
  std::optional<AcceptGuard> guard_;  ///< always there once bound
  SocketFile control_file_, bulk_file_;
  WakeUp wake_;
  std::string endpoint_, bulk_endpoint_;
};

/// Several servers as one: the name of a peer has the number of its own before it.
class JoinedServers final : public ServerTransport {
 public:
  explicit JoinedServers(std::vector<std::unique_ptr<ZmqServer>> servers)
      : servers_(std::move(servers)) {}

  std::string endpoint() const override { return servers_.front()->endpoint(); }
  std::vector<std::string> endpoints() const override {
    std::vector<std::string> all;
    for (const auto& server : servers_) all.push_back(server->endpoint());
    return all;
  }
  std::string bulk_endpoint() const override { return servers_.front()->bulk_endpoint(); }
  std::string bulk_endpoint_for(const PeerId& peer) const override {
    return server_of(peer).bulk_endpoint();
  }
  bool comes_by_network(const PeerId& peer) const override {
    return server_of(peer).comes_by_network({});
  }

  void wait(std::chrono::milliseconds timeout) override {
    std::vector<zmq::pollitem_t> items;
    for (const auto& server : servers_) server->add_waited_for(items);
    poll_sockets(items, timeout);
    for (const auto& server : servers_) server->end_wait();
  }

  std::optional<ReceivedMessage> receive() override {
    // In turn, so that none is kept waiting by another.
    for (size_t i = 0; i < servers_.size(); ++i) {
      const size_t server = next_;
      next_ = (next_ + 1) % servers_.size();
      if (auto message = servers_[server]->receive()) {
        message->peer = joined_name(server, message->peer);
        return message;
      }
    }
    return std::nullopt;
  }

  SendResult send(Channel channel, const PeerId& peer, MessageBytes bytes) override {
    return server_of(peer).send(channel, peer.substr(1), std::move(bytes));
  }

  std::vector<PeerId> set_allowed(AllowList allowed) override {
    std::vector<PeerId> ended;
    for (size_t i = 0; i < servers_.size(); ++i) {
      for (const PeerId& peer : servers_[i]->set_allowed(allowed))
        ended.push_back(joined_name(i, peer));
    }
    return ended;
  }

  std::string address(const PeerId& peer) const override {
    return server_of(peer).address(peer.substr(1));
  }

  void wake() override { servers_.front()->wake(); }

 private:
  static PeerId joined_name(size_t server, const PeerId& peer) {
    return static_cast<char>(server) + peer;
  }
  ZmqServer& server_of(const PeerId& peer) const {
    return *servers_.at(static_cast<size_t>(peer.at(0)));
  }

  std::vector<std::unique_ptr<ZmqServer>> servers_;
  size_t next_ = 0;  ///< whose message is received next
};

/// Whether this machine has the address, as far as can be told.
bool is_of_this_machine(const std::string& host) {
  const auto address = socket_address(host, 0);
  if (!address) return false;
  const OwnedDescriptor probe(socket(address->get()->sa_family, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  return ::bind(probe.get(), address->get(), address->size) == 0;
}

/// The address to bind for a host: libzmq resolves no names there. Of several that of this machine.
std::string bound_host(const Endpoint& endpoint) {
  const std::string& host = endpoint.host;
  const bool is_interface = if_nametoindex(host.c_str()) != 0;
  if (host == "*" || is_interface || socket_address(host, endpoint.port)) return host;
  const ResolvedHost found = resolve_within(kResolvePatience, host);
  if (!found.addresses.empty()) {
    const auto here =
        std::find_if(found.addresses.begin(), found.addresses.end(), is_of_this_machine);
    return here == found.addresses.end() ? found.addresses.front() : *here;
  }
  if (!found.is_unknown) {
    throw temporary_error(fmt::format("cannot bind endpoint '{}': its host cannot be resolved: {}",
                                      endpoint.str(), found.failure));
  }
  throw usage_error(fmt::format(
      "cannot bind endpoint '{}': the name of the host is unknown; expected one of this "
      "machine, or an address",
      endpoint.str()));
}

std::unique_ptr<ZmqServer> bind_one(const std::string& endpoint, ServerSecurity security) {
  Endpoint parsed = parse_endpoint(endpoint);
  if (!parsed.loopback() && !security.keys && !security.insecure) {
    throw usage_error(
        fmt::format("endpoint '{}' can be reached from other machines; expected keys (--key and "
                    "--allow), or a loopback address such as tcp://127.0.0.1:PORT",
                    endpoint));
  }
  if (parsed.tcp && parsed.port == 65535) {
    throw usage_error(fmt::format(
        "endpoint '{}': scenes and pictures go by the port after it, and there is none; expected a "
        "port from 1 to 65534",
        endpoint));
  }
  check_zone(parsed);
  if (parsed.tcp) parsed.host = bound_host(parsed);
  check_room_for_descriptors(kTransportDescriptors);
  return std::make_unique<ZmqServer>(parsed, std::move(security));
}

}  // namespace

std::unique_ptr<ServerTransport> bind_server(const std::string& endpoint, ServerSecurity security) {
  return bind_one(endpoint, std::move(security));
}

std::unique_ptr<ServerTransport> bind_servers(std::vector<ServerDoor> doors) {
  std::vector<std::unique_ptr<ZmqServer>> servers;
  for (ServerDoor& door : doors)
    servers.push_back(bind_one(door.endpoint, std::move(door.security)));
  return std::make_unique<JoinedServers>(std::move(servers));
}

}  // namespace tessera
