#include "proto/transport/zmq_sockets.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "base/error.h"

namespace tessera {
namespace {

// Messages that wait for one peer; on bulk, where each has up to a MiB, enough for two fetches that
// keep their whole windows asked for.
constexpr int kHighWater = 256, kBulkHighWater = 16;
constexpr int kLingerMs = 500;
// A machine that is gone says nothing: its connections end after so many seconds without any sign
// of it, be they idle or not. The system's own probes tell, for libzmq's heartbeats end the whole
// process where a peer that sent more than was read yet closes (libzmq issues 4364 and 4767).
constexpr int kProbeAfterSeconds = 5, kProbes = 3,
              kGoneMs = kProbeAfterSeconds * (kProbes + 1) * 1000;

}  // namespace

WakeUp::WakeUp() : descriptor_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (descriptor_ < 0) throw render_error("no file descriptor is left for an event");
}

WakeUp::~WakeUp() { close(descriptor_); }

// Both can only fail where there is nothing to do: it is awake already, or was not woken.
void WakeUp::wake() { [[maybe_unused]] const int failed = eventfd_write(descriptor_, 1); }

void WakeUp::clear() {
  eventfd_t count;
  [[maybe_unused]] const int failed = eventfd_read(descriptor_, &count);
}

void configure(zmq::socket_t& socket, Channel channel) {
  socket.set(zmq::sockopt::maxmsgsize, static_cast<int64_t>(max_message_bytes(channel)));
  socket.set(zmq::sockopt::linger, kLingerMs);
  const int high_water = channel == Channel::bulk ? kBulkHighWater : kHighWater;
  socket.set(zmq::sockopt::sndhwm, high_water);
  socket.set(zmq::sockopt::rcvhwm, high_water);
  socket.set(zmq::sockopt::handshake_ivl,
             static_cast<int>(std::chrono::milliseconds(kHandshake).count()));
  socket.set(zmq::sockopt::tcp_keepalive, 1);
  socket.set(zmq::sockopt::tcp_keepalive_idle, kProbeAfterSeconds);
  socket.set(zmq::sockopt::tcp_keepalive_intvl, kProbeAfterSeconds);
  socket.set(zmq::sockopt::tcp_keepalive_cnt, kProbes);
  socket.set(zmq::sockopt::tcp_maxrt, kGoneMs);
}

zmq::message_t wrap(MessageBytes bytes) {
  auto* owner = new MessageBytes(std::move(bytes));
  return zmq::message_t(
      owner->data(), owner->size(),
      [](void*, void* hint) { delete static_cast<MessageBytes*>(hint); }, owner);
}

void take_bytes(ReceivedMessage& message, zmq::message_t& part) {
  const auto owner = std::make_shared<zmq::message_t>(std::move(part));
  message.bytes = {owner->data<std::byte>(), owner->size()};
  message.owner = owner;
}

std::vector<zmq::message_t> receive_parts(zmq::socket_t& socket) {
  std::vector<zmq::message_t> parts;
  try {
    do {
      zmq::message_t part;
      if (!socket.recv(part, zmq::recv_flags::dontwait)) return {};
      parts.push_back(std::move(part));
    } while (parts.back().more());
  } catch (const zmq::error_t& error) {
    if (error.num() != EINTR) throw;
    return {};
  }
  return parts;
}

void poll_sockets(std::span<zmq::pollitem_t> items, std::chrono::milliseconds timeout) {
  try {
    zmq::poll(items.data(), items.size(), timeout);
  } catch (const zmq::error_t& error) {
    if (error.num() != EINTR) throw;
  }
}

}  // namespace tessera
