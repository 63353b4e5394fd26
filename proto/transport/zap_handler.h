#pragma once

#include <set>
#include <string>
#include <zmq.hpp>

#include "proto/transport/allow_list.h"

namespace tessera {

/// Says whom the sockets of a context let in (ZeroMQ RFC 27): who proves that it has the secret key
/// of one on the list. Its thread is that of the sockets; the connections wait until it answers.
class ZapHandler {
 public:
  /// To be made before any socket of `context` is bound, and to outlive them all: CURVE lets in
  /// whoever finds no handler.
  explicit ZapHandler(zmq::context_t& context);

  /// Makes `socket` a server that nobody reaches but through this.
  static void protect(zmq::socket_t& socket, const KeyPair& keys);

  /// To poll for what to answer.
  zmq::socket_t& socket() { return socket_; }
  /// Answers all who wait.
  void answer();
  /// Whose message this is; null where the key is not on the list any more.
  const AllowedKey* sender(const zmq::message_t& message) const;

  const AllowList& allowed() const { return allowed_; }
  void set_allowed(AllowList allowed);

 private:
  void log_refusal(const std::string& key, const std::string& address);

  zmq::socket_t socket_;
  AllowList allowed_;
  std::set<std::string> told_;  ///< keys whose refusal is in the log
};

/// The key by which the sender of a message was let in, as of key_text(); empty: there was none.
std::string key_of(const zmq::message_t& message);

}  // namespace tessera
