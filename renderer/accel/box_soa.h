#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "renderer/math/bounds.h"

namespace tessera {

/// Up to 16 boxes in double precision, which a ray is held against all at once. They are grown by
/// more than the rounding of that and of the exact tests of what they hold (as BoxMargin), so that
/// no box with a hit is missed.
struct BoxSoA {
  static constexpr size_t kMost = 16;
  /// Beside the bits of boxes: the ray is such that any may be hit, and may be none at all.
  static constexpr uint32_t kUnusual = 1u << 31;
  /// Of a direction, the parts' sizes added up: rays of others are unusual.
  static constexpr double kLeastSteep = 1e-150, kMostSteep = 1e150;
  /// One over a part of a direction is not taken to be more, nor less than its negative: so it is
  /// finite, and no product with the distance of a face is not a number.
  static constexpr double kMostInverse = 1e200;

  BoxSoA() = default;
  /// At most kMost boxes, none empty, within 1e38.
  explicit BoxSoA(std::span<const Bounds3> boxes);

  alignas(32) double min[3][kMost], max[3][kMost];
  size_t count = 0;     ///< rounded up to a whole number of vectors: what fills it up meets no ray
  uint32_t all = 0;     ///< a bit for each box
  double farthest = 0;  ///< of an origin, the parts added up: beyond it all boxes are tested
};

}  // namespace tessera
