#pragma once

#include <string>

namespace tessera {

/// ipc://PATH or tcp://HOST:PORT in its parts.
struct Endpoint {
  bool tcp = false;
  std::string path;  ///< ipc
  std::string host;  ///< tcp; an IPv6 address stands in brackets, its zone inside
  int port = 0;      ///< tcp; 0: any that is free

  std::string str() const;
  /// Whether only this machine can reach it.
  bool loopback() const;
};

/// Throws usage_error for any other text.
Endpoint parse_endpoint(const std::string& text);

/// Throws usage_error where the host is an address of IPv6 that has no place in a network: a
/// link-local one is of each network, so that it needs a zone (RFC 4007), an interface of this
/// machine, which no other address has.
void check_zone(const Endpoint& endpoint);

}  // namespace tessera
