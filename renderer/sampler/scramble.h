#pragma once

#include <cstdint>

namespace tessera::scramble {

// What samples' numbers are hashed with, one at a time (sampler.cpp) and many at once
// (lane_sampler-inl.h).

/// The finalizer of SplitMix64 (Steele, Lea, Flood 2014).
inline constexpr uint64_t kMixStep = 0x9e3779b97f4a7c15u, kMixFirst = 0xbf58476d1ce4e5b9u,
                          kMixLast = 0x94d049bb133111ebu;
/// The constants of Vegdahl 2021 for the hash of Laine and Karras 2011.
inline constexpr uint32_t kUpwardsFirst = 0x3d20adeau, kUpwardsNext = 0x05526c56u,
                          kUpwardsLast = 0x53a22864u;
/// From 32 bits to [0, 1).
inline constexpr double kUnit = 0x1p-32;

}  // namespace tessera::scramble
