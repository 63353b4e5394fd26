#pragma once

#include <sys/socket.h>

#include <optional>
#include <string>

namespace tessera {

/// What the system calls need to know of an address. Internal to proto/transport.
struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t size = 0;

  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
  /// As Endpoint::host spells it: in digits, an IPv6 address in brackets.
  std::string host() const;
  bool is_loopback() const;
};

/// The address that `host` spells in digits, IPv6 in brackets; nullopt where it is a name or `*`.
/// Never asks a name server.
std::optional<SocketAddress> socket_address(const std::string& host, int port);

}  // namespace tessera
