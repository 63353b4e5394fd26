// Part of bvh_kernels.cpp, compiled once for each instruction set: the ways through a tree.
#if defined(TESSERA_TRAVERSE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_TRAVERSE_INL_H
#undef TESSERA_TRAVERSE_INL_H
#else
#define TESSERA_TRAVERSE_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>

#include "renderer/accel/box_ray.h"
#include "renderer/accel/traversal_tree.h"
#include "renderer/accel/wide_tree.h"
#include "renderer/math/mask_bits-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, 8>;
using IntTag = hn::RebindToSigned<FloatTag>;
using DoubleTag = hn::CappedTag<double, 4>;
using HalfFloatTag = hn::Rebind<float, DoubleTag>;

/// Room for every child left behind on the way down the deepest tree.
constexpr size_t kStackSize = 7 * WideTree::kMaxDepth + 8;

/// Distance above, reference below: sorts by distance, and fits a register. Distances are never
/// negative, so they compare as integers.
using Entry = uint64_t;
HWY_INLINE Entry make_entry(int32_t distance, uint32_t reference) {
  return uint64_t{static_cast<uint32_t>(distance)} << 32 | reference;
}
/// Leaves the smaller of two in `a`, without a branch.
HWY_INLINE void sort(Entry& a, Entry& b) {
  const Entry smaller = std::min(a, b);
  b = std::max(a, b);
  a = smaller;
}

/// What a box test wants of a ray in every lane, kept in registers.
struct RayLanes {
  using Lanes = hn::Vec<FloatTag>;
  Lanes inverse_x, inverse_y, inverse_z, enter_x, enter_y, enter_z, leave_x, leave_y, leave_z;
  hn::Vec<IntTag> t_min;
  size_t near_x, near_y, near_z, far_x, far_y, far_z;  // in bytes from the start of a node

  HWY_INLINE explicit RayLanes(const BoxRay<float>& r) {
    const FloatTag tag;
    inverse_x = hn::Set(tag, r.inverse[0]);
    inverse_y = hn::Set(tag, r.inverse[1]);
    inverse_z = hn::Set(tag, r.inverse[2]);
    enter_x = hn::Set(tag, r.enter_offset[0]);
    enter_y = hn::Set(tag, r.enter_offset[1]);
    enter_z = hn::Set(tag, r.enter_offset[2]);
    leave_x = hn::Set(tag, r.leave_offset[0]);
    leave_y = hn::Set(tag, r.leave_offset[1]);
    leave_z = hn::Set(tag, r.leave_offset[2]);
    t_min = hn::BitCast(IntTag(), hn::Set(tag, r.t_min));
    near_x = kRow * static_cast<size_t>(r.near_row[0]);
    near_y = kRow * static_cast<size_t>(r.near_row[1]);
    near_z = kRow * static_cast<size_t>(r.near_row[2]);
    far_x = near_x ^ kRow, far_y = near_y ^ kRow, far_z = near_z ^ kRow;
  }

  /// Which children the ray enters before t_max, and where, as bits of floats. These are compared
  /// as integers, which is faster: t_min is not negative, so of negative distances only the sign
  /// matters. That -0 counts as negative costs nothing: the offsets' margin makes a box that is
  /// touched at 0 be left later.
  HWY_INLINE uint32_t enter(const WideNode& node, float t_max, int32_t* entered) const {
    const FloatTag tag;
    const IntTag integer;
    const char* rows = reinterpret_cast<const char*>(&node);
    uint32_t mask = 0;
    for (size_t lane = 0; lane < 8; lane += hn::MaxLanes(tag), rows += sizeof(Lanes)) {
      const auto row = [&](size_t at) HWY_ATTR {
        return hn::Load(tag, reinterpret_cast<const float*>(rows + at));
      };
      const auto nx = hn::BitCast(integer, hn::MulSub(row(near_x), inverse_x, enter_x));
      const auto ny = hn::BitCast(integer, hn::MulSub(row(near_y), inverse_y, enter_y));
      const auto nz = hn::BitCast(integer, hn::MulSub(row(near_z), inverse_z, enter_z));
      const auto fx = hn::BitCast(integer, hn::MulSub(row(far_x), inverse_x, leave_x));
      const auto fy = hn::BitCast(integer, hn::MulSub(row(far_y), inverse_y, leave_y));
      const auto fz = hn::BitCast(integer, hn::MulSub(row(far_z), inverse_z, leave_z));
      // Paired, for the shortest chain of dependent operations.
      const auto limit = hn::BitCast(integer, hn::Set(tag, t_max));
      const auto first = hn::Max(hn::Max(nx, ny), hn::Max(nz, t_min));
      const auto last = hn::Min(hn::Min(fx, fy), hn::Min(fz, limit));
      hn::Store(first, integer, entered + lane);
      mask |= (movemask(integer, hn::Gt(first, last)) ^ ((1u << hn::MaxLanes(tag)) - 1)) << lane;
    }
    return mask;
  }

  /// How the way back to a child is kept.
  HWY_INLINE uint32_t name_child(uint32_t, uint32_t, uint32_t child) const { return child; }

 private:
  static constexpr size_t kRow = 8 * sizeof(float);
};

/// The same in double, for rays outside of the range of float and for trees that it is too coarse
/// for. What is not a number counts as entered.
struct WideRayLanes {
  using Lanes = hn::Vec<DoubleTag>;
  const BoxRay<double>& ray;

  /// Distances in `entered` are in single precision and not negative.
  HWY_INLINE uint32_t enter(const WideNode& node, double t_max, int32_t* entered) const {
    const DoubleTag tag;
    const HalfFloatTag half;
    uint32_t mask = 0;
    for (size_t lane = 0; lane < 8; lane += hn::MaxLanes(tag)) {
      const auto row = [&](int number) HWY_ATTR {
        return hn::PromoteTo(tag, hn::Load(half, node.bounds[number] + lane));
      };
      auto first = hn::Set(tag, ray.t_min), last = hn::Set(tag, t_max);
      for (int a = 0; a < 3; ++a) {
        const auto inverse = hn::Set(tag, ray.inverse[a]);
        const auto near =
            hn::MulSub(row(ray.near_row[a]), inverse, hn::Set(tag, ray.enter_offset[a]));
        const auto far =
            hn::MulSub(row(ray.near_row[a] ^ 1), inverse, hn::Set(tag, ray.leave_offset[a]));
        first = hn::IfThenElse(hn::Gt(near, first), near, first);
        last = hn::IfThenElse(hn::Lt(far, last), far, last);
      }
      const auto distance = hn::Min(hn::Max(first, hn::Zero(tag)), hn::Set(tag, kFarthest));
      hn::Store(hn::DemoteTo(half, hn::Abs(distance)), half,
                reinterpret_cast<float*>(entered) + lane);
      const auto is_there = hn::Le(row(0), row(1));
      mask |= movemask(tag, hn::AndNot(hn::Gt(first, last), is_there)) << lane;
    }
    return mask;
  }
  HWY_INLINE uint32_t name_child(uint32_t, uint32_t, uint32_t child) const { return child; }

  static constexpr double kFarthest = 0x1p127;
};

/// A limit as `enter` gives distances.
HWY_INLINE int32_t bits_of_limit(float t) { return std::bit_cast<int32_t>(t); }
HWY_INLINE int32_t bits_of_limit(double t) {
  const double inside = std::min(std::max(t, 0.0), WideRayLanes::kFarthest);
  return std::bit_cast<int32_t>(static_cast<float>(inside));
}

/// Has the compiler take a ray's numbers from memory again. It would keep them all through the test
/// of a leaf, which needs the registers: to write them out and read them back costs twice as much.
template <typename Numbers>
HWY_INLINE void reload(Numbers& ray) {
  asm volatile("" : "+m"(ray));
}
HWY_INLINE RayLanes lanes_of(const BoxRay<float>& ray) { return RayLanes(ray); }
HWY_INLINE WideRayLanes lanes_of(const BoxRay<double>& ray) { return {ray}; }

HWY_INLINE const TreeUnit* unit_at(const TreeUnit* units, uint32_t reference) {
  return units + (reference & ~TraversalTree::kLeaf);
}

/// Starts to load what is visited next or soon, with the leaves behind a node where there are any:
/// most of the time of a ray is waiting.
template <bool kLeaves>
HWY_INLINE void prefetch(const TreeUnit* units, uint32_t reference) {
  const char* at = reinterpret_cast<const char*>(unit_at(units, reference));
  if (!kLeaves && (reference & TraversalTree::kLeaf)) return;
  for (int line = 0; line < (kLeaves ? 8 : 4); ++line) __builtin_prefetch(at + 64 * line);
}

/// Visits nodes nearest first. `leaf(reference)` tests a leaf and says whether a nearer hit was
/// found, having lowered t_max. `kLeaves`: they are in the tree's array.
template <bool kLeaves, typename Rays, typename Limit, typename Leaf>
HWY_INLINE bool closest_in_tree(const TraversalTree& tree, Rays& rays, const Limit& t_max,
                                uint64_t& visits, Leaf&& leaf) {
  const TreeUnit* units = tree.units.data();
  Entry stack[kStackSize];
  Entry* top = stack;
  uint32_t current = tree.root;
  bool found = false;
  HWY_ALIGN int32_t entered[8];
  const auto pop = [&]() HWY_ATTR {
    const Entry limit = make_entry(bits_of_limit(t_max), ~0u);
    do {
      if (top == stack) return false;
      --top;
    } while (*top > limit);
    current = static_cast<uint32_t>(*top);
    return true;
  };
  for (;;) {
    if (!(current & TraversalTree::kLeaf)) {
      const auto lanes = lanes_of(rays);
      do {
        ++visits;
        const uint32_t current_node = current;
        const WideNode& node = *reinterpret_cast<const WideNode*>(units + current);
        uint32_t mask = lanes.enter(node, t_max, entered);
        if (mask == 0) {
          if (!pop()) return found;
          continue;
        }
        const auto take = [&]() HWY_ATTR {
          const auto i = static_cast<uint32_t>(std::countr_zero(mask));
          mask &= mask - 1;
          prefetch<kLeaves>(units, node.child[i]);
          return std::pair{i, lanes.name_child(current_node, i, node.child[i])};
        };
        const auto first = take();
        current = first.second;
        if (mask == 0) continue;
        const auto next = [&]() HWY_ATTR {
          const auto [i, child] = take();
          return make_entry(entered[i], child);
        };
        Entry a = make_entry(entered[first.first], current), b = next();
        sort(a, b);
        current = static_cast<uint32_t>(a);
        if (mask == 0) {
          *top++ = b;
          continue;
        }
        Entry c = next();
        sort(b, c), sort(a, b);
        current = static_cast<uint32_t>(a);
        if (mask == 0) {
          top[0] = c, top[1] = b;
          top += 2;
          continue;
        }
        Entry d = next();
        sort(c, d), sort(b, c), sort(a, b);
        Entry* const base = top;
        top[0] = d, top[1] = c, top[2] = b, top[3] = a;
        top += 4;
        while (mask != 0) {  // NOLINT(bugprone-infinite-loop): next() takes a bit off
          const Entry e = next();
          Entry* at = top++;
          for (; at > base && at[-1] < e; --at) *at = at[-1];
          *at = e;
        }
        current = static_cast<uint32_t>(*--top);
      } while (!(current & TraversalTree::kLeaf));
    }
    found |= leaf(current);
    reload(rays);
    if (!pop()) return found;
  }
}

/// `leaf(reference)` says whether enough is found.
template <bool kLeaves, typename Rays, typename Limit, typename Leaf>
HWY_INLINE bool any_in_tree(const TraversalTree& tree, Rays& rays, const Limit& t_max,
                            uint64_t& visits, Leaf&& leaf) {
  const TreeUnit* units = tree.units.data();
  uint32_t stack[kStackSize];
  uint32_t* top = stack;
  uint32_t current = tree.root;
  HWY_ALIGN int32_t entered[8];
  for (;;) {
    if (!(current & TraversalTree::kLeaf)) {
      const auto lanes = lanes_of(rays);
      do {
        ++visits;
        const uint32_t current_node = current;
        const WideNode& node = *reinterpret_cast<const WideNode*>(units + current);
        uint32_t mask = lanes.enter(node, t_max, entered);
        if (mask == 0) {
          if (top == stack) return false;
          current = *--top;
          continue;
        }
        const auto take = [&]() HWY_ATTR {
          const auto i = static_cast<uint32_t>(std::countr_zero(mask));
          mask &= mask - 1;
          prefetch<kLeaves>(units, node.child[i]);
          return lanes.name_child(current_node, i, node.child[i]);
        };
        current = take();
        while (mask != 0)  // NOLINT(bugprone-infinite-loop): take() takes a bit off
          *top++ = take();
      } while (!(current & TraversalTree::kLeaf));
    }
    if (leaf(current)) return true;
    reload(rays);
    if (top == stack) return false;
    current = *--top;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
