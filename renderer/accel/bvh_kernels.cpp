#include "renderer/accel/bvh_kernels.h"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "renderer/accel/box_ray.h"
#include "renderer/shapes/triangle.h"

// This file is compiled once for each instruction set. The sets named here add nothing we use.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/accel/bvh_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, 8>;
using DoubleTag = hn::CappedTag<double, 4>;
using HalfFloatTag = hn::Rebind<float, DoubleTag>;

/// Room for every child left behind on the way down the deepest tree.
constexpr size_t kStackSize = 7 * WideTree::kMaxDepth + 8;

/// Distance above, reference below: sorts by distance, and fits a register. Distances compare as
/// integers; of negative ones only the order of visits depends, never what is visited.
using Entry = int64_t;
HWY_INLINE Entry make_entry(float distance, uint32_t reference) {
  return static_cast<Entry>(uint64_t{std::bit_cast<uint32_t>(distance)} << 32 | reference);
}
HWY_INLINE float distance_of(Entry e) {
  return std::bit_cast<float>(static_cast<uint32_t>(static_cast<uint64_t>(e) >> 32));
}

template <typename Tag, typename Mask>
HWY_INLINE uint32_t bits_of(Tag tag, Mask mask) {
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(tag, mask, bytes);
  return bytes[0];
}

/// What a box test wants of a ray in every lane, kept in registers.
struct RayLanes {
  using Lanes = hn::Vec<FloatTag>;
  Lanes inverse_x, inverse_y, inverse_z, enter_x, enter_y, enter_z, leave_x, leave_y, leave_z,
      t_min;
  size_t near_x, near_y, near_z, far_x, far_y, far_z;  // in floats from the start of a node

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
    t_min = hn::Set(tag, r.t_min);
    near_x = 8 * static_cast<size_t>(r.near_row[0]);
    near_y = 8 * static_cast<size_t>(r.near_row[1]);
    near_z = 8 * static_cast<size_t>(r.near_row[2]);
    far_x = 8 * static_cast<size_t>(r.far_row[0]);
    far_y = 8 * static_cast<size_t>(r.far_row[1]);
    far_z = 8 * static_cast<size_t>(r.far_row[2]);
  }

  /// Which children the ray enters before t_max, and where.
  HWY_INLINE uint32_t enter(const WideNode& node, float t_max, float* entered) const {
    const FloatTag tag;
    const float* rows = node.bounds[0];
    uint32_t mask = 0;
    for (size_t lane = 0; lane < 8; lane += hn::MaxLanes(tag), rows += hn::MaxLanes(tag)) {
      const auto nx = hn::MulSub(hn::Load(tag, rows + near_x), inverse_x, enter_x);
      const auto ny = hn::MulSub(hn::Load(tag, rows + near_y), inverse_y, enter_y);
      const auto nz = hn::MulSub(hn::Load(tag, rows + near_z), inverse_z, enter_z);
      const auto fx = hn::MulSub(hn::Load(tag, rows + far_x), inverse_x, leave_x);
      const auto fy = hn::MulSub(hn::Load(tag, rows + far_y), inverse_y, leave_y);
      const auto fz = hn::MulSub(hn::Load(tag, rows + far_z), inverse_z, leave_z);
      // Paired, for the shortest chain of dependent operations.
      const auto first = hn::Max(hn::Max(nx, ny), hn::Max(nz, t_min));
      const auto last = hn::Min(hn::Min(fx, fy), hn::Min(fz, hn::Set(tag, t_max)));
      hn::Store(first, tag, entered + lane);
      mask |= bits_of(tag, hn::Le(first, last)) << lane;
    }
    return mask;
  }
};

/// Starts to load what is visited next or soon: most of the time of a ray is waiting.
struct LeafMemory {
  const void* first;
  size_t block_bytes;
};
HWY_INLINE void prefetch(const WideNode* nodes, LeafMemory blocks, uint32_t reference) {
  const NodeReference r{reference};
  const char* node = reinterpret_cast<const char*>(nodes + reference);
  const char* at =
      r.is_leaf() ? static_cast<const char*>(blocks.first) + r.first_block() * blocks.block_bytes
                  : node;
  __builtin_prefetch(at);
  __builtin_prefetch(at + 64);
  __builtin_prefetch(at + 128);
  __builtin_prefetch(at + 192);
}

/// Visits nodes nearest first. `leaf(reference)` tests a leaf and says whether a nearer hit was
/// found, having lowered ray.t_max.
template <typename Leaf>
HWY_INLINE bool closest_in_tree(const WideTree& tree, LeafMemory blocks, BoxRay<float>& ray,
                                uint64_t& visits, Leaf&& leaf) {
  const WideNode* nodes = tree.nodes.data();
  Entry stack[kStackSize];
  size_t size = 0;
  uint32_t current = tree.root.bits;
  bool found = false;
  const RayLanes lanes(ray);
  HWY_ALIGN float entered[8];
  for (;;) {
    while (!(current & NodeReference::kLeaf)) {
      ++visits;
      const WideNode& node = nodes[current];
      uint32_t mask = lanes.enter(node, ray.t_max, entered);
      if (mask == 0) goto pop;
      const auto first = static_cast<uint32_t>(std::countr_zero(mask));
      current = node.child[first];
      mask &= mask - 1;
      if (mask == 0) continue;
      const auto second = static_cast<uint32_t>(std::countr_zero(mask));
      mask &= mask - 1;
      Entry a = make_entry(entered[first], current);
      Entry b = make_entry(entered[second], node.child[second]);
      prefetch(nodes, blocks, current);
      prefetch(nodes, blocks, node.child[second]);
      if (mask == 0) {
        stack[size++] = std::max(a, b);
        current = static_cast<uint32_t>(std::min(a, b));
        continue;
      }
      const size_t base = size;
      stack[size++] = std::max(a, b);
      stack[size++] = std::min(a, b);
      do {
        const auto next = static_cast<uint32_t>(std::countr_zero(mask));
        mask &= mask - 1;
        const Entry c = make_entry(entered[next], node.child[next]);
        prefetch(nodes, blocks, node.child[next]);
        size_t at = size++;
        for (; at > base && stack[at - 1] < c; --at) stack[at] = stack[at - 1];
        stack[at] = c;
      } while (mask != 0);
      current = static_cast<uint32_t>(stack[--size]);
    }
    found |= leaf(NodeReference{current});
  pop:
    do {
      if (size == 0) return found;
      --size;
    } while (distance_of(stack[size]) > ray.t_max);
    current = static_cast<uint32_t>(stack[size]);
  }
}

/// `leaf(reference)` says whether anything in it is hit.
template <typename Leaf>
HWY_INLINE bool any_in_tree(const WideTree& tree, LeafMemory blocks, const BoxRay<float>& ray,
                            uint64_t& visits, Leaf&& leaf) {
  const WideNode* nodes = tree.nodes.data();
  uint32_t stack[kStackSize];
  size_t size = 0;
  uint32_t current = tree.root.bits;
  const RayLanes lanes(ray);
  HWY_ALIGN float entered[8];
  for (;;) {
    while (!(current & NodeReference::kLeaf)) {
      ++visits;
      const WideNode& node = nodes[current];
      uint32_t mask = lanes.enter(node, ray.t_max, entered);
      if (mask == 0) goto pop;
      current = node.child[std::countr_zero(mask)];
      prefetch(nodes, blocks, current);
      for (mask &= mask - 1; mask != 0; mask &= mask - 1) {
        stack[size++] = node.child[std::countr_zero(mask)];
        prefetch(nodes, blocks, stack[size - 1]);
      }
    }
    if (leaf(NodeReference{current})) return true;
  pop:
    if (size == 0) return false;
    current = stack[--size];
  }
}

/// For rays outside of the range of float: the same visits in double, one box at a time. Anything
/// that is not a number counts as entered. `leaf` returns true to stop.
template <typename Leaf>
void visit_in_double(const WideTree& tree, const BoxRay<double>& ray, uint64_t& visits,
                     Leaf&& leaf) {
  uint32_t stack[kStackSize];
  size_t size = 0;
  stack[size++] = tree.root.bits;
  while (size > 0) {
    const NodeReference current{stack[--size]};
    if (current.is_leaf()) {
      if (leaf(current)) return;
      continue;
    }
    ++visits;
    const WideNode& node = tree.nodes.data()[current.bits];
    for (int i = 0; i < 8; ++i) {
      if (!(node.bounds[0][i] <= node.bounds[1][i])) continue;
      bool missed = false;
      double enter = ray.t_min, leave = ray.t_max;
      for (int a = 0; a < 3; ++a) {
        const double near =
            double{node.bounds[ray.near_row[a]][i]} * ray.inverse[a] - ray.enter_offset[a];
        const double far =
            double{node.bounds[ray.far_row[a]][i]} * ray.inverse[a] - ray.leave_offset[a];
        if (near > enter) enter = near;
        if (far < leave) leave = far;
      }
      missed = enter > leave;
      if (!missed) stack[size++] = node.child[i];
    }
  }
}

/// The exact test, four triangles at a time: the operations and their order are those of shear() in
/// triangle.h, so the edge functions have the same bits.
class TriangleTester {
 public:
  TriangleTester(const MeshTree& mesh, const TriangleRay& ray) : mesh_(mesh), ray_(ray) {}

  HWY_INLINE bool closest(NodeReference leaf, Hit& hit, uint64_t& tests) const {
    bool found = false;
    ShearedLanes lanes;
    const TriangleBlock* block = mesh_.blocks.data() + leaf.first_block();
    for (uint32_t left = leaf.blocks(); left > 0; --left, ++block) {
      tests += 4;
      for (uint32_t mask = candidates(*block, hit.t, lanes); mask != 0; mask &= mask - 1) {
        const int lane = std::countr_zero(mask);
        TriangleHit h;
        if (!confirm(*block, lanes, lane, h)) continue;
        const uint32_t primitive = block->primitive[lane];
        if (h.t > hit.t || (h.t == hit.t && primitive >= hit.primitive)) continue;
        hit = {h.t, h.u, h.v, hit.instance, primitive};
        found = true;
      }
    }
    return found;
  }

  HWY_INLINE bool any(NodeReference leaf, uint64_t& tests) const {
    ShearedLanes lanes;
    const TriangleBlock* block = mesh_.blocks.data() + leaf.first_block();
    for (uint32_t left = leaf.blocks(); left > 0; --left, ++block) {
      tests += 4;
      for (uint32_t mask = candidates(*block, ray_.t_max, lanes); mask != 0; mask &= mask - 1) {
        TriangleHit h;
        if (confirm(*block, lanes, std::countr_zero(mask), h)) return true;
      }
    }
    return false;
  }

 private:
  /// ShearedTriangle for each lane of a block: rows are its members in order.
  struct alignas(32) ShearedLanes {
    double row[12][4];
  };

  /// Triangles of a block whose edge functions do not differ in sign and that begin before `t_max`.
  HWY_INLINE uint32_t candidates(const TriangleBlock& block, double t_max,
                                 ShearedLanes& lanes) const {
    const DoubleTag tag;
    const HalfFloatTag half;
    uint32_t mask = 0;
    for (size_t lane = 0; lane < 4; lane += hn::MaxLanes(tag)) {
      const auto ox = hn::Set(tag, ray_.origin.x), oy = hn::Set(tag, ray_.origin.y);
      const auto oz = hn::Set(tag, ray_.origin.z), sx = hn::Set(tag, ray_.sx);
      const auto sy = hn::Set(tag, ray_.sy), sz = hn::Set(tag, ray_.sz);
      const auto load = [&](int vertex, int axis) HWY_ATTR {
        return hn::PromoteTo(tag, hn::Load(half, block.vertex[vertex][axis] + lane));
      };
      const auto adz = hn::Sub(load(0, ray_.kz), oz);
      const auto bdz = hn::Sub(load(1, ray_.kz), oz);
      const auto cdz = hn::Sub(load(2, ray_.kz), oz);
      const auto ax = hn::Sub(hn::Sub(load(0, ray_.kx), ox), hn::Mul(sx, adz));
      const auto bx = hn::Sub(hn::Sub(load(1, ray_.kx), ox), hn::Mul(sx, bdz));
      const auto cx = hn::Sub(hn::Sub(load(2, ray_.kx), ox), hn::Mul(sx, cdz));
      const auto ay = hn::Sub(hn::Sub(load(0, ray_.ky), oy), hn::Mul(sy, adz));
      const auto by = hn::Sub(hn::Sub(load(1, ray_.ky), oy), hn::Mul(sy, bdz));
      const auto cy = hn::Sub(hn::Sub(load(2, ray_.ky), oy), hn::Mul(sy, cdz));
      const auto u = hn::Sub(hn::Mul(cx, by), hn::Mul(cy, bx));
      const auto v = hn::Sub(hn::Mul(ax, cy), hn::Mul(ay, cx));
      const auto w = hn::Sub(hn::Mul(bx, ay), hn::Mul(by, ax));
      const auto zero = hn::Zero(tag);
      const auto one_sided =
          hn::Or(hn::Ge(hn::Min(hn::Min(u, v), w), zero), hn::Le(hn::Max(hn::Max(u, v), w), zero));
      // t is never below the nearest vertex by more than rounding.
      const auto az = hn::Mul(sz, adz), bz = hn::Mul(sz, bdz), cz = hn::Mul(sz, cdz);
      const auto nearest = hn::Mul(hn::Min(hn::Min(az, bz), cz), hn::Set(tag, 1 - 0x1p-40));
      const auto in_reach = hn::Le(nearest, hn::Set(tag, t_max));
      const uint32_t bits = bits_of(tag, hn::And(one_sided, in_reach));
      if (bits == 0) continue;
      mask |= bits << lane;
      const auto keep = [&](size_t row, auto value)
                            HWY_ATTR { hn::Store(value, tag, lanes.row[row] + lane); };
      keep(0, ax), keep(1, ay), keep(2, az);
      keep(3, bx), keep(4, by), keep(5, bz);
      keep(6, cx), keep(7, cy), keep(8, cz);
      keep(9, u), keep(10, v), keep(11, w);
    }
    return mask;
  }

  HWY_INLINE bool confirm(const TriangleBlock& block, const ShearedLanes& lanes, int lane,
                          TriangleHit& hit) const {
    const auto at = [&](int row) HWY_ATTR { return lanes.row[row][lane]; };
    ShearedTriangle s{at(0), at(1), at(2), at(3), at(4),  at(5),
                      at(6), at(7), at(8), at(9), at(10), at(11)};
    const auto corners = [&]() HWY_ATTR {
      std::array<Point3, 3> corner;
      for (int vertex = 0; vertex < 3; ++vertex)
        for (int a = 0; a < 3; ++a)
          corner[static_cast<size_t>(vertex)][a] = block.vertex[vertex][a][lane];
      return corner;
    };
    return finish_triangle(ray_, s, corners, hit);
  }

 private:
  const MeshTree& mesh_;
  const TriangleRay& ray_;
};

/// The way out for rays that single precision cannot hold; kept apart so that the usual way stays
/// short.
HWY_NOINLINE bool mesh_closest_in_double(const MeshTree& mesh, const TriangleRay& ray,
                                         const RayFrame& frame, Hit& hit,
                                         TraversalCounters& counters) {
  const TriangleTester tester(mesh, ray);
  bool found = false;
  visit_in_double(mesh.tree, make_box_ray<double>(frame), counters.node_visits,
                  [&](NodeReference leaf) HWY_ATTR {
                    found |= tester.closest(leaf, hit, counters.primitive_tests);
                    return false;
                  });
  return found;
}

HWY_NOINLINE bool mesh_any_in_double(const MeshTree& mesh, const TriangleRay& ray,
                                     const RayFrame& frame, TraversalCounters& counters) {
  const TriangleTester tester(mesh, ray);
  bool found = false;
  visit_in_double(mesh.tree, make_box_ray<double>(frame), counters.node_visits,
                  [&](NodeReference leaf)
                      HWY_ATTR { return found = tester.any(leaf, counters.primitive_tests); });
  return found;
}

bool mesh_closest(const MeshTree& mesh, const Ray& ray, Hit& hit, TraversalCounters& counters) {
  const TriangleRay prepared(ray);
  if (!prepared.valid()) return false;
  // What a few triangles need is less than a box test's preparation.
  if (mesh.tree.root.is_leaf())
    return TriangleTester(mesh, prepared).closest(mesh.tree.root, hit, counters.primitive_tests);
  const RayFrame frame =
      make_ray_frame(ray, std::min(ray.t_max, hit.t), mesh.bounds, double{mesh.tree.extent});
  if (frame.misses) return false;
  if (!frame.fits_float) [[unlikely]]
    return mesh_closest_in_double(mesh, prepared, frame, hit, counters);
  const TriangleTester tester(mesh, prepared);
  BoxRay<float> box_ray = make_box_ray<float>(frame);
  TraversalCounters done;
  const bool found = closest_in_tree(
      mesh.tree, {mesh.blocks.data(), sizeof(TriangleBlock)}, box_ray,
      done.node_visits, [&](NodeReference leaf) HWY_ATTR __attribute__((always_inline)) {
        if (!tester.closest(leaf, hit, done.primitive_tests)) return false;
        box_ray.t_max = box_ray.limit(hit.t);
        return true;
      });
  counters.node_visits += done.node_visits;
  counters.primitive_tests += done.primitive_tests;
  return found;
}

bool mesh_any(const MeshTree& mesh, const Ray& ray, TraversalCounters& counters) {
  const TriangleRay prepared(ray);
  if (!prepared.valid()) return false;
  if (mesh.tree.root.is_leaf())
    return TriangleTester(mesh, prepared).any(mesh.tree.root, counters.primitive_tests);
  const RayFrame frame = make_ray_frame(ray, ray.t_max, mesh.bounds, double{mesh.tree.extent});
  if (frame.misses) return false;
  if (!frame.fits_float) [[unlikely]]
    return mesh_any_in_double(mesh, prepared, frame, counters);
  const TriangleTester tester(mesh, prepared);
  TraversalCounters done;
  const bool found = any_in_tree(
      mesh.tree, {mesh.blocks.data(), sizeof(TriangleBlock)}, make_box_ray<float>(frame),
      done.node_visits, [&](NodeReference leaf) HWY_ATTR __attribute__((always_inline)) {
        return tester.any(leaf, done.primitive_tests);
      });
  counters.node_visits += done.node_visits;
  counters.primitive_tests += done.primitive_tests;
  return found;
}

/// Remembers instances that a ray was tested against: an octree holds one in several leaves.
class Mailbox {
 public:
  Mailbox() { std::fill(std::begin(tested_), std::end(tested_), WideTree::kEmptySlot); }
  bool tested(uint32_t number) {
    uint32_t& place = tested_[number % std::size(tested_)];
    if (place == number) return true;
    place = number;
    return false;
  }

 private:
  uint32_t tested_[8];
};

bool instance_closest(const InstanceTree& scene, const Ray& ray, Hit& hit,
                      TraversalCounters& counters) {
  if (!can_hit(ray)) return false;
  bool found = false;
  for (const uint32_t i : scene.endless)
    found |= closest_hit_of(scene.instances[i], i, ray, hit, counters);
  Mailbox mailbox;
  const auto test = [&](NodeReference leaf) HWY_ATTR {
    bool nearer = false;
    for (uint32_t i = 0; i < leaf.blocks(); ++i) {
      const uint32_t number = scene.tree.slots[leaf.first_block() + i];
      if (mailbox.tested(number)) continue;
      nearer |= closest_hit_of(scene.instances[number], number, ray, hit, counters);
    }
    return nearer;
  };
  const RayFrame frame =
      make_ray_frame(ray, std::min(ray.t_max, hit.t), scene.tree_bounds, double{scene.tree.extent});
  if (frame.misses) return found;
  if (!frame.fits_float) [[unlikely]] {
    visit_in_double(scene.tree, make_box_ray<double>(frame), counters.node_visits,
                    [&](NodeReference leaf) HWY_ATTR {
                      found |= test(leaf);
                      return false;
                    });
    return found;
  }
  BoxRay<float> box_ray = make_box_ray<float>(frame);
  const bool in_tree = closest_in_tree(scene.tree, {scene.tree.slots.data(), 4}, box_ray,
                                       counters.node_visits, [&](NodeReference leaf) HWY_ATTR {
                                         if (!test(leaf)) return false;
                                         box_ray.t_max = box_ray.limit(hit.t);
                                         return true;
                                       });
  return found || in_tree;
}

bool instance_any(const InstanceTree& scene, const Ray& ray, TraversalCounters& counters) {
  if (!can_hit(ray)) return false;
  for (const uint32_t i : scene.endless)
    if (any_hit_of(scene.instances[i], ray, counters)) return true;
  Mailbox mailbox;
  const auto test = [&](NodeReference leaf) HWY_ATTR {
    for (uint32_t i = 0; i < leaf.blocks(); ++i) {
      const uint32_t number = scene.tree.slots[leaf.first_block() + i];
      if (mailbox.tested(number)) continue;
      if (any_hit_of(scene.instances[number], ray, counters)) return true;
    }
    return false;
  };
  const RayFrame frame =
      make_ray_frame(ray, ray.t_max, scene.tree_bounds, double{scene.tree.extent});
  if (frame.misses) return false;
  if (!frame.fits_float) [[unlikely]] {
    bool found = false;
    visit_in_double(scene.tree, make_box_ray<double>(frame), counters.node_visits,
                    [&](NodeReference at) HWY_ATTR { return found = test(at); });
    return found;
  }
  return any_in_tree(scene.tree, {scene.tree.slots.data(), 4}, make_box_ray<float>(frame),
                     counters.node_visits, test);
}

BvhKernels kernels_of_target() {
  return {mesh_closest, mesh_any, instance_closest, instance_any, hwy::TargetName(HWY_TARGET)};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {

HWY_EXPORT(kernels_of_target);

const BvhKernels& kernels() {
  static const BvhKernels best = HWY_DYNAMIC_DISPATCH(kernels_of_target)();
  return best;
}

std::span<const BvhKernels> all_kernels() {
  static const std::vector<BvhKernels> all = [] {
    kernels();  // chosen before the choice is tampered with
    std::vector<BvhKernels> list;
    for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      list.push_back(HWY_DYNAMIC_DISPATCH(kernels_of_target)());
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return list;
  }();
  return all;
}

}  // namespace tessera
#endif  // HWY_ONCE
