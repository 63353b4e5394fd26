#include "renderer/accel/octree_builder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "renderer/accel/octree_layout.h"

namespace tessera {
namespace {

// Narrower than this, of the root's longest side, a voxel could not be told from its neighbours by
// the box test, whose margin is of this size.
constexpr float kMinWidth = 0x1p-19f;

// The study searches between the spatial and the objects' median. Where both are one, as in a
// regular lattice, there would be no choice; so this much of the voxel's width is added on either
// side.
constexpr float kSearchMargin = 0.1f;

constexpr size_t kEnoughForThreads = 4096;

class Builder {
 public:
  Builder(const std::vector<BuildBox>& boxes, const OctreeOptions& options)
      : boxes_(boxes), options_(options) {}

  /// Level by level, so that the voxels come in the same order whichever thread splits which.
  std::vector<Voxel> build(int threads) {
    Voxel root;
    for (uint32_t i = 0; i < boxes_.size(); ++i) {
      root.held.extend(boxes_[i]);
      root.references.push_back(i);
    }
    root.bounds = root.held;
    root.count = boxes_.size();
    root.budget = static_cast<double>(boxes_.size()) * options_.max_duplication + 64;
    for (size_t a = 0; a < 3; ++a)
      min_width_ = std::max(min_width_, half_width(root.bounds, a) * (2 * kMinWidth));
    std::vector<Voxel> voxels;
    voxels.push_back(std::move(root));
    size_t begin = 0;
    for (int depth = 1; depth < options_.max_depth && begin < voxels.size(); ++depth) {
      const size_t end = voxels.size();
      std::vector<std::vector<Voxel>> children(end - begin);
      for_each_parallel(end - begin, boxes_.size() < kEnoughForThreads ? 1 : threads,
                        [&](size_t i) { children[i] = split(voxels[begin + i]); });
      for (size_t i = 0; i < children.size(); ++i) {
        if (children[i].empty()) continue;
        Voxel& parent = voxels[begin + i];
        parent.first_child = static_cast<uint32_t>(voxels.size());
        parent.child_count = static_cast<uint32_t>(children[i].size());
        parent.references = {};
        voxels.insert(voxels.end(), std::make_move_iterator(children[i].begin()),
                      std::make_move_iterator(children[i].end()));
      }
      begin = end;
    }
    if (options_.few_objects == 0)
      for (size_t i = voxels.size(); i-- > 0;) weigh(voxels, i);
    return voxels;
  }

 private:
  /// The whole width may leave single precision.
  static float half_width(const FloatBox& box, size_t a) {
    return box.high[a] * 0.5f - box.low[a] * 0.5f;
  }

  /// Where the voxel splits on each axis; infinity on an axis too narrow to split.
  std::array<float, 3> place(const Voxel& voxel) const {
    std::array<float, 3> split;
    std::array<AxisStretch, 3> stretch;
    for (size_t a = 0; a < 3; ++a) {
      const float low = voxel.bounds.low[a], high = voxel.bounds.high[a];
      const float centre = low * 0.5f + high * 0.5f;
      const bool wide = half_width(voxel.bounds, a) > min_width_ && centre > low && centre < high;
      split[a] = wide ? centre : kNoSplit;
      stretch[a].search_low = stretch[a].search_high = split[a];
    }
    if (!options_.search) return split;
    for (size_t a = 0; a < 3; ++a)
      if (split[a] != kNoSplit) stretch[a] = stretch_of(voxel, a, split[a]);
    return options_.search->find(stretch);
  }

  AxisStretch stretch_of(const Voxel& voxel, size_t a, float centre) const {
    AxisStretch stretch;
    stretch.low = voxel.bounds.low[a];
    stretch.high = voxel.bounds.high[a];
    std::vector<float> middles;
    for (const uint32_t i : voxel.references) {
      const float low = std::max(boxes_[i].low[a], stretch.low);
      const float high = std::min(boxes_[i].high[a], stretch.high);
      stretch.lows.push_back(low);
      stretch.highs.push_back(high);
      middles.push_back(low * 0.5f + high * 0.5f);
    }
    const auto middle = middles.begin() + static_cast<long>(middles.size() / 2);
    std::nth_element(middles.begin(), middle, middles.end());
    const float least = std::min(stretch.low + min_width_, centre);
    const float most = std::max(stretch.high - min_width_, centre);
    const float median = std::max(least, std::min(*middle, most));
    const float more = half_width(voxel.bounds, a) * (2 * kSearchMargin);
    stretch.search_low = std::max(least, std::min(centre, median) - more);
    stretch.search_high = std::min(most, std::max(centre, median) + more);
    return stretch;
  }

  /// The voxel's children; none where it stays a leaf.
  std::vector<Voxel> split(const Voxel& voxel) const {
    if (too_few(voxel.count)) return {};
    const std::array<float, 3> at = place(voxel);
    std::vector<Voxel> children;
    std::array<size_t, 8> child_of{};
    for (unsigned octant = 0; octant < 8; ++octant) {
      Voxel child;
      if (!octant_of(voxel.bounds, at, octant, child.bounds)) continue;
      child_of[octant] = children.size();
      children.push_back(std::move(child));
    }
    for (const uint32_t i : voxel.references) {
      for (unsigned octants = octants_of(boxes_[i], at); octants != 0; octants &= octants - 1) {
        Voxel& child = children[child_of[static_cast<size_t>(std::countr_zero(octants))]];
        child.references.push_back(i);
        child.held.extend(intersection(boxes_[i], child.bounds));
      }
    }
    size_t total = 0;
    for (Voxel& child : children) total += child.count = child.references.size();
    const auto allowed = static_cast<double>(total);
    if (children.size() < 2 || allowed > voxel.budget) return {};
    for (Voxel& child : children) {
      const double share = static_cast<double>(child.count) / allowed;
      child.budget = voxel.budget * share;
    }
    return children;
  }

  /// Whether no split could pay.
  bool too_few(size_t count) const {
    if (options_.few_objects > 0) return count <= options_.few_objects;
    return count <= options_.block_size ||
           options_.block_cost * blocks(count) <= options_.interior_cost;
  }

  static bool octant_of(const FloatBox& box, const std::array<float, 3>& at, unsigned octant,
                        FloatBox& part) {
    part = box;
    for (size_t a = 0; a < 3; ++a) {
      const bool upper = (octant >> a & 1) != 0;
      if (at[a] == kNoSplit) {
        if (upper) return false;
      } else if (upper) {
        part.low[a] = at[a];
      } else {
        part.high[a] = at[a];
      }
    }
    return true;
  }

  /// A bit for each octant that the box belongs to. One that only touches the plane from one side
  /// belongs to that side alone.
  static unsigned octants_of(const BuildBox& box, const std::array<float, 3>& at) {
    constexpr unsigned kUpper[3] = {0xaa, 0xcc, 0xf0};
    unsigned octants = 0xff;
    for (size_t a = 0; a < 3; ++a) {
      const bool lower = box.low[a] < at[a];
      const bool upper = box.high[a] > at[a] || !lower;
      octants &= (upper ? kUpper[a] : 0) | (lower ? ~kUpper[a] : 0);
    }
    return octants;
  }

  /// Children come after their parents: called from the last voxel to the first.
  void weigh(std::vector<Voxel>& voxels, size_t index) const {
    Voxel& voxel = voxels[index];
    const double area = voxel.held.half_area();
    if (voxel.child_count == 0) {
      voxel.cost = leaf_cost(area, voxel.references.size());
      return;
    }
    double split_cost = options_.interior_cost * area;
    for (uint32_t c = 0; c < voxel.child_count; ++c)
      split_cost += voxels[voxel.first_child + c].cost;
    voxel.cost = leaf_cost(area, voxel.count);
    if (split_cost < voxel.cost) {
      voxel.cost = split_cost;
      return;
    }
    gather(voxels, voxel, voxel.references);
    std::sort(voxel.references.begin(), voxel.references.end());
    voxel.references.erase(std::unique(voxel.references.begin(), voxel.references.end()),
                           voxel.references.end());
    voxel.child_count = 0;
  }

  double leaf_cost(double area, size_t count) const {
    return area * (options_.leaf_cost + options_.block_cost * blocks(count));
  }
  double blocks(size_t count) const {
    const size_t whole = (count + options_.block_size - 1) / options_.block_size;
    return static_cast<double>(whole);
  }

  static void gather(std::vector<Voxel>& voxels, const Voxel& voxel, std::vector<uint32_t>& into) {
    for (uint32_t c = 0; c < voxel.child_count; ++c) {
      Voxel& child = voxels[voxel.first_child + c];
      into.insert(into.end(), child.references.begin(), child.references.end());
      gather(voxels, child, into);
      child.references = {};
    }
  }

  static constexpr float kNoSplit = std::numeric_limits<float>::infinity();

  const std::vector<BuildBox>& boxes_;
  const OctreeOptions& options_;
  float min_width_ = std::numeric_limits<float>::min();
};

void count_voxels(const std::vector<Voxel>& voxels, const Voxel& voxel, int depth,
                  AcceleratorStatistics& statistics) {
  statistics.depth = std::max(statistics.depth, depth);
  if (voxel.child_count == 0) {
    ++statistics.leaves;
    statistics.references += voxel.references.size();
    return;
  }
  ++statistics.nodes;
  for (uint32_t c = 0; c < voxel.child_count; ++c)
    count_voxels(voxels, voxels[voxel.first_child + c], depth + 1, statistics);
}

}  // namespace

WideTree build_octree(const std::vector<BuildBox>& boxes, const OctreeOptions& options, int threads,
                      AcceleratorStatistics& statistics) {
  const std::vector<Voxel> voxels = Builder(boxes, options).build(threads);
  count_voxels(voxels, voxels.front(), 1, statistics);
  return lay_out_octree(voxels, boxes, options.block_size);
}

}  // namespace tessera
