#include "proto/transport/listening.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>

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

struct Addresses {
  int error = 0;  ///< as getaddrinfo() tells it
  std::unique_ptr<addrinfo, void (*)(addrinfo*)> first{nullptr, freeaddrinfo};
};

Addresses addresses_of(const Endpoint& endpoint) {
  std::string host = endpoint.host;
  if (host.starts_with("[")) host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  Addresses addresses;
  const std::string port = std::to_string(endpoint.port);
  addresses.error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  if (addresses.error == 0) addresses.first.reset(found);
  return addresses;
}

bool all_refuse(const Endpoint& endpoint) {
  const Addresses addresses = addresses_of(endpoint);
  if (addresses.error != 0) return false;
  for (const addrinfo* a = addresses.first.get(); a; a = a->ai_next) {
    if (connect_error(a->ai_addr, a->ai_addrlen) != ECONNREFUSED) return false;
  }
  return true;
}

std::optional<Endpoint> endpoint_of(const std::string& text) {
  try {
    return parse_endpoint(text);
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace

bool is_unknown_host(const std::string& text) {
  const auto endpoint = endpoint_of(text);
  if (!endpoint || !endpoint->tcp) return false;
  const int error = addresses_of(*endpoint).error;
  return error == EAI_NONAME || error == EAI_NODATA;
}

bool nobody_listens(const std::string& text) {
  const auto endpoint = endpoint_of(text);
  if (!endpoint) return false;
  return endpoint->tcp ? all_refuse(*endpoint) : no_socket(endpoint->path);
}

}  // namespace tessera
