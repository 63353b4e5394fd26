#include "renderer/accel/wide_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/parallel.h"
#include "renderer/accel/binning.h"
#include "renderer/math/rounding.h"

namespace tessera {
namespace {

// Of visiting a node, in tests of a block of triangles, or of an instance, which costs more.
constexpr float kNodeCost = 1.6f, kNodeCostOverInstances = 0.25f;
constexpr int kMedianDepth = 24;  // below this, halves: so that the depth stays bounded
constexpr size_t kMinTask = 2048;
constexpr size_t kWorthThreads = 1 << 17;  // boxes of one range
constexpr size_t kPiece = 1 << 14;         // that one of them does at a time

using namespace binning;

/// A node's child that is still to be built, by a task of its own.
struct Pending {
  Range range;
  size_t node;
  int slot, depth;
};

/// What one task builds. Indices are its own; joining the parts shifts them.
struct Part {
  std::vector<WideNode> nodes;
  std::vector<uint32_t> slots;
  NodeReference root;
  size_t leaves = 0;
  int depth = 0;
};

/// Places in runs, numbered through.
class Runs {
 public:
  class Cursor {
   public:
    size_t next() {
      while (at_ == runs_->ends_[run_]) at_ = runs_->begins_[++run_];
      return at_++;
    }

   private:
    friend Runs;
    const Runs* runs_;
    size_t run_, at_;
  };

  void add(size_t begin, size_t end) {
    if (begin >= end) return;
    before_.push_back(count_);
    begins_.push_back(begin);
    ends_.push_back(end);
    count_ += end - begin;
  }
  size_t count() const { return count_; }
  /// Of a number below count().
  Cursor at(size_t number) const {
    Cursor cursor;
    const auto behind = std::upper_bound(before_.begin(), before_.end(), number);
    cursor.runs_ = this;
    cursor.run_ = static_cast<size_t>(behind - before_.begin()) - 1;
    cursor.at_ = begins_[cursor.run_] + number - before_[cursor.run_];
    return cursor;
  }

 private:
  std::vector<size_t> before_, begins_, ends_;
  size_t count_ = 0;
};

class WideTreeBuilder {
 public:
  WideTreeBuilder(std::vector<BuildBox>& boxes, uint32_t block_size, int threads)
      : boxes_(boxes.data()), block_size_(block_size), threads_(std::max(1, threads)) {
    // By the number of boxes alone, never of threads: the tree must come out the same.
    task_size_ = std::max(kMinTask, boxes.size() / 32);
  }

  WideTree build(size_t count) {
    Part top;
    std::vector<Pending> pending;
    const Range all = make_range(boxes_, count, threads_);
    top.root = build_range(top, all, 0, &pending);
    std::vector<Part> parts(pending.size());
    for_each_parallel(pending.size(), threads_, [&](size_t i) {
      parts[i].root = build_range(parts[i], pending[i].range, pending[i].depth, nullptr);
    });
    WideTree tree = join(top, pending, parts);
    for (int a = 0; a < 3; ++a)
      tree.extent = std::max({tree.extent, std::abs(all.box.low[a]), std::abs(all.box.high[a])});
    return tree;
  }

 private:
  /// Bins of a range; large ones by all threads. Sums and extremes come out the same in any order.
  Bins fill(const Binning& binning, const Range& range, bool parallel) {
    Bins bins(binning.bins);
    if (!parallel || threads_ < 2 || range.count() < kWorthThreads) {
      bins.add(binning, boxes_, range.begin, range.end);
      return bins;
    }
    std::vector<Bins> parts(static_cast<size_t>(threads_), bins);
    for_each_parallel(parts.size(), threads_, [&](size_t i) {
      const size_t begin = range.begin + range.count() * i / parts.size();
      const size_t end = range.begin + range.count() * (i + 1) / parts.size();
      parts[i].add(binning, boxes_, begin, end);
    });
    for (const Bins& part : parts) bins.add(part);
    return bins;
  }

  Split find(const Range& range, int depth, bool parallel) {
    if (depth >= kMedianDepth) return {};
    const Binning binning(range);
    if (!(binning.usable[0] || binning.usable[1] || binning.usable[2])) return {};
    return fill(binning, range, parallel)
        .best(binning, static_cast<uint32_t>(std::countr_zero(block_size_)));
  }

  /// Cuts a range in two by the split, or, where there is none, in halves.
  std::array<Range, 2> divide(const Range& range, const Split& split, bool parallel) {
    if (split.axis < 0) {
      const size_t middle = range.begin + range.count() / 2;
      halve(range, middle);
      return {make_range(boxes_, range.begin, middle), make_range(boxes_, middle, range.end)};
    }
    const Binning binning(range);
    // Not by the number of threads: the order comes out the same.
    if (!parallel || range.count() < kWorthThreads) {
      return partition(binning, split, range.begin, range.end);
    }
    std::vector<std::array<Range, 2>> parts((range.count() + kPiece - 1) / kPiece);
    for_each_piece_parallel(range.count(), kPiece, threads_, [&](size_t begin, size_t end) {
      parts[begin / kPiece] = partition(binning, split, range.begin + begin, range.begin + end);
    });
    std::array<Range, 2> sides{Range{range.begin, range.begin}, Range{range.end, range.end}};
    for (const auto& part : parts) {
      for (size_t side = 0; side < 2; ++side) {
        sides[side].box.extend(part[side].box);
        sides[side].half_centroids.extend(part[side].half_centroids);
      }
      sides[0].end += part[0].count();
    }
    sides[1].begin = sides[0].end;
    exchange_misplaced(parts, sides[1].begin);
    return sides;
  }

  /// Puts what belongs before `middle` there, and the rest behind it.
  void exchange_misplaced(const std::vector<std::array<Range, 2>>& parts, size_t middle) {
    Runs low, high;
    for (const auto& [left, right] : parts) {
      low.add(right.begin, std::min(right.end, middle));
      high.add(std::max(left.begin, middle), left.end);
    }
    for_each_piece_parallel(low.count(), kPiece, threads_, [&](size_t begin, size_t end) {
      auto a = low.at(begin), b = high.at(begin);
      for (size_t i = begin; i < end; ++i) std::swap(boxes_[a.next()], boxes_[b.next()]);
    });
  }

  std::array<Range, 2> partition(const Binning& binning, const Split& split, size_t begin,
                                 size_t end) {
    Range left{begin, begin}, right{end, end};
    const auto add = [](Range& side, const BuildBox& b, Lanes c) {
      side.box.extend(b.low, b.high);
      side.half_centroids.extend(c, c);
    };
    size_t i = begin, j = end;
    while (i < j) {
      const Lanes c = half_centroid(boxes_[i]);
      if (binning.is_below(boxes_[i], split.axis, split.bin)) {
        add(left, boxes_[i++], c);
      } else {
        add(right, boxes_[i], c);
        std::swap(boxes_[i], boxes_[--j]);
      }
    }
    left.end = right.begin = i;
    return {left, right};
  }

  /// Orders the halves by the widest axis, ties by number, so that deep trees stay useful.
  void halve(const Range& range, size_t middle) {
    const Lanes extent = range.half_centroids.high - range.half_centroids.low;
    int axis = extent[0] >= extent[1] ? 0 : 1;
    if (extent[2] > extent[axis]) axis = 2;
    std::nth_element(boxes_ + range.begin, boxes_ + middle, boxes_ + range.end,
                     [axis](const BuildBox& a, const BuildBox& b) {
                       const float ca = half_centroid(a)[axis], cb = half_centroid(b)[axis];
                       return ca < cb || (ca == cb && a.index() < b.index());
                     });
  }

  NodeReference make_leaf(Part& part, const Range& range) {
    const auto first = static_cast<uint32_t>(part.slots.size() / block_size_);
    for (size_t i = range.begin; i < range.end; ++i) part.slots.push_back(boxes_[i].index());
    while (part.slots.size() % block_size_ != 0) part.slots.push_back(WideTree::kEmptySlot);
    ++part.leaves;
    return NodeReference::leaf(first,
                               static_cast<uint32_t>(part.slots.size() / block_size_) - first);
  }

  size_t blocks(size_t count) const { return (count + block_size_ - 1) / block_size_; }

  bool prefers_leaf(const Range& range, const Split& split) const {
    if (range.count() <= block_size_) return true;
    if (blocks(range.count()) > NodeReference::kMaxLeafBlocks / 2 || split.axis < 0) return false;
    const double area = range.box.half_area();
    const float node_cost = block_size_ == 1 ? kNodeCostOverInstances : kNodeCost;
    return static_cast<double>(blocks(range.count())) * area <= node_cost * area + split.cost;
  }

  NodeReference build_range(Part& part, const Range& range, int depth,
                            std::vector<Pending>* pending) {
    const bool parallel = pending != nullptr;
    const Split split = range.count() <= block_size_ ? Split{} : find(range, depth, parallel);
    if (prefers_leaf(range, split)) return make_leaf(part, range);
    part.depth = std::max(part.depth, depth + 1);
    std::array<Range, 8> children;
    const auto halves = divide(range, split, parallel);
    children[0] = halves[0];
    children[1] = halves[1];
    size_t count = 2;
    while (count < 8) {
      // The child with the largest surface is the one most likely entered for nothing.
      int widest = -1;
      for (size_t i = 0; i < count; ++i) {
        if (children[i].count() <= block_size_) continue;
        if (widest < 0 ||
            children[i].box.half_area() > children[static_cast<size_t>(widest)].box.half_area())
          widest = static_cast<int>(i);
      }
      if (widest < 0) break;
      Range& chosen = children[static_cast<size_t>(widest)];
      const auto pair = divide(chosen, find(chosen, depth, parallel), parallel);
      chosen = pair[0];
      children[count++] = pair[1];
    }
    // Of rays that any hit satisfies, the largest is the likeliest to stop one.
    std::stable_sort(
        children.begin(), children.begin() + static_cast<long>(count),
        [](const Range& a, const Range& b) { return a.box.half_area() > b.box.half_area(); });
    return add_node(part, {children.data(), count}, depth, pending);
  }

  NodeReference add_node(Part& part, std::span<const Range> children, int depth,
                         std::vector<Pending>* pending) {
    const size_t index = part.nodes.size();
    part.nodes.emplace_back();
    WideNode node;
    for (size_t i = 0; i < 8; ++i) {
      const bool present = i < children.size();
      for (int a = 0; a < 3; ++a) {
        node.bounds[2 * a][i] = present ? children[i].box.low[a] : kInf;
        node.bounds[2 * a + 1][i] = present ? children[i].box.high[a] : -kInf;
      }
      node.child[i] = 0;
    }
    for (size_t i = 0; i < children.size(); ++i) {
      if (pending && children[i].count() <= task_size_) {
        pending->push_back({children[i], index, static_cast<int>(i), depth + 1});
      } else {
        node.child[i] = build_range(part, children[i], depth + 1, pending).bits;
      }
    }
    part.nodes[index] = node;
    return NodeReference::node(static_cast<uint32_t>(index));
  }

  WideTree join(Part& top, const std::vector<Pending>& pending, std::vector<Part>& parts) {
    // Where each part comes to lie, behind `top`.
    struct Place {
      size_t node = 0, slot = 0;
    };
    WideTree tree;
    std::vector<Place> places;
    Place end{top.nodes.size(), top.slots.size()};
    for (const Part& part : parts) {
      places.push_back(end);
      end.node += part.nodes.size();
      end.slot += part.slots.size();
    }
    tree.nodes = AlignedArray<WideNode>(end.node);
    tree.slots.resize(end.slot);
    const auto put = [&](const Part& part, const Place& place) {
      const auto moved = [&](NodeReference r) -> NodeReference {
        return {
            static_cast<uint32_t>(r.bits + (r.is_leaf() ? place.slot / block_size_ : place.node))};
      };
      WideNode* at = tree.nodes.data() + place.node;
      for (WideNode node : part.nodes) {
        for (size_t i = 0; i < 8; ++i)
          if (node.bounds[0][i] <= node.bounds[1][i]) node.child[i] = moved({node.child[i]}).bits;
        *at++ = node;
      }
      std::copy(part.slots.begin(), part.slots.end(),
                tree.slots.begin() + static_cast<ptrdiff_t>(place.slot));
      return moved(part.root);
    };
    tree.root = put(top, {});
    for_each_parallel(parts.size(), threads_, [&](size_t i) {
      const Pending& from = pending[i];
      // A child's number is written by no other.
      tree.nodes.data()[from.node].child[from.slot] = put(parts[i], places[i]).bits;
      parts[i].nodes = {};
      parts[i].slots = {};
    });
    tree.leaves = top.leaves;
    tree.depth = top.depth;
    for (const Part& part : parts) {
      tree.leaves += part.leaves;
      tree.depth = std::max(tree.depth, part.depth);
    }
    return tree;
  }

  BuildBox* boxes_;
  uint32_t block_size_;
  int threads_;
  size_t task_size_ = 0;
};

}  // namespace

BuildBox::BuildBox(const Bounds3& b, uint32_t index)
    : low{float_down(b.min.x), float_down(b.min.y), float_down(b.min.z), 0},
      high{float_up(b.max.x), float_up(b.max.y), float_up(b.max.z), 0} {
  set_index(index);
}

// Through memory, never as a float: a number may look like a signalling NaN.
uint32_t BuildBox::index() const {
  uint32_t index;
  std::memcpy(&index, reinterpret_cast<const char*>(&high) + 12, sizeof index);
  return index;
}

void BuildBox::set_index(uint32_t index) {
  std::memcpy(reinterpret_cast<char*>(&high) + 12, &index, sizeof index);
}

WideTree build_wide_tree(std::vector<BuildBox> boxes, uint32_t block_size, int threads) {
  WideTreeBuilder builder(boxes, block_size, threads);
  return builder.build(boxes.size());
}

}  // namespace tessera
