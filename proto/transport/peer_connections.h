#pragma once

#include <chrono>
#include <map>
#include <string>
#include <utility>
#include <vector>
#include <zmq.hpp>

#include "proto/transport/allow_list.h"
#include "proto/transport/connection.h"
#include "proto/transport/transport.h"

namespace tessera {

/// The connections behind a server's peers, so that those of a key can be ended: ZeroMQ itself ends
/// no single connection. Internal to proto/transport.
class PeerConnections {
 public:
  /// A message has come from that peer.
  void note(Channel channel, const PeerId& peer, const zmq::message_t& message);
  /// The key of that peer, or an empty text.
  const std::string& key_of_peer(Channel channel, const PeerId& peer) const;
  /// Its network address as digits, or an empty text.
  std::string address_of_peer(Channel channel, const PeerId& peer) const;
  /// Ends the connections of all whose key is not on the list; returns the control peers of those.
  std::vector<PeerId> end_all_but(const AllowList& allowed);
  /// Ends the connection that this message came by.
  static void end(const zmq::message_t& message);

 private:
  using Clock = std::chrono::steady_clock;
  struct Peer {
    std::string key;
    Connection connection;
    Clock::time_point last{};
  };
  void forget_silent(Clock::time_point now);

  std::map<std::pair<Channel, PeerId>, Peer> peers_;
  Clock::time_point next_look_{};
};

}  // namespace tessera
