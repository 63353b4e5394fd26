#include "client/refusal.h"

#include <fmt/format.h>

#include "proto/transport/listening.h"
#include "proto/wire/printable.h"

namespace tessera {

void check_host_is_known(const std::string& endpoint) {
  if (!is_unknown_host(endpoint)) return;
  throw usage_error(fmt::format(
      "endpoint '{}': the name of the host is unknown; expected tcp://HOST:PORT", endpoint));
}

void check_not_refused(const v1::Envelope& message, const std::string& endpoint) {
  if (!message.has_reject()) return;
  throw RefusedError(fmt::format("the coordinator at {} refused: {}", endpoint,
                                 printable(message.reject().text())));
}

void check_let_in(const ClientTransport& transport, const std::string& endpoint) {
  const auto trouble = transport.trouble();
  if (!trouble || !trouble->refused) return;
  throw RefusedError(
      fmt::format("no connection to the coordinator at {}: {}", endpoint, trouble->why));
}

std::string known_trouble(const ClientTransport& transport) {
  const auto trouble = transport.trouble();
  return trouble ? ": " + trouble->why : "";
}

void FirstWord::check(const std::string& endpoint, Time now) {
  if (now < look_) return;
  look_ = now + std::chrono::seconds(2);
  if (!nobody_listens(endpoint)) return;
  throw UnreachableError(
      fmt::format("nothing listens at {}; expected a running 'tessera serve' there", endpoint));
}

void TroublePatience::check(const ClientTransport& transport, const std::string& endpoint,
                            bool needed, Time now) {
  const auto trouble = transport.trouble();
  if (!needed || !trouble) {
    last_fine_ = now;
  } else if (now - last_fine_ > patience_) {
    throw UnreachableError(
        fmt::format("no connection to the coordinator at {}: {}", endpoint, trouble->why));
  }
}

}  // namespace tessera
