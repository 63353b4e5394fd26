#pragma once

#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/accel/bvh_kernels.h"

namespace tessera {

// What every tree for the eight-wide traversal is built from and filled with.

/// One a triangle, in order.
std::vector<BuildBox> triangle_boxes(const TriangleMesh& mesh, int threads = 1);
/// Around all of them: mesh.bounds() of what triangle_boxes() gave, sooner.
Bounds3 bounds_of(const std::vector<BuildBox>& boxes, int threads = 1);
/// Lays out a tree over the triangles of a mesh, or over instances, for traversal.
void lay_out(const WideTree& tree, const TriangleMesh& mesh, MeshTree& to, int threads);
void lay_out(WideTree tree, InstanceTree& to, int threads);
size_t bytes_of(const InstanceTree& tree);
/// What the tree alone tells.
AcceleratorStatistics statistics_of(const WideTree& tree, size_t primitives, size_t references);
/// Four triangles of a mesh, or fewer and kEmptySlot, as a block of a leaf.
TriangleBlock make_block(const TriangleMesh& mesh, const uint32_t* slots, bool is_last);

/// One for each of tree.instances that a tree can hold; the endless ones are noted in `tree`.
/// `bounds` becomes that of all.
std::vector<BuildBox> instance_boxes(InstanceTree& tree, Bounds3& bounds);

/// Whether a tree can hold an instance: its bounds are finite, and rounding on the way into its
/// frame cannot make it seem to be hit outside of them.
bool can_be_held(const Instance& instance, const Bounds3& bounds);

}  // namespace tessera
