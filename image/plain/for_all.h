#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "base/core_count.h"
#include "base/parallel.h"

namespace tessera {

/// Calls work(i) for every i below `count`, on several threads, until one returns false; whether
/// none did. Throws what one of them throws.
template <typename Work>
bool for_all(size_t count, const Work& work) {
  constexpr int kMostThreads = 8;
  std::atomic<bool> goes_on = true;
  for_each_parallel(count, std::min(core_count(), kMostThreads), [&](size_t i) {
    if (goes_on && !work(i)) goes_on = false;
  });
  return goes_on;
}

}  // namespace tessera
