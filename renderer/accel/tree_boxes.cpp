#include "renderer/accel/tree_boxes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "renderer/accel/binning.h"
#include "renderer/shapes/solid.h"

namespace tessera {

namespace {
// Triangles or nodes that one thread does at a time.
constexpr size_t kChunk = 1 << 14;
}  // namespace

std::vector<BuildBox> triangle_boxes(const TriangleMesh& mesh, int threads) {
  std::vector<BuildBox> boxes(mesh.triangles.size());
  const auto lanes = [&mesh](uint32_t index) {
    const Float3& p = mesh.positions[index];
    return BuildBox::Lanes{p.x, p.y, p.z, 0};
  };
  for_each_piece_parallel(boxes.size(), kChunk, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const TriangleIndices& index = mesh.triangles[i];
      const BuildBox::Lanes a = lanes(index[0]), b = lanes(index[1]), c = lanes(index[2]);
      boxes[i].low = a < b ? a : b;
      boxes[i].low = boxes[i].low < c ? boxes[i].low : c;
      boxes[i].high = a > b ? a : b;
      boxes[i].high = boxes[i].high > c ? boxes[i].high : c;
      boxes[i].set_index(static_cast<uint32_t>(i));
    }
  });
  return boxes;
}

Bounds3 bounds_of(const std::vector<BuildBox>& boxes, int threads) {
  const binning::Box whole = binning::make_range(boxes.data(), boxes.size(), threads).box;
  return {{whole.low[0], whole.low[1], whole.low[2]},
          {whole.high[0], whole.high[1], whole.high[2]}};
}

namespace {

/// Whether so many leaves are of the size of the box test's margin that single precision would not
/// tell them apart: far from the origin, or beside something huge. They would all but be scanned.
bool is_too_fine(const WideTree& tree) {
  constexpr double kSmallest = 4 * BoxMargin{}.space;
  const auto few = std::max<size_t>(64, tree.leaves / 1024);
  size_t tiny = 0;
  for (const WideNode& node : std::span{tree.nodes.data(), tree.nodes.size()}) {
    for (size_t i = 0; i < 8; ++i) {
      if (!NodeReference{node.child[i]}.is_leaf()) continue;
      double size = 0;
      for (int a = 0; a < 3; ++a)
        size = std::max(size, double{node.bounds[2 * a + 1][i]} - node.bounds[2 * a][i]);
      if (size < kSmallest * tree.extent) ++tiny;
    }
  }
  return tiny > few;
}

void go_in_double(TraversalTree& tree, const BoxMargin& margin) {
  tree.usual_extent = 0;
  tree.margin = margin;
}

/// Nodes in their order, each followed by its leaves. `leaf_units(reference)` says how much room a
/// leaf takes; `write_leaf(reference, unit)` fills it and gives what stands for it in its node.
template <typename LeafUnits, typename WriteLeaf>
void lay_out_nodes(const WideTree& tree, TraversalTree& to, int threads,
                   const LeafUnits& leaf_units, const WriteLeaf& write_leaf) {
  constexpr size_t kNodeUnits = sizeof(WideNode) / sizeof(TreeUnit);
  const std::span<const WideNode> nodes{tree.nodes.data(), tree.nodes.size()};
  const auto is_present = [](const WideNode& node, size_t i) {
    return node.bounds[0][i] <= node.bounds[1][i];
  };
  // How much room each takes, then where that is.
  std::vector<uint32_t> place(nodes.size());
  for_each_piece_parallel(nodes.size(), kChunk, threads, [&](size_t first, size_t last) {
    for (size_t n = first; n < last; ++n) {
      size_t units = kNodeUnits;
      for (size_t i = 0; i < 8; ++i) {
        const NodeReference child{nodes[n].child[i]};
        if (child.is_leaf() && is_present(nodes[n], i)) units += leaf_units(child);
      }
      place[n] = static_cast<uint32_t>(units);
    }
  });
  size_t end = tree.root.is_leaf() ? leaf_units(tree.root) : 0;
  for (uint32_t& each : place) each = static_cast<uint32_t>(std::exchange(end, end + each));
  if (end >= TraversalTree::kLeaf) {
    throw scene_error("a mesh with a tree of more than 64 GB; expected it in several");
  }
  to.extent = to.usual_extent = tree.extent;
  to.units = AlignedArray<TreeUnit>(end);
  to.root = tree.root.is_leaf() ? write_leaf(tree.root, 0) : place[tree.root.bits];
  for_each_piece_parallel(nodes.size(), kChunk, threads, [&](size_t first, size_t last) {
    for (size_t n = first; n < last; ++n) {
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
  });
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

TriangleBlock make_block(const TriangleMesh& mesh, const uint32_t* slots, bool is_last) {
  TriangleBlock block;
  for (size_t lane = 0; lane < 4; ++lane) fill_lane(mesh, slots[lane], block, lane);
  if (is_last) block.primitive[3] |= TriangleBlock::kLast;
  return block;
}

void lay_out(const WideTree& tree, const TriangleMesh& mesh, MeshTree& to, int threads) {
  lay_out_nodes(
      tree, to.tree, threads,
      [](NodeReference leaf) { return leaf.blocks() * sizeof(TriangleBlock) / sizeof(TreeUnit); },
      [&](NodeReference leaf, size_t unit) {
        TreeUnit* at = to.tree.units.data() + unit;
        for (uint32_t b = 0; b < leaf.blocks(); ++b) {
          const uint32_t* slots = tree.slots.data() + size_t{4} * (leaf.first_block() + b);
          const TriangleBlock block = make_block(mesh, slots, b + 1 == leaf.blocks());
          std::memcpy(static_cast<void*>(at), &block, sizeof block);
          at += sizeof block / sizeof *at;
        }
        return TraversalTree::kLeaf | static_cast<uint32_t>(unit);
      });
  // The test of triangles errs by 2^-49 of their distance, and by 2^-30 of t or, where it would by
  // more, stays in their boxes, which are exact. The rule of spatial splits wants the usual margin.
  if (to.cut_planes.count == 0 && is_too_fine(tree))
    go_in_double(to.tree, {.space = 0x1p-32, .time = 0x1p-26});
}

namespace {

double condition_of(const Instance& instance) {
  const Transform& t = instance.world_from_object;
  return t.is_identity() ? 1 : condition(t.matrix(), t.inverse_matrix());
}

/// Whether rounding on the way into every instance and back stays far below 2^-30 of the extent.
bool all_well_conditioned(const std::vector<Instance>& instances) {
  return std::all_of(instances.begin(), instances.end(),
                     [](const Instance& i) { return condition_of(i) <= 0x1p16; });
}

}  // namespace

void lay_out(WideTree tree, InstanceTree& to, int threads) {
  lay_out_nodes(
      tree, to.tree, threads, [](NodeReference) { return size_t{0}; },
      [](NodeReference leaf, size_t) { return leaf.bits; });
  // t of a large sphere that is grazed errs by more than 2^-27 of its radius.
  if (is_too_fine(tree) && all_well_conditioned(to.instances))
    go_in_double(to.tree, {.space = 0x1p-30, .time = 0x1p-22});
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
    if (can_be_held(tree.instances[i], b)) {
      boxes.emplace_back(b, static_cast<uint32_t>(i));
      tree.tree_bounds.extend(b);
    } else {
      tree.endless.push_back(static_cast<uint32_t>(i));
    }
  }
  return boxes;
}

bool can_be_held(const Instance& instance, const Bounds3& b) {
  // Within single precision, with room for sums.
  constexpr double kLimit = 1e38;
  for (int a = 0; a < 3; ++a)
    if (!(b.min[a] > -kLimit && b.max[a] < kLimit)) return false;
  if (condition_of(instance) > 0x1p26) return false;
  // A curved solid that is as thin as what rounds off its size may be hit beside its box.
  const Vec3 size = b.diagonal();
  const double most = max_component(size), least = std::min(size.x, std::min(size.y, size.z));
  constexpr double kThin = 0x1p-36;
  return least >= kThin * most || dynamic_cast<const Solid*>(instance.shape.get()) == nullptr;
}

AcceleratorStatistics statistics_of(const WideTree& tree, size_t primitives, size_t references) {
  return {.primitives = primitives,
          .nodes = tree.nodes.size(),
          .leaves = tree.leaves,
          .references = references,
          .depth = tree.depth};
}

}  // namespace tessera
