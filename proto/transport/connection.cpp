#include "proto/transport/connection.h"

#include <linux/tcp.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <array>
#include <cstring>

namespace tessera {
namespace {

/// 0 for what is no socket.
ino_t socket_inode(int descriptor) {
  struct stat about {};
  return fstat(descriptor, &about) == 0 && S_ISSOCK(about.st_mode) ? about.st_ino : 0;
}

/// Of the other side; of no family where there is none.
sockaddr_storage address_of(int descriptor) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  return address;
}

}  // namespace

Connection::Connection(int descriptor)
    : descriptor_(descriptor), inode_(socket_inode(descriptor)) {}

void Connection::end() const {
  if (inode_ != 0 && socket_inode(descriptor_) == inode_) shutdown(descriptor_, SHUT_RDWR);
}

std::optional<uint64_t> Connection::network() const {
  const sockaddr_storage address = address_of(descriptor_);
  if (address.ss_family == AF_INET) {
    return reinterpret_cast<const sockaddr_in&>(address).sin_addr.s_addr;
  }
  if (address.ss_family != AF_INET6) return std::nullopt;
  const in6_addr& ip = reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
  if (IN6_IS_ADDR_V4MAPPED(&ip)) {
    uint32_t ipv4;
    std::memcpy(&ipv4, ip.s6_addr + 12, sizeof ipv4);
    return ipv4;
  }
  uint64_t site;
  std::memcpy(&site, ip.s6_addr, sizeof site);
  return site;
}

std::string Connection::peer() const {
  const sockaddr_storage address = address_of(descriptor_);
  std::array<char, NI_MAXHOST> text{};
  if (getnameinfo(reinterpret_cast<const sockaddr*>(&address), sizeof address, text.data(),
                  text.size(), nullptr, 0, NI_NUMERICHOST) != 0) {
    return "this machine";
  }
  return text.data();
}

uint64_t Connection::sent_bytes() const {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (getsockopt(descriptor_, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return 0;
  return info.tcpi_bytes_sent - info.tcpi_bytes_retrans;
}

}  // namespace tessera
