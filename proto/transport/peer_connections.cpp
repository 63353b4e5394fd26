#include "proto/transport/peer_connections.h"

#include <netdb.h>

#include <array>
#include <cstring>

#include "proto/transport/zap_handler.h"

namespace tessera {
namespace {

// Workers speak each second, clients more often. One that did not for so long is ended when it
// does.
constexpr std::chrono::minutes kSilence{10};
constexpr std::chrono::minutes kLookEvery{1};

int descriptor_of(const zmq::message_t& message) {
  // It takes its message as not const, and changes nothing.
  return zmq_msg_get(const_cast<zmq::message_t&>(message).handle(), ZMQ_SRCFD);
}

sockaddr_storage address_of(int descriptor) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  return address;
}

}  // namespace

void PeerConnections::note(Channel channel, const PeerId& peer, const zmq::message_t& message) {
  const Clock::time_point now = Clock::now();
  if (now >= next_look_) forget_silent(now);
  const auto [it, fresh] = connections_.try_emplace({channel, peer});
  it->second.last = now;
  if (!fresh) return;
  it->second.key = tessera::key_of(message);
  it->second.descriptor = descriptor_of(message);
  it->second.address = address_of(it->second.descriptor);
}

void PeerConnections::forget_silent(Clock::time_point now) {
  next_look_ = now + kLookEvery;
  std::erase_if(connections_, [&](const auto& c) { return now - c.second.last > kSilence; });
}

const std::string& PeerConnections::key_of_peer(Channel channel, const PeerId& peer) const {
  static const std::string kNone;
  const auto it = connections_.find({channel, peer});
  return it == connections_.end() ? kNone : it->second.key;
}

std::string PeerConnections::address_of_peer(Channel channel, const PeerId& peer) const {
  const auto it = connections_.find({channel, peer});
  if (it == connections_.end()) return {};
  std::array<char, NI_MAXHOST> host{};
  const auto* const address = reinterpret_cast<const sockaddr*>(&it->second.address);
  const int failed = getnameinfo(address, sizeof it->second.address, host.data(), host.size(),
                                 nullptr, 0, NI_NUMERICHOST);
  return failed ? "" : host.data();
}

void PeerConnections::end(const Connection& connection) {
  const sockaddr_storage now = address_of(connection.descriptor);
  // Local sockets have no address to tell them by: what comes from them is dropped all the same.
  const bool is_tcp = now.ss_family == AF_INET || now.ss_family == AF_INET6;
  if (!is_tcp || std::memcmp(&now, &connection.address, sizeof now) != 0) return;
  shutdown(connection.descriptor, SHUT_RDWR);
}

void PeerConnections::end(const zmq::message_t& message) {
  Connection connection;
  connection.descriptor = descriptor_of(message);
  connection.address = address_of(connection.descriptor);
  end(connection);
}

std::vector<PeerId> PeerConnections::end_all_but(const AllowList& allowed) {
  std::vector<PeerId> ended;
  for (const auto& [place, connection] : connections_) {
    if (allowed.admitted(connection.key)) continue;
    end(connection);
    if (place.first == Channel::control) ended.push_back(place.second);
  }
  return ended;
}

}  // namespace tessera
