#include "front/order_outcome.h"

#include <fmt/format.h>

#include "proto/wire/printable.h"

namespace tessera {

std::optional<std::string> unfulfilled(const v1::JobQuery& order, const v1::JobStatus& status) {
  const bool ended = status.state() == v1::JobStatus::ENDED;
  const bool paused = status.state() == v1::JobStatus::PAUSED;
  std::string what;
  if (order.has_priority() && !ended && status.priority() != order.priority()) {
    what = fmt::format("keeps its priority, {}", status.priority());
  }
  const auto add = [&what](const char* more) {
    what += (what.empty() ? "" : ", and ") + std::string(more);
  };
  if (order.action() == v1::JobQuery::PAUSE && !paused) add("is not paused");
  if (order.action() == v1::JobQuery::RESUME && paused) add("is still paused");
  if (order.action() == v1::JobQuery::CANCEL && !ended) add("is not cancelled");
  if (order.action() == v1::JobQuery::RETRY && ended) add("is not tried again");
  if (what.empty()) return std::nullopt;
  const std::string why = printable(status.failure());
  return what + (why.empty() ? "; expected the coordinator to do it" : ": " + why);
}

}  // namespace tessera
