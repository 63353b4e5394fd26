#include "proto/transport/handshake_monitor.h"

#include <utility>

namespace tessera {
namespace {

constexpr int kEvents = ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED |
                        ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                        ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;

constexpr char kNoCoordinator[] =
    "what listens there does not answer as a coordinator; it is stopped, or another program, or "
    "the coordinator's second port (that after its own: scenes and pictures)";

std::optional<ConnectionTrouble> trouble_of(int event, uint32_t value, bool has_keys) {
  switch (event) {
    case ZMQ_EVENT_HANDSHAKE_FAILED_AUTH:
      return ConnectionTrouble{.why = "it does not let this key in", .refused = true};
    case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL:
      if (value == ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH) {
        return ConnectionTrouble{.why = "one side has keys and the other has none",
                                 .refused = true};
      }
      if (!has_keys) return ConnectionTrouble{.why = kNoCoordinator};
      return ConnectionTrouble{.why = "it has another key than was expected, or is no coordinator"};
    case ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL:
      // A coordinator that has no descriptor left hangs up as well, and lets in later.
      if (!has_keys) return ConnectionTrouble{.why = kNoCoordinator, .attempts = 0};
      return ConnectionTrouble{
          .why =
              "it hung up in the midst of the handshake: perhaps it has another key than was "
              "expected"};
    default:
      return std::nullopt;
  }
}

}  // namespace

HandshakeMonitor::HandshakeMonitor(zmq::context_t& context, zmq::socket_t& watched, bool has_keys)
    : monitor_(context, watched, kEvents), has_keys_(has_keys) {}

void HandshakeMonitor::read() {
  while (const auto seen = monitor_.next()) {
    connected_ = seen->event == ZMQ_EVENT_HANDSHAKE_SUCCEEDED;
    if (seen->event == ZMQ_EVENT_DISCONNECTED) continue;
    auto trouble = trouble_of(seen->event, seen->value, has_keys_);
    if (trouble && trouble_) trouble->attempts += trouble_->attempts;
    // Who refuses may hang up before the other side has read why: what is certain stays.
    const bool is_vague = trouble && !trouble->refused;
    if (is_vague && trouble_ && trouble_->refused) continue;
    trouble_ = std::move(trouble);
  }
}

}  // namespace tessera
