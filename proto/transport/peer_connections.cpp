#include "proto/transport/peer_connections.h"

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

}  // namespace

void PeerConnections::note(Channel channel, const PeerId& peer, const zmq::message_t& message) {
  const Clock::time_point now = Clock::now();
  if (now >= next_look_) forget_silent(now);
  const auto [it, fresh] = peers_.try_emplace({channel, peer});
  it->second.last = now;
  if (!fresh) return;
  it->second.key = tessera::key_of(message);
  it->second.connection = Connection(descriptor_of(message));
}

void PeerConnections::forget_silent(Clock::time_point now) {
  next_look_ = now + kLookEvery;
  std::erase_if(peers_, [&](const auto& c) { return now - c.second.last > kSilence; });
}

const std::string& PeerConnections::key_of_peer(Channel channel, const PeerId& peer) const {
  static const std::string kNone;
  const auto it = peers_.find({channel, peer});
  return it == peers_.end() ? kNone : it->second.key;
}

std::string PeerConnections::address_of_peer(Channel channel, const PeerId& peer) const {
  const auto it = peers_.find({channel, peer});
  return it == peers_.end() ? "" : it->second.connection.peer();
}

void PeerConnections::end(const zmq::message_t& message) {
  Connection(descriptor_of(message)).end();
}

std::vector<PeerId> PeerConnections::end_all_but(const AllowList& allowed) {
  std::vector<PeerId> ended;
  for (const auto& [place, peer] : peers_) {
    if (allowed.admitted(peer.key)) continue;
    peer.connection.end();
    if (place.first == Channel::control) ended.push_back(place.second);
  }
  return ended;
}

}  // namespace tessera
