#include "proto/transport/socket_address.h"

#include <netdb.h>
#include <netinet/in.h>

#include <array>
#include <cstring>
#include <memory>

namespace tessera {

std::string SocketAddress::host() const {
  std::array<char, NI_MAXHOST> text{};
  if (getnameinfo(get(), size, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) != 0) {
    return {};
  }
  const bool ipv6 = storage.ss_family == AF_INET6;
  return ipv6 ? "[" + std::string(text.data()) + "]" : text.data();
}

bool SocketAddress::is_loopback() const {
  if (storage.ss_family == AF_INET) {
    const auto& ip = reinterpret_cast<const sockaddr_in&>(storage).sin_addr;
    return ntohl(ip.s_addr) >> 24 == IN_LOOPBACKNET;
  }
  return IN6_IS_ADDR_LOOPBACK(&reinterpret_cast<const sockaddr_in6&>(storage).sin6_addr);
}

std::optional<SocketAddress> socket_address(const std::string& host, int port) {
  if (host == "*") return std::nullopt;  // for which glibc has this machine's own address
  const bool ipv6 = host.size() > 2 && host.starts_with("[") && host.ends_with("]");
  const std::string digits = ipv6 ? host.substr(1, host.size() - 2) : host;
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_family = ipv6 ? AF_INET6 : AF_INET;
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (getaddrinfo(digits.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) {
    return std::nullopt;
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, freeaddrinfo);
  SocketAddress address;
  std::memcpy(&address.storage, found->ai_addr, found->ai_addrlen);
  address.size = found->ai_addrlen;
  return address;
}

}  // namespace tessera
