#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "renderer/accel/wide_tree.h"

namespace tessera {

/// A closed box in single precision; empty until extended.
struct FloatBox {
  using Lanes = BuildBox::Lanes;
  static constexpr float kInf = std::numeric_limits<float>::infinity();
  Lanes low{kInf, kInf, kInf, 0}, high{-kInf, -kInf, -kInf, 0};

  template <typename Box>
  void extend(const Box& b) {
    low = low < b.low ? low : b.low;
    high = high > b.high ? high : b.high;
  }
  /// In double: the product of sides may leave single precision.
  double half_area() const {
    if (!(low[0] <= high[0])) return 0;
    const double x = double{high[0]} - low[0], y = double{high[1]} - low[1],
                 z = double{high[2]} - low[2];
    return x * y + (x + y) * z;
  }
};

/// Of two that overlap.
inline FloatBox intersection(const BuildBox& a, const FloatBox& b) {
  FloatBox both;
  both.low = a.low > b.low ? a.low : b.low;
  both.high = a.high < b.high ? a.high : b.high;
  return both;
}

/// A voxel of an octree while it is built.
struct Voxel {
  FloatBox bounds;
  FloatBox held;  ///< around its boxes, cut to `bounds`; empty without any
  std::vector<uint32_t>
      references;    ///< boxes that overlap it, ascending; none where it has children
  size_t count = 0;  ///< of them, kept when they are handed on
  uint32_t first_child = 0, child_count = 0;
  double budget = 0;  ///< references that the leaves below may have
  double cost = 0;
};

/// Lays an octree out for the eight-wide traversal. `voxels` begins with the root; children come
/// after their parents. A lane of a node is a voxel, or a run of blocks out of a leaf voxel with a
/// box of its own; voxels with few children are merged into their parent's free lanes.
WideTree lay_out_octree(const std::vector<Voxel>& voxels, const std::vector<BuildBox>& boxes,
                        uint32_t block_size);

}  // namespace tessera
