#include "proto/transport/handshake_monitor.h"

#include <fmt/format.h>

#include <atomic>
#include <cstring>
#include <utility>

#include "proto/transport/zmq_sockets.h"

namespace tessera {
namespace {

constexpr int kEvents = ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED |
                        ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                        ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;

std::optional<ConnectionTrouble> trouble_of(int event, uint32_t value) {
  switch (event) {
    case ZMQ_EVENT_HANDSHAKE_FAILED_AUTH:
      return ConnectionTrouble{"it does not let this key in", true};
    case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL:
      if (value == ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH) {
        return ConnectionTrouble{"one side has keys and the other has none", true};
      }
      return ConnectionTrouble{"it has another key than was expected, or is no coordinator", false};
    case ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL:
      return ConnectionTrouble{
          "it hung up in the midst of the handshake: perhaps it has another "
          "key than was expected",
          false};
    default:
      return std::nullopt;
  }
}

}  // namespace

HandshakeMonitor::HandshakeMonitor(zmq::context_t& context, zmq::socket_t& watched)
    : events_(context, zmq::socket_type::pair) {
  events_.set(zmq::sockopt::linger, 0);
  static std::atomic<uint64_t> count{0};
  const std::string endpoint = fmt::format("inproc://handshakes-{}", ++count);
  if (zmq_socket_monitor(watched.handle(), endpoint.c_str(), kEvents) != 0) throw zmq::error_t();
  events_.connect(endpoint);
}

void HandshakeMonitor::read() {
  while (true) {
    const auto parts = receive_parts(events_);
    if (parts.empty()) return;
    uint16_t event = 0;
    uint32_t value = 0;
    if (parts[0].size() < sizeof event + sizeof value) continue;
    std::memcpy(&event, parts[0].data(), sizeof event);
    std::memcpy(&value, parts[0].data<char>() + sizeof event, sizeof value);
    connected_ = event == ZMQ_EVENT_HANDSHAKE_SUCCEEDED;
    if (event == ZMQ_EVENT_DISCONNECTED) continue;
    auto trouble = trouble_of(event, value);
    // Who refuses may hang up before the other side has read why: what is certain stays.
    const bool is_vague = trouble && !trouble->refused;
    if (is_vague && trouble_ && trouble_->refused) continue;
    trouble_ = std::move(trouble);
  }
}

}  // namespace tessera
