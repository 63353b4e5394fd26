#pragma once

#include <cstddef>
#include <cstdint>

#include "renderer/accel/aligned_array.h"

namespace tessera {

/// Half a cache line: what nodes and leaves are laid out in, all in one array.
struct alignas(32) TreeUnit {
  std::byte bytes[32];
};

/// A WideTree as rays go through it. References count units, so that a shift makes an address of
/// one; a node is followed by its own leaves.
struct TraversalTree {
  static constexpr uint32_t kLeaf = 0x80000000u;  ///< a leaf, by where it begins

  AlignedArray<TreeUnit> units;
  uint32_t root = 0;
  float extent = 0;  ///< the largest absolute coordinate of any box
};

}  // namespace tessera
