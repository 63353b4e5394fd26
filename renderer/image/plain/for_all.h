#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>

#include "base/parallel.h"

namespace tessera {

/// Calls work(i) for every i below `count`, on several threads, until one returns false; whether
/// none did. Throws what one of them throws.
template <typename Work>
bool for_all(size_t count, const Work& work) {
  constexpr unsigned kMostThreads = 8;
  std::atomic<bool> goes_on = true;
  for_each_parallel(count,
                    static_cast<int>(std::min(std::thread::hardware_concurrency(), kMostThreads)),
                    [&](size_t i) {
                      if (goes_on && !work(i)) goes_on = false;
                    });
  return goes_on;
}

}  // namespace tessera
