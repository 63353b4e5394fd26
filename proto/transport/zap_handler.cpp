#include "proto/transport/zap_handler.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "proto/transport/zmq_sockets.h"

namespace tessera {
namespace {

constexpr char kEndpoint[] = "inproc://zeromq.zap.01";
constexpr char kDomain[] = "tessera";
// Of refused keys; each is told once.
constexpr size_t kMostTold = 1000;

/// Frames of a request, by their order in RFC 27.
enum { kVersion, kRequest, kDomainFrame, kAddress, kIdentity, kMechanism, kCredential, kFrames };

void reply(zmq::socket_t& socket, const zmq::message_t& request, bool admitted,
           const std::string& key) {
  const std::array<std::string, 6> parts{"1.0",
                                         request.to_string(),
                                         admitted ? "200" : "400",
                                         admitted ? "OK" : "not on the list of keys",
                                         admitted ? key : "",
                                         ""};
  for (size_t i = 0; i < parts.size(); ++i) {
    const bool last = i + 1 == parts.size();
    socket.send(zmq::buffer(parts[i]), last ? zmq::send_flags::none : zmq::send_flags::sndmore);
  }
}

}  // namespace

ZapHandler::ZapHandler(zmq::context_t& context) : socket_(context, zmq::socket_type::rep) {
  socket_.set(zmq::sockopt::linger, 0);
  socket_.bind(kEndpoint);
}

void ZapHandler::protect(zmq::socket_t& socket, const KeyPair& keys) {
  socket.set(zmq::sockopt::curve_server, true);
  socket.set(zmq::sockopt::curve_secretkey,
             zmq::const_buffer(keys.secret_key.data(), keys.secret_key.size()));
  socket.set(zmq::sockopt::zap_domain, kDomain);
  // Where no handler is found, nobody is let in; without it, everybody would be. The header of
  // libzmq 4.3.4 keeps the name of this option for itself, the library knows it.
  constexpr int kZapEnforceDomain = 93;
  const int on = 1;
  if (zmq_setsockopt(socket.handle(), kZapEnforceDomain, &on, sizeof on) != 0) {
    throw render_error("this libzmq cannot be made to let in only who is on a list of keys");
  }
}

void ZapHandler::answer() {
  while (true) {
    const auto parts = receive_parts(socket_);
    if (parts.empty()) return;
    std::string key;
    if (parts.size() == kFrames && parts[kMechanism].to_string_view() == "CURVE" &&
        parts[kDomainFrame].to_string_view() == kDomain &&
        parts[kCredential].size() == sizeof(Key)) {
      Key bytes;
      const auto* credential = parts[kCredential].data<uint8_t>();
      std::copy(credential, credential + bytes.size(), bytes.begin());
      key = key_text(bytes);
    }
    const bool admitted = allowed_.admitted(key) != nullptr;
    if (!admitted) log_refusal(key, parts.size() > kAddress ? parts[kAddress].to_string() : "");
    reply(socket_, parts.size() > kRequest ? parts[kRequest] : parts[0], admitted, key);
  }
}

void ZapHandler::log_refusal(const std::string& key, const std::string& address) {
  if (told_.size() >= kMostTold || !told_.insert(key).second) return;
  spdlog::warn("let nobody in from {}: the key {} is not on the list", address,
               key.empty() ? "(none)" : key);
}

void ZapHandler::set_allowed(AllowList allowed) {
  allowed_ = std::move(allowed);
  told_.clear();
}

std::string key_of(const zmq::message_t& message) {
  const char* const key = zmq_msg_gets(message.handle(), "User-Id");
  return key ? key : "";
}

const AllowedKey* ZapHandler::sender(const zmq::message_t& message) const {
  return allowed_.admitted(key_of(message));
}

}  // namespace tessera
