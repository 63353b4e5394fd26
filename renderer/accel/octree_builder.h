#pragma once

#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/accel/split_search.h"
#include "renderer/accel/wide_tree.h"

namespace tessera {

/// How an octree is built. Costs are in visits of a node.
struct OctreeOptions {
  const SplitSearch* search = nullptr;  ///< null: every voxel splits at its centre (uniform)
  uint32_t block_size = 1;              ///< slots of a leaf come in blocks of so many
  uint32_t few_objects = 0;  ///< if not 0: each voxel of more objects splits, whatever the cost
  double interior_cost = 1, leaf_cost = 0, block_cost = 1;
  int max_depth = 24;
  double max_duplication = 4;  ///< references to each box, on the average, that a tree may have
};

/// Builds an octree over boxes: a voxel that splits does so at one point into eight voxels, and
/// each box is referenced from every leaf voxel that it overlaps. Unless few_objects says
/// otherwise, a split is kept only where it lowers
///   SAH = C_i sum SA(interior) + C_l sum SA(leaf) + C_o sum SA(leaf) N(leaf)
/// where N counts blocks, and the areas are of what the voxels hold, as a ray enters no empty space
/// here. The result is laid
/// out for the traversal of the BVH: the box of a child is its voxel cut down to its contents, so
/// a hit may be accepted wherever it is found, and later voxels that begin beyond it are skipped.
///
/// What a shape reports lies within its box, and all of the box is referenced from the voxels that
/// it overlaps; so no hit is lost, however uncertain its distance.
///
/// `statistics` gets depth (1 for a single voxel), nodes (interior voxels), leaves (leaf voxels,
/// empty ones too) and references. The tree does not depend on `threads`. Boxes as for
/// build_wide_tree.
WideTree build_octree(const std::vector<BuildBox>& boxes, const OctreeOptions& options, int threads,
                      AcceleratorStatistics& statistics);

}  // namespace tessera
