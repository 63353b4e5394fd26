#pragma once

#include <chrono>
#include <cstdint>

namespace tessera {

/// Milliseconds since 1970 by the system's clock, as pages count time.
inline int64_t milliseconds_since_1970() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
}

}  // namespace tessera
