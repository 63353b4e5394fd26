#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/parallel.h"
#include "renderer/accel/wide_tree.h"

namespace tessera::binning {

// The binned surface area heuristic (Wald 2007), for build_wide_tree().

using Lanes = BuildBox::Lanes;

inline constexpr float kInf = std::numeric_limits<float>::infinity();
inline constexpr int kMaxBins = 48;

inline Lanes lane_min(Lanes a, Lanes b) { return a < b ? a : b; }
inline Lanes lane_max(Lanes a, Lanes b) { return a > b ? a : b; }

struct Box {
  Lanes low, high;  // left open: most bins are set just before their use

  static Box empty() { return {Lanes{} + kInf, Lanes{} - kInf}; }
  void extend(Lanes l, Lanes h) {
    low = lane_min(low, l);
    high = lane_max(high, h);
  }
  void extend(const Box& b) { extend(b.low, b.high); }
  /// In double: the product of sides may leave single precision.
  double half_area() const {
    const double x = double{high[0]} - low[0], y = double{high[1]} - low[1],
                 z = double{high[2]} - low[2];
    return x * y + (x + y) * z;
  }
};

struct Range {
  size_t begin = 0, end = 0;
  Box box = Box::empty();
  Box half_centroids = Box::empty();  // around half_centroid() of each box
  size_t count() const { return end - begin; }
};

/// Half of a box's centroid, in single precision. The difference of two centroids may overflow
/// there, that of their halves never does, whatever finite boxes they belong to.
inline Lanes half_centroid(const BuildBox& b) {
  Lanes high = b.high;
  high[3] = 0;  // the number kept there is a denormal, slow to reckon with
  return b.low * 0.25f + high * 0.25f;
}

inline Range make_range(const BuildBox* boxes, size_t begin, size_t end) {
  Range r{begin, end};
  for (size_t i = begin; i < end; ++i) {
    r.box.extend(boxes[i].low, boxes[i].high);
    const Lanes c = half_centroid(boxes[i]);
    r.half_centroids.extend(c, c);
  }
  return r;
}

/// Of all of them, which comes out the same in any order.
inline Range make_range(const BuildBox* boxes, size_t count, int threads) {
  constexpr size_t kPiece = 1 << 17;
  std::vector<Range> parts((count + kPiece - 1) / kPiece);
  for_each_piece_parallel(count, kPiece, threads, [&](size_t begin, size_t end) {
    parts[begin / kPiece] = make_range(boxes, begin, end);
  });
  Range all{0, count};
  for (const Range& part : parts) {
    all.box.extend(part.box.low, part.box.high);
    all.half_centroids.extend(part.half_centroids.low, part.half_centroids.high);
  }
  return all;
}

/// Maps boxes to bins by their centroids. Total: every box is in a bin from 0 to bins - 1 on each
/// axis, even one that is not finite; what is not a number is in bin 0.
struct Binning {
  int bins;
  Lanes base, scale;  // of half centroids
  bool usable[3];     // the centroids differ on that axis, and not by too little to be scaled

  explicit Binning(const Range& range) {
    bins = static_cast<int>(std::min<size_t>(kMaxBins, 4 + range.count() / 4));
    base = range.half_centroids.low;
    const Lanes extent = range.half_centroids.high - range.half_centroids.low;
    scale = Lanes{};
    for (int a = 0; a < 3; ++a) {
      const float s = static_cast<float>(bins) * 0.99999f / extent[a];
      usable[a] = extent[a] > 0 && s < kInf && s > 0;
      scale[a] = usable[a] ? s : 0;
    }
  }
  std::array<int, 3> operator()(const BuildBox& b) const {
    Lanes f = (half_centroid(b) - base) * scale;
    f = lane_max(f, Lanes{});  // 0 for what is not a number
    f = lane_min(f, Lanes{} + static_cast<float>(bins - 1));
    using Ints = int32_t __attribute__((vector_size(16)));
    const Ints at = __builtin_convertvector(f, Ints);
    return {at[0], at[1], at[2]};
  }
  /// Whether the box's bin on that axis is below `bin`, which is 1 to bins - 1. Not by way of the
  /// whole number: builders branch on this, and the sooner it is known the better.
  bool is_below(const BuildBox& b, int axis, int bin) const {
    const float along = b.low[axis] * 0.25f + b.high[axis] * 0.25f;
    return !((along - base[axis]) * scale[axis] >= static_cast<float>(bin));
  }
};

struct Split {
  double cost = std::numeric_limits<double>::infinity();
  int axis = -1, bin = 0;  // bins below `bin` go left
};

class Bins {
 public:
  explicit Bins(int bins) : bins_(bins) {
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < bins; ++b) {
        box_[a][b] = Box::empty();
        count_[a][b] = 0;
      }
    }
  }
  void add(const Binning& binning, const BuildBox* boxes, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const std::array<int, 3> at = binning(boxes[i]);
      for (int a = 0; a < 3; ++a) {
        box_[a][at[a]].extend(boxes[i].low, boxes[i].high);
        ++count_[a][at[a]];
      }
    }
  }
  void add(const Bins& other) {
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < bins_; ++b) {
        box_[a][b].extend(other.box_[a][b]);
        count_[a][b] += other.count_[a][b];
      }
    }
  }
  /// The cheapest split by half-area times blocks on each side. Beside an empty bin nothing is new.
  Split best(const Binning& binning, uint32_t block_shift) const {
    Split best;
    const auto blocks = [block_shift](uint32_t n) {
      return static_cast<double>(
          static_cast<int32_t>((n + (1u << block_shift) - 1) >> block_shift));
    };
    for (int a = 0; a < 3; ++a) {
      if (!binning.usable[a]) continue;
      std::array<double, kMaxBins + 1> right_cost;
      Box box = Box::empty();
      uint32_t count = 0;
      right_cost[binning.bins] = kInf;
      for (int b = binning.bins - 1; b > 0; --b) {
        right_cost[b] = right_cost[b + 1];
        if (count_[a][b] == 0) continue;
        box.extend(box_[a][b]);
        count += count_[a][b];
        right_cost[b] = box.half_area() * blocks(count);
      }
      box = Box::empty();
      count = 0;
      for (int b = 1; b < binning.bins; ++b) {
        if (count_[a][b - 1] == 0) continue;
        box.extend(box_[a][b - 1]);
        count += count_[a][b - 1];
        const double cost = box.half_area() * blocks(count) + right_cost[b];
        if (cost < best.cost) best = {cost, a, b};
      }
    }
    return best;
  }

 private:
  int bins_;
  Box box_[3][kMaxBins];  // only the first bins_ are in use
  uint32_t count_[3][kMaxBins];
};

}  // namespace tessera::binning
