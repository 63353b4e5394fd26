#include "renderer/accel/tree_boxes.h"

#include <limits>

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

void fill_blocks(const TriangleMesh& mesh, MeshTree& tree) {
  tree.blocks = AlignedArray<TriangleBlock>(tree.tree.slots.size() / 4);
  for (size_t slot = 0; slot < tree.tree.slots.size(); ++slot) {
    TriangleBlock& block = tree.blocks.data()[slot / 4];
    const size_t lane = slot % 4;
    const uint32_t primitive = tree.tree.slots[slot];
    block.primitive[lane] = primitive;
    for (size_t vertex = 0; vertex < 3; ++vertex) {
      constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
      const bool used = primitive != WideTree::kEmptySlot;
      const Float3 p =
          used ? mesh.positions[mesh.triangles[primitive][vertex]] : Float3{kNan, kNan, kNan};
      block.vertex[vertex][0][lane] = p.x;
      block.vertex[vertex][1][lane] = p.y;
      block.vertex[vertex][2][lane] = p.z;
    }
  }
  tree.tree.slots = {};  // the blocks carry the numbers from here on
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

}  // namespace tessera
