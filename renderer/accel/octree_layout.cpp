#include "renderer/accel/octree_layout.h"

#include <array>
#include <cmath>
#include <span>

namespace tessera {
namespace {

/// What a lane of a node is made from: a voxel with children, or references of a leaf voxel.
struct Item {
  FloatBox box;
  const Voxel* voxel = nullptr;  ///< the voxel that it is, or that its references lie in
  std::span<const uint32_t> references;
  bool has_children() const { return voxel->child_count > 0; }
};

class Layout {
 public:
  Layout(const std::vector<Voxel>& voxels, const std::vector<BuildBox>& boxes, uint32_t block_size)
      : voxels_(voxels), boxes_(boxes), block_size_(block_size) {}

  WideTree run() {
    const Voxel& root = voxels_.front();
    const uint32_t reference = place(item_of(root));
    WideTree tree;
    tree.root = {reference};
    tree.nodes = AlignedArray<WideNode>(nodes_.size());
    std::copy(nodes_.begin(), nodes_.end(), tree.nodes.data());
    tree.slots = std::move(slots_);
    tree.leaves = leaves_;
    for (int a = 0; a < 3; ++a)
      tree.extent =
          std::max({tree.extent, std::abs(root.bounds.low[a]), std::abs(root.bounds.high[a])});
    return tree;
  }

 private:
  static Item item_of(const Voxel& voxel) { return {voxel.held, &voxel, voxel.references}; }

  /// Few enough to be tested without a box around each.
  bool is_run(const Item& item) const {
    return !item.has_children() && item.references.size() <= direct();
  }
  size_t direct() const { return block_size_ == 1 ? 1 : size_t{2} * block_size_; }

  /// What an item opens into: its voxel's children that are not empty, or its references in up to
  /// eight runs.
  std::vector<Item> parts(const Item& item) const {
    std::vector<Item> found;
    if (item.has_children()) {
      for (uint32_t c = 0; c < item.voxel->child_count; ++c) {
        const Voxel& child = voxels_[item.voxel->first_child + c];
        if (child.count > 0) found.push_back(item_of(child));
      }
      return found;
    }
    size_t size = block_size_;
    while (size * 8 < item.references.size()) size *= 8;
    for (size_t i = 0; i < item.references.size(); i += size) {
      Item part{
          {}, item.voxel, item.references.subspan(i, std::min(size, item.references.size() - i))};
      for (const uint32_t r : part.references)
        part.box.extend(intersection(boxes_[r], item.voxel->bounds));
      found.push_back(part);
    }
    return found;
  }

  /// Opens the largest items while their parts find free lanes: fewer and fuller nodes.
  std::vector<Item> lanes(const Item& item) const {
    std::vector<Item> items = parts(item);
    std::vector<bool> settled(items.size());
    for (;;) {
      size_t widest = items.size();
      for (size_t i = 0; i < items.size(); ++i) {
        if (settled[i] || is_run(items[i])) continue;
        if (widest == items.size() || items[i].box.half_area() > items[widest].box.half_area())
          widest = i;
      }
      if (widest == items.size()) return items;
      const std::vector<Item> opened = parts(items[widest]);
      if (items.size() - 1 + opened.size() > 8) {
        settled[widest] = true;
        continue;
      }
      const auto at = static_cast<long>(widest);
      items.erase(items.begin() + at);
      settled.erase(settled.begin() + at);
      items.insert(items.end(), opened.begin(), opened.end());
      settled.resize(items.size());
    }
  }

  uint32_t place(const Item& item) {
    if (is_run(item)) return place_run(item.references);
    const std::vector<Item> items = lanes(item);
    if (items.size() == 1) return place(items.front());
    const size_t index = nodes_.size();
    nodes_.emplace_back();
    WideNode node;
    for (size_t i = 0; i < 8; ++i) {
      const FloatBox box = i < items.size() ? items[i].box : FloatBox{};
      for (int a = 0; a < 3; ++a) {
        node.bounds[2 * a][i] = box.low[a];
        node.bounds[2 * a + 1][i] = box.high[a];
      }
      node.child[i] = 0;
    }
    for (size_t i = 0; i < items.size(); ++i) node.child[i] = place(items[i]);
    nodes_[index] = node;
    return NodeReference::node(static_cast<uint32_t>(index)).bits;
  }

  uint32_t place_run(std::span<const uint32_t> references) {
    const auto first = static_cast<uint32_t>(slots_.size() / block_size_);
    for (const uint32_t r : references) slots_.push_back(boxes_[r].index());
    while (slots_.size() % block_size_ != 0) slots_.push_back(WideTree::kEmptySlot);
    ++leaves_;
    return NodeReference::leaf(first, static_cast<uint32_t>(slots_.size() / block_size_) - first)
        .bits;
  }

  const std::vector<Voxel>& voxels_;
  const std::vector<BuildBox>& boxes_;
  const uint32_t block_size_;
  std::vector<WideNode> nodes_;
  std::vector<uint32_t> slots_;
  size_t leaves_ = 0;
};

}  // namespace

WideTree lay_out_octree(const std::vector<Voxel>& voxels, const std::vector<BuildBox>& boxes,
                        uint32_t block_size) {
  return Layout(voxels, boxes, block_size).run();
}

}  // namespace tessera
