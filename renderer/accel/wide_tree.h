#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/accel/aligned_array.h"
#include "renderer/math/bounds.h"

namespace tessera {

/// Where a child of a node is: another node, or a leaf of 1 to 16 blocks.
struct NodeReference {
  static constexpr uint32_t kLeaf = 0x80000000u;
  static constexpr uint32_t kIndexMask = 0x07ffffffu;
  static constexpr uint32_t kMaxLeafBlocks = 16;

  uint32_t bits = 0;

  static NodeReference node(uint32_t index) { return {index}; }
  static NodeReference leaf(uint32_t first_block, uint32_t blocks) {
    return {kLeaf | (blocks - 1) << 27 | first_block};
  }
  bool is_leaf() const { return (bits & kLeaf) != 0; }
  uint32_t first_block() const { return bits & kIndexMask; }
  uint32_t blocks() const { return ((bits >> 27) & 15) + 1; }
};

/// Eight children with boxes in single precision, rounded outward. Rows: min x, max x, min y, ...
/// An absent child has min +infinity and max -infinity.
struct alignas(32) WideNode {
  float bounds[6][8];
  uint32_t child[8];
};

/// A box to build over. The fourth lane of `high` carries the number of what it bounds.
struct alignas(16) BuildBox {
  using Lanes = float __attribute__((vector_size(16)));
  Lanes low, high;

  BuildBox() = default;
  BuildBox(const Bounds3& bounds, uint32_t index);  ///< rounds outward
  uint32_t index() const;
  void set_index(uint32_t index);
};

/// A tree of WideNodes over boxes; leaves are runs of blocks of `block_size` slots each.
struct WideTree {
  static constexpr uint32_t kEmptySlot = 0xffffffffu;
  static constexpr int kMaxDepth = 64;

  AlignedArray<WideNode> nodes;
  std::vector<uint32_t> slots;  ///< block after block: numbers of boxes, kEmptySlot for padding
  NodeReference root;
  size_t leaves = 0;
  int depth = 0;
  float extent = 0;  ///< the largest absolute coordinate of any box
};

/// Top-down build by binned surface area heuristic (Wald 2007), eight children at a time as
/// Embree does. The tree does not depend on `threads`. O(n log n) whatever the boxes are; they must
/// be finite and not empty, at least one.
WideTree build_wide_tree(std::vector<BuildBox> boxes, uint32_t block_size, int threads);

}  // namespace tessera
