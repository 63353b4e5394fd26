#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "proto/transport/allow_list.h"

namespace tessera {

/// Blobs go by `bulk`, everything else by `control`.
enum class Channel : uint8_t { control, bulk };

/// Longer messages are not taken: their sender is disconnected.
constexpr size_t max_message_bytes(Channel channel) {
  return size_t{channel == Channel::control ? 2u : 4u} << 20;
}

/// The bytes of one message; what they mean is not known here.
using MessageBytes = Bytes;

/// The name that the transport gave to a connection: opaque, unique within a channel, new at each
/// reconnection.
using PeerId = std::string;

struct ReceivedMessage {
  Channel channel = Channel::control;
  PeerId peer;  ///< empty at a client: there is only the server
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> owner;  ///< of the bytes, which are where they came in
  AllowedKey
      sender{};  ///< as the server's list has it; any, without a name, where no keys are used
};

enum class SendResult {
  sent,
  full,  ///< the peer does not read: the message was dropped
  gone,  ///< there is no such connection any more
};

/// The coordinator's end. One thread owns it; only wake() may be called from others.
class ServerTransport {
 public:
  virtual ~ServerTransport() = default;
  /// The control endpoint that clients can use, with the port that was really bound.
  virtual std::string endpoint() const = 0;
  /// All of them, where a server has several.
  virtual std::vector<std::string> endpoints() const { return {endpoint()}; }
  /// The bulk endpoint in the form of Welcome.bulk_endpoint; empty where clients need none.
  virtual std::string bulk_endpoint() const = 0;
  /// The same for that peer, which may have come by another endpoint than others.
  virtual std::string bulk_endpoint_for(const PeerId&) const { return bulk_endpoint(); }
  /// Whether that peer comes over a network, where bytes are dear.
  virtual bool comes_by_network(const PeerId&) const { return endpoint().starts_with("tcp://"); }
  /// Returns when a message may be there, wake() was called or `timeout` has passed.
  virtual void wait(std::chrono::milliseconds timeout) = 0;
  /// The next message, those of `control` first. Does not block.
  virtual std::optional<ReceivedMessage> receive() = 0;
  /// Does not block.
  virtual SendResult send(Channel channel, const PeerId& peer, MessageBytes bytes) = 0;
  /// From now on nobody else is let in, heard or sent to. Returns the control peers that this shut
  /// out. Without keys it does nothing.
  virtual std::vector<PeerId> set_allowed(AllowList) { return {}; }
  /// The network address of a peer that has spoken on `control`, for the log; empty where it is not
  /// known.
  virtual std::string address(const PeerId&) const { return {}; }
  virtual void wake() = 0;
};

/// Why no connection came about.
struct ConnectionTrouble {
  std::string why;
  bool refused = false;          ///< the server said so: trying again is of no use as things are
  bool is_unknown_host = false;  ///< it is certain that the name of its host has no address
  /// That failed one after the other; those that were hung up on without a reason do not count.
  int attempts = 1;
};

/// The end of a worker or client. One thread owns it; only wake() may be called from others.
class ClientTransport {
 public:
  virtual ~ClientTransport() = default;
  /// Where blobs are, as the server told it. Calling it again with the same endpoint does nothing.
  virtual void connect_bulk(const std::string& bulk_endpoint) = 0;
  virtual void wait(std::chrono::milliseconds timeout) = 0;
  virtual std::optional<ReceivedMessage> receive() = 0;
  /// Sends, or keeps what cannot be sent yet for a later wait(), up to a bound: past it, messages
  /// are dropped. Does not block.
  virtual void send(Channel channel, MessageBytes bytes) = 0;
  /// Drops this connection and makes a new one: to the server, a new peer.
  virtual void reconnect() = 0;
  /// What went wrong the last time, if no connection has come about since.
  virtual std::optional<ConnectionTrouble> trouble() const { return std::nullopt; }
  /// The endpoint by the address that its host's name was found to have, or as it is where it has
  /// no name. Nullopt where none is found yet, or by a transport without endpoints.
  virtual std::optional<std::string> resolved_endpoint() const { return std::nullopt; }
  virtual void wake() = 0;
};

}  // namespace tessera
