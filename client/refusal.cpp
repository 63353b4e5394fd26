#include "client/refusal.h"

#include <fmt/format.h>

#include <algorithm>

#include "proto/transport/listening.h"
#include "proto/wire/printable.h"

namespace tessera {
namespace {

[[noreturn]] void throw_unreachable(const std::string& endpoint, const ConnectionTrouble& trouble) {
  throw UnreachableError(
      endpoint, fmt::format("no connection to the coordinator at {}: {}", endpoint, trouble.why));
}

}  // namespace

void check_not_refused(const v1::Envelope& message, const std::string& endpoint) {
  if (!message.has_reject()) return;
  throw RefusedError(endpoint, fmt::format("the coordinator at {} refused: {}", endpoint,
                                           printable(message.reject().text())));
}

void check_let_in(const ClientTransport& transport, const std::string& endpoint) {
  const auto trouble = transport.trouble();
  if (trouble && trouble->is_unknown_host) {
    throw usage_error(fmt::format(
        "endpoint '{}': the name of the host is unknown; expected tcp://HOST:PORT", endpoint));
  }
  if (!trouble || !trouble->refused) return;
  throw RefusedError(
      endpoint, fmt::format("no connection to the coordinator at {}: {}", endpoint, trouble->why));
}

std::string known_trouble(const ClientTransport& transport) {
  const auto trouble = transport.trouble();
  return trouble ? ": " + trouble->why : "";
}

void FirstWord::check(const ClientTransport& transport, const std::string& endpoint, Time now) {
  if (now < next_look_) return;
  constexpr int kLooks = 4, kFailedAttempts = 3;
  const bool is_alone = nobody_listens(transport.resolved_endpoint().value_or(endpoint));
  looks_at_nobody_ = is_alone ? looks_at_nobody_ + 1 : 0;
  next_look_ = now + (is_alone ? kSoon : kLooks * kSoon);
  if (now < earliest_end_) {
    next_look_ = std::min(next_look_, earliest_end_);
    return;
  }
  const auto trouble = transport.trouble();
  if (trouble && trouble->attempts >= kFailedAttempts) throw_unreachable(endpoint, *trouble);
  if (looks_at_nobody_ < kLooks) return;
  throw UnreachableError(
      endpoint, fmt::format("nothing listens at {}; expected a running 'tessera serve' there",
                            with_address(endpoint, transport)));
}

void TroublePatience::check(const ClientTransport& transport, const std::string& endpoint,
                            bool needed, Time now) {
  const auto trouble = transport.trouble();
  trouble_.listen(last_look_ + kBetweenLooks, now);
  last_look_ = now;
  if (!needed || !trouble) {
    trouble_.heard(now);
  } else if (trouble_.length(now) > patience_) {
    throw_unreachable(endpoint, *trouble);
  }
}

}  // namespace tessera
