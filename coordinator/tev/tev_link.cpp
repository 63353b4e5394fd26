#include "coordinator/tev/tev_link.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "base/monotonic.h"

namespace tessera {
namespace {

constexpr size_t kMostQueued = size_t{32} << 20;
constexpr std::chrono::milliseconds kBetweenTries{1000}, kGrace{500};
constexpr int kPollMilliseconds = 50;

}  // namespace

TevLink::TevLink(const std::string& address) {
  const size_t colon = address.rfind(':');
  host_ = address.substr(0, colon);
  if (host_ == "localhost") host_ = "127.0.0.1";
  const std::string port = colon == std::string::npos ? "" : address.substr(colon + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), port_);
  in_addr parsed{};
  // The viewer opens whatever it is sent, and what it is sent is a picture: neither leaves here.
  const bool loopback = inet_pton(AF_INET, host_.c_str(), &parsed) == 1 &&
                        (ntohl(parsed.s_addr) >> 24) == IN_LOOPBACKNET;
  if (!loopback || error != std::errc() || end != port.data() + port.size() || port_ == 0) {
    throw usage_error(fmt::format(
        "--tev: '{}'; expected an address of this machine such as 127.0.0.1:14158", address));
  }
  thread_ = std::thread([this] { run(); });
}

TevLink::~TevLink() {
  {
    std::unique_lock lock(mutex_);
    if (socket_ >= 0) changed_.wait_for(lock, kGrace, [this] { return queue_.empty(); });
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
  if (socket_ >= 0) close(socket_);
}

bool TevLink::offer(std::vector<std::byte> message) {
  const std::scoped_lock lock(mutex_);
  if (queued_bytes_ + message.size() > kMostQueued || connections_ == 0) return false;
  queued_bytes_ += message.size();
  queue_.push_back(std::move(message));
  changed_.notify_all();
  return true;
}

uint64_t TevLink::connections() const {
  const std::scoped_lock lock(mutex_);
  return connections_;
}

void TevLink::run() {
  bool told = false;
  std::unique_lock lock(mutex_);
  while (!ending_) {
    if (socket_ < 0) {
      lock.unlock();
      const bool connected = open_connection();
      if (!connected && !std::exchange(told, true)) {
        spdlog::warn("no tev at {}:{}; it will be tried again", host_, port_);
      }
      lock.lock();
      if (connected) ++connections_;
      if (!connected) changed_.wait_for(lock, kBetweenTries, [this] { return ending_; });
      continue;
    }
    changed_.wait(lock, [this] { return ending_ || !queue_.empty(); });
    if (queue_.empty()) continue;
    const std::vector<std::byte> message = std::move(queue_.front());
    lock.unlock();
    const bool sent = send_all(message);
    lock.lock();
    queue_.pop_front();
    queued_bytes_ -= message.size();
    if (!sent) {
      // Whoever comes in its stead gets all from the start.
      close(std::exchange(socket_, -1));
      queue_.clear();
      queued_bytes_ = 0;
    }
    changed_.notify_all();
  }
}

bool TevLink::open_connection() {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port_);
  inet_pton(AF_INET, host_.c_str(), &to.sin_addr);
  // To this machine it connects or is refused at once.
  const int made = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (made < 0) return false;
  pollfd waited{made, POLLOUT, 0};
  int error = 0;
  socklen_t size = sizeof error;
  const bool begun =
      connect(made, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 || errno == EINPROGRESS;
  const bool connected = begun && poll(&waited, 1, static_cast<int>(kBetweenTries.count())) == 1 &&
                         getsockopt(made, SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0;
  if (!connected) close(made);
  const std::scoped_lock lock(mutex_);
  socket_ = connected ? made : -1;
  return connected;
}

bool TevLink::wait_writable() {
  while (true) {
    pollfd waited{socket_, POLLOUT, 0};
    const int ready = poll(&waited, 1, kPollMilliseconds);
    if (ready > 0) return (waited.revents & (POLLERR | POLLHUP)) == 0;
    if (ready < 0 && errno != EINTR) return false;
    const std::scoped_lock lock(mutex_);
    if (ending_) return false;
  }
}

bool TevLink::send_all(const std::vector<std::byte>& message) {
  for (size_t at = 0; at < message.size();) {
    const ssize_t sent = send(socket_, message.data() + at, message.size() - at, MSG_NOSIGNAL);
    if (sent > 0) {
      at += static_cast<size_t>(sent);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      if (!wait_writable()) return false;
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

}  // namespace tessera
