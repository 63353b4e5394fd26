#include "proto/transport/listening.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "base/monotonic.h"
#include "proto/transport/endpoint.h"
#include "proto/transport/socket_address.h"

namespace tessera {
namespace {

constexpr int kPatienceMs = 500;
constexpr Time kNextBegins = std::chrono::milliseconds(250);  // RFC 8305, section 8
constexpr Time kRacePatience = std::chrono::seconds(3);

/// A connection that is being made and is of no use but to know whether it can be.
class Attempt {
 public:
  Attempt(const sockaddr* address, socklen_t length)
      : file_(socket(address->sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
    if (file_ < 0 || connect(file_, address, length) != 0) error_ = errno;
  }
  ~Attempt() {
    if (file_ >= 0) close(file_);
  }
  Attempt(Attempt&& other) noexcept : file_(std::exchange(other.file_, -1)), error_(other.error_) {}
  Attempt& operator=(Attempt&&) = delete;

  bool is_pending() const { return error_ == EINPROGRESS; }
  /// Of connecting; 0: it came about.
  int error() const { return error_; }
  /// To be polled.
  pollfd item() const { return {file_, POLLOUT, 0}; }
  void on_polled(const pollfd& item) {
    socklen_t size = sizeof error_;
    if (item.revents != 0) getsockopt(file_, SOL_SOCKET, SO_ERROR, &error_, &size);
  }

 private:
  int file_;
  int error_ = 0;
};

/// The error of connecting to that address; 0: none, or it is not known in time.
int connect_error(const sockaddr* address, socklen_t length) {
  Attempt attempt(address, length);
  if (attempt.is_pending()) {
    pollfd item = attempt.item();
    if (poll(&item, 1, kPatienceMs) > 0) attempt.on_polled(item);
  }
  return attempt.is_pending() ? 0 : attempt.error();
}

bool no_socket(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return false;
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const int error = connect_error(reinterpret_cast<const sockaddr*>(&address), sizeof address);
  return error == ENOENT || error == ECONNREFUSED;
}

bool refuses(const Endpoint& endpoint) {
  const auto address = socket_address(endpoint.host, endpoint.port);
  return address && connect_error(address->get(), address->size) == ECONNREFUSED;
}

/// Waits for those that are pending, until then at the most.
void wait_for(std::vector<Attempt>& attempts, Time until) {
  std::vector<pollfd> items;
  std::vector<Attempt*> pending;
  for (Attempt& attempt : attempts) {
    if (!attempt.is_pending()) continue;
    items.push_back(attempt.item());
    pending.push_back(&attempt);
  }
  const auto pause = std::chrono::ceil<std::chrono::milliseconds>(until - monotonic_now());
  if (poll(items.data(), items.size(), static_cast<int>(std::max<int64_t>(0, pause.count()))) <= 0)
    return;
  for (size_t i = 0; i < items.size(); ++i) pending[i]->on_polled(items[i]);
}

}  // namespace

bool nobody_listens(const std::string& text) {
  try {
    const Endpoint endpoint = parse_endpoint(text);
    return endpoint.tcp ? refuses(endpoint) : no_socket(endpoint.path);
  } catch (const Error&) {
    return false;
  }
}

std::string with_address(const std::string& endpoint, const ClientTransport& transport) {
  const std::string resolved = transport.resolved_endpoint().value_or(endpoint);
  return resolved == endpoint ? endpoint : fmt::format("{}, which is {}", endpoint, resolved);
}

ConnectionRace race(const std::vector<std::string>& addresses, int port) {
  std::vector<Attempt> attempts;
  attempts.reserve(addresses.size());
  const auto is_pending = [](const Attempt& attempt) { return attempt.is_pending(); };
  Time until{};
  while (true) {
    const Time now = monotonic_now();
    const bool has_pending = std::ranges::any_of(attempts, is_pending);
    const bool has_more = attempts.size() < addresses.size();
    if (has_more && (now >= until || !has_pending)) {
      const auto address = socket_address(addresses[attempts.size()], port);
      const SocketAddress none;  // of no family: refused by the system
      const SocketAddress& chosen = address ? *address : none;
      attempts.emplace_back(chosen.get(), chosen.size);
      until = now + (attempts.size() < addresses.size() ? kNextBegins : kRacePatience);
    } else if (!has_pending || now >= until) {
      break;
    } else {
      wait_for(attempts, until);
    }
    const auto first = std::ranges::find(attempts, 0, &Attempt::error);
    if (first != attempts.end()) return {static_cast<size_t>(first - attempts.begin())};
  }
  ConnectionRace lost;
  for (const Attempt& attempt : attempts) {
    lost.failures.push_back(attempt.is_pending() ? "no answer" : std::strerror(attempt.error()));
  }
  return lost;
}

}  // namespace tessera
