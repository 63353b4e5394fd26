#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <future>
#include <thread>
#include <vector>

namespace tessera {

/// Calls work(i) for every i below `count`, on several threads, until one returns false; whether
/// none did. Throws what one of them throws.
template <typename Work>
bool for_all(size_t count, const Work& work) {
  std::atomic<size_t> next = 0;
  std::atomic<bool> goes_on = true;
  const auto run = [&] {
    for (size_t i = next++; goes_on && i < count; i = next++) {
      if (!work(i)) goes_on = false;
    }
  };
  constexpr size_t kMostThreads = 8;
  const size_t threads =
      std::min(count, std::clamp<size_t>(std::thread::hardware_concurrency(), 1, kMostThreads));
  // Where there is no thread to be had, nothing is left when it is waited for.
  std::vector<std::future<void>> others;
  for (size_t i = 1; i < threads; ++i) others.push_back(std::async(run));
  run();
  for (auto& other : others) other.get();
  return goes_on;
}

}  // namespace tessera
