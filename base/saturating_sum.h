#pragma once

#include <cstdint>
#include <limits>

namespace tessera {

/// a + b, or the largest number where that is more.
constexpr uint64_t saturating_sum(uint64_t a, uint64_t b) {
  constexpr uint64_t kMost = std::numeric_limits<uint64_t>::max();
  return a > kMost - b ? kMost : a + b;
}

}  // namespace tessera
