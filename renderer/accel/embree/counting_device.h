#pragma once

#include <embree3/rtcore.h>

#include <atomic>
#include <string>

namespace tessera {

/// A device of so many threads that adds what it allocates to `bytes`, which outlives it.
inline RTCDevice new_counting_device(int threads, std::atomic<ssize_t>& bytes) {
  const RTCDevice device = rtcNewDevice(("threads=" + std::to_string(threads)).c_str());
  const auto count = [](void* counter, ssize_t change, bool) {
    *static_cast<std::atomic<ssize_t>*>(counter) += change;
    return true;
  };
  rtcSetDeviceMemoryMonitorFunction(device, count, &bytes);
  return device;
}

}  // namespace tessera
