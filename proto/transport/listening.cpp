#include "proto/transport/listening.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "base/error.h"
#include "proto/transport/endpoint.h"

namespace tessera {
namespace {

constexpr int kPatienceMs = 500;

/// The error of connecting to that address; 0: none, or it is not known in time.
int connect_error(const sockaddr* address, socklen_t length) {
  const int file = socket(address->sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (file < 0) return 0;
  int error = connect(file, address, length) == 0 ? 0 : errno;
  if (error == EINPROGRESS) {
    pollfd wait{file, POLLOUT, 0};
    socklen_t size = sizeof error;
    error = 0;
    if (poll(&wait, 1, kPatienceMs) > 0) getsockopt(file, SOL_SOCKET, SO_ERROR, &error, &size);
  }
  close(file);
  return error;
}

bool no_socket(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return false;
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const int error = connect_error(reinterpret_cast<const sockaddr*>(&address), sizeof address);
  return error == ENOENT || error == ECONNREFUSED;
}

bool all_refuse(const Endpoint& endpoint) {
  std::string host = endpoint.host;
  if (host.starts_with("[")) host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), std::to_string(endpoint.port).c_str(), &hints, &found) != 0) {
    return false;
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> addresses(found, freeaddrinfo);
  for (const addrinfo* a = addresses.get(); a; a = a->ai_next) {
    if (connect_error(a->ai_addr, a->ai_addrlen) != ECONNREFUSED) return false;
  }
  return true;
}

}  // namespace

bool nobody_listens(const std::string& text) {
  try {
    const Endpoint endpoint = parse_endpoint(text);
    return endpoint.tcp ? all_refuse(endpoint) : no_socket(endpoint.path);
  } catch (const Error&) {
    return false;
  }
}

}  // namespace tessera
