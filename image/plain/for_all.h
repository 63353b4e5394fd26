#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "base/core_count.h"
#include "base/parallel.h"

namespace tessera {

/// How many threads work on one picture.
inline int threads_of_picture() {
  constexpr int kMostThreads = 8;
  return std::min(core_count(), kMostThreads);
}

/// Calls work(i) for every i below `count`, on several threads, until one returns false; whether
/// none did. Throws what one of them throws.
template <typename Work>
bool for_all(size_t count, const Work& work) {
  std::atomic<bool> goes_on = true;
  for_each_parallel(count, threads_of_picture(), [&](size_t i) {
    if (goes_on && !work(i)) goes_on = false;
  });
  return goes_on;
}

}  // namespace tessera
