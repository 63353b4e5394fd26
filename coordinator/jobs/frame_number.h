#pragma once

#include <cstdint>

namespace tessera {

// Workers know a frame of a job by one number, which is never 0.

inline constexpr int kFrameBits = 20;
/// Of a job.
inline constexpr uint32_t kMaxFrames = (uint32_t{1} << kFrameBits) - 1;

/// `frame`: counted from 0, below kMaxFrames.
constexpr uint64_t frame_number(uint64_t job, uint32_t frame) {
  return (job << kFrameBits) + frame + 1;
}
constexpr uint64_t job_of_number(uint64_t number) { return number >> kFrameBits; }
constexpr uint32_t frame_of_number(uint64_t number) {
  return static_cast<uint32_t>(number & kMaxFrames) - 1;
}

}  // namespace tessera
