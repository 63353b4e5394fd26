#pragma once

#include <chrono>
#include <string>

#include "base/monotonic.h"
#include "cli/say.h"
#include "front/job_orders.h"

namespace tessera {

/// How often a farm is asked about a job that is waited for.
inline constexpr Time kAskEvery = std::chrono::milliseconds(200);

/// What `ask` returns of a farm. One that falls silent is waited for, and that is said once.
template <class Ask>
auto ask_patiently(const Ask& ask) {
  return ask_through_silence(
      ask, [](const std::string& why) { say_warning(why + "; it is waited for"); });
}

}  // namespace tessera
