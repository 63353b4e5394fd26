#pragma once

#include <chrono>

namespace tessera {

/// An instant as the time since an origin of no meaning; it never runs backwards. Code that decides
/// takes it as an argument, so that tests may make their own.
using Time = std::chrono::nanoseconds;

inline Time monotonic_now() { return std::chrono::steady_clock::now().time_since_epoch(); }

inline double to_seconds(Time time) { return std::chrono::duration<double>(time).count(); }

}  // namespace tessera
