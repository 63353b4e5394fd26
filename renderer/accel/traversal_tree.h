#pragma once

#include <cstddef>
#include <cstdint>

#include "renderer/accel/aligned_array.h"

namespace tessera {

/// Half a cache line: what nodes and leaves are laid out in, all in one array.
struct alignas(32) TreeUnit {
  std::byte bytes[32];
};

/// How far the box test's answers are moved to the safe side.
struct BoxMargin {
  /// 32 roundings of single precision; the box test in it needs 10 at most.
  static constexpr double kUsual = 0x1p-19;
  double space = kUsual;  ///< around boxes, relative to the tree's extent or the ray's origin
  double time = 0;  ///< of hits' t beside a relative part, in extents per length of the direction
};

/// A WideTree as rays go through it. References count units, so that a shift makes an address of
/// one; a node is followed by its own leaves.
struct TraversalTree {
  static constexpr uint32_t kLeaf = 0x80000000u;  ///< a leaf, by where it begins

  AlignedArray<TreeUnit> units;
  uint32_t root = 0;
  float extent = 0;  ///< the largest absolute coordinate of any box
  /// The same where rays go in single precision; 0 where boxes are so much smaller than the extent
  /// that it would not tell them apart, and rays go in double.
  float usual_extent = 0;
  BoxMargin margin;
};

}  // namespace tessera
