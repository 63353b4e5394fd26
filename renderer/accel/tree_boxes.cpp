#include "renderer/accel/tree_boxes.h"

#include <cstring>
#include <limits>
#include <span>

#include "base/error.h"

namespace tessera {

std::vector<BuildBox> triangle_boxes(const TriangleMesh& mesh) {
  std::vector<BuildBox> boxes(mesh.triangles.size());
  for (size_t i = 0; i < boxes.size(); ++i) {
    const auto lanes = [&mesh](uint32_t index) {
      const Float3& p = mesh.positions[index];
      return BuildBox::Lanes{p.x, p.y, p.z, 0};
    };
    const TriangleIndices& index = mesh.triangles[i];
    const BuildBox::Lanes a = lanes(index[0]), b = lanes(index[1]), c = lanes(index[2]);
    boxes[i].low = a < b ? a : b;
    boxes[i].low = boxes[i].low < c ? boxes[i].low : c;
    boxes[i].high = a > b ? a : b;
    boxes[i].high = boxes[i].high > c ? boxes[i].high : c;
    boxes[i].set_index(static_cast<uint32_t>(i));
  }
  return boxes;
}

namespace {

/// Nodes in their order, each followed by its leaves. `leaf_units(reference)` says how much room a
/// leaf takes; `write_leaf(reference, unit)` fills it and gives what stands for it in its node.
template <typename LeafUnits, typename WriteLeaf>
void lay_out_nodes(const WideTree& tree, TraversalTree& to, LeafUnits&& leaf_units,
                   WriteLeaf&& write_leaf) {
  constexpr size_t kNodeUnits = sizeof(WideNode) / sizeof(TreeUnit);
  const std::span<const WideNode> nodes{tree.nodes.data(), tree.nodes.size()};
  const auto is_present = [](const WideNode& node, size_t i) {
    return node.bounds[0][i] <= node.bounds[1][i];
  };
  std::vector<uint32_t> place(nodes.size());
  size_t end = tree.root.is_leaf() ? leaf_units(tree.root) : 0;
  for (size_t n = 0; n < nodes.size(); ++n) {
    place[n] = static_cast<uint32_t>(end);
    end += kNodeUnits;
    for (size_t i = 0; i < 8; ++i) {
      const NodeReference child{nodes[n].child[i]};
      if (child.is_leaf() && is_present(nodes[n], i)) end += leaf_units(child);
    }
  }
  TESSERA_CHECK(end < TraversalTree::kLeaf, "a tree larger than 64 GB");
  to.extent = tree.extent;
  to.units = AlignedArray<TreeUnit>(end);
  to.root = tree.root.is_leaf() ? write_leaf(tree.root, 0) : place[tree.root.bits];
  for (size_t n = 0; n < nodes.size(); ++n) {
    WideNode node = nodes[n];
    size_t at = place[n] + kNodeUnits;
    for (size_t i = 0; i < 8; ++i) {
      const NodeReference child{node.child[i]};
      if (!is_present(node, i)) continue;
      node.child[i] = child.is_leaf() ? write_leaf(child, at) : place[child.bits];
      if (child.is_leaf()) at += leaf_units(child);
    }
    std::memcpy(static_cast<void*>(to.units.data() + place[n]), &node, sizeof node);
  }
}

void fill_lane(const TriangleMesh& mesh, uint32_t primitive, TriangleBlock& block, size_t lane) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const bool used = primitive != WideTree::kEmptySlot;
  block.primitive[lane] = used ? primitive : TriangleBlock::kNone;
  for (size_t vertex = 0; vertex < 3; ++vertex) {
    const Float3 p =
        used ? mesh.positions[mesh.triangles[primitive][vertex]] : Float3{kNan, kNan, kNan};
    block.vertex[vertex][0][lane] = p.x;
    block.vertex[vertex][1][lane] = p.y;
    block.vertex[vertex][2][lane] = p.z;
  }
}

}  // namespace

void lay_out(const WideTree& tree, const TriangleMesh& mesh, MeshTree& to) {
  lay_out_nodes(
      tree, to.tree,
      [](NodeReference leaf) { return leaf.blocks() * sizeof(TriangleBlock) / sizeof(TreeUnit); },
      [&](NodeReference leaf, size_t unit) {
        TriangleBlock block;
        TreeUnit* at = to.tree.units.data() + unit;
        for (uint32_t b = 0; b < leaf.blocks(); ++b) {
          for (size_t lane = 0; lane < 4; ++lane)
            fill_lane(mesh, tree.slots[4 * (leaf.first_block() + b) + lane], block, lane);
          if (b + 1 == leaf.blocks()) block.primitive[3] |= TriangleBlock::kLast;
          std::memcpy(static_cast<void*>(at), &block, sizeof block);
          at += sizeof block / sizeof *at;
        }
        return TraversalTree::kLeaf | static_cast<uint32_t>(unit);
      });
}

void lay_out(WideTree tree, InstanceTree& to) {
  lay_out_nodes(
      tree, to.tree, [](NodeReference) { return size_t{0}; },
      [](NodeReference leaf, size_t) { return leaf.bits; });
  to.slots = std::move(tree.slots);
}

size_t bytes_of(const InstanceTree& tree) {
  return tree.tree.units.bytes() + tree.slots.size() * sizeof(uint32_t) +
         tree.instances.size() * sizeof(Instance);
}

std::vector<BuildBox> instance_boxes(InstanceTree& tree, Bounds3& bounds) {
  std::vector<BuildBox> boxes;
  for (size_t i = 0; i < tree.instances.size(); ++i) {
    const Bounds3 b = bounds_of(tree.instances[i]);
    if (b.empty()) continue;
    bounds.extend(b);
    if (is_bounded(b)) {
      boxes.emplace_back(b, static_cast<uint32_t>(i));
      tree.tree_bounds.extend(b);
    } else {
      tree.endless.push_back(static_cast<uint32_t>(i));
    }
  }
  return boxes;
}

bool is_bounded(const Bounds3& b) {
  // Within single precision, with room for sums.
  constexpr double kLimit = 1e38;
  for (int a = 0; a < 3; ++a)
    if (!(b.min[a] > -kLimit && b.max[a] < kLimit)) return false;
  return true;
}

AcceleratorStatistics statistics_of(const WideTree& tree, size_t primitives, size_t references) {
  return {.primitives = primitives,
          .nodes = tree.nodes.size(),
          .leaves = tree.leaves,
          .references = references,
          .depth = tree.depth};
}

}  // namespace tessera
