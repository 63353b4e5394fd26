#pragma once

#include <cstdint>

namespace tessera {

/// Bounces that no roulette ends.
inline constexpr uint32_t kSafeDepth = 3;

/// The pairs of numbers that one vertex of a path may draw, by what they are for.
struct VertexNumbers {
  /// kDirection is drawn while the way to the vertex is traced: nearly every vertex asks for it.
  /// kChoice, x: which way to scatter, y: whether to go on. kPick, x: which light, y: whether the
  /// surface is passed.
  enum Pair : uint32_t { kOnLight, kDirection, kChoice, kPick, kPairs };
  /// That of SampleStream::pair().
  static uint32_t use_of(uint32_t vertex, uint32_t pair) {
    constexpr uint32_t kFirst = 1u << 20;
    return kFirst + kPairs * vertex + pair;
  }
};

}  // namespace tessera
