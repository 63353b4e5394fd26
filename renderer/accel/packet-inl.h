// Part of bvh_kernels.cpp, compiled once for each instruction set: rays that go together.
#if defined(TESSERA_PACKET_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_PACKET_INL_H
#undef TESSERA_PACKET_INL_H
#else
#define TESSERA_PACKET_INL_H
#endif

#include <bit>
#include <cstdint>
#include <new>

#include "base/uninitialized.h"
#include "renderer/accel/test_triangles-inl.h"
#include "renderer/accel/traverse-inl.h"
#include "renderer/math/mask_bits-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// The box test's numbers of every ray of a packet. Places without a ray end before they begin.
struct PacketRays {
  alignas(32) float inverse[3][kPacketSize], enter[3][kPacketSize], leave[3][kPacketSize];
  alignas(32) float t_min[kPacketSize], t_max[kPacketSize];
  int near_row[3];
  float lowest[3], highest[3];  ///< origins, with the margin
  /// Fewer are faster one by one.
  static constexpr size_t kLeast = 2;

  /// Up to `hits`, if there are any. False for too few rays, where a ray is unusual or leaves the
  /// others' octant.
  HWY_INLINE bool set(std::span<const Ray> rays, std::span<const Hit> hits, float extent) {
    if (rays.size() < kLeast) return false;
    for (size_t r = 0; r < kPacketSize; ++r) {
      const bool used = r < rays.size();
      const Ray& ray = rays[used ? r : 0];
      const double last = hits.empty() ? ray.t_max : std::min(ray.t_max, hits[used ? r : 0].t);
      BoxRay<float> b;
      if (!make_usual_box_ray(ray, last, extent, b)) return false;
      for (int a = 0; a < 3; ++a) {
        if (r == 0)
          near_row[a] = b.near_row[a], lowest[a] = Bounds3::kInfinity, highest[a] = -lowest[a];
        if (b.near_row[a] != near_row[a]) return false;
        inverse[a][r] = b.inverse[a];
        enter[a][r] = b.enter_offset[a];
        leave[a][r] = b.leave_offset[a];
        const auto origin = static_cast<float>(ray.origin[a]);
        lowest[a] = std::min(lowest[a], origin);
        highest[a] = std::max(highest[a], origin);
      }
      t_min[r] = b.t_min;
      t_max[r] = used ? b.t_max : -1;
    }
    float size = extent;
    for (int a = 0; a < 3; ++a) size = std::max({size, std::abs(lowest[a]), std::abs(highest[a])});
    for (int a = 0; a < 3; ++a) {
      lowest[a] -= size * static_cast<float>(BoxRay<float>::kMargin);
      highest[a] += size * static_cast<float>(BoxRay<float>::kMargin);
    }
    return true;
  }

  /// Rays that enter a child of a node, by bits.
  HWY_INLINE uint32_t enter_child(const WideNode& node, uint32_t child) const {
    const FloatTag tag;
    uint32_t mask = 0;
    const auto near = [&](int a) HWY_ATTR { return hn::Set(tag, node.bounds[near_row[a]][child]); };
    const auto far = [&](int a)
                         HWY_ATTR { return hn::Set(tag, node.bounds[near_row[a] ^ 1][child]); };
    for (size_t r = 0; r < kPacketSize; r += hn::MaxLanes(tag)) {
      const auto ix = hn::Load(tag, inverse[0] + r), iy = hn::Load(tag, inverse[1] + r);
      const auto iz = hn::Load(tag, inverse[2] + r);
      const auto nx = hn::MulSub(near(0), ix, hn::Load(tag, enter[0] + r));
      const auto ny = hn::MulSub(near(1), iy, hn::Load(tag, enter[1] + r));
      const auto nz = hn::MulSub(near(2), iz, hn::Load(tag, enter[2] + r));
      const auto fx = hn::MulSub(far(0), ix, hn::Load(tag, leave[0] + r));
      const auto fy = hn::MulSub(far(1), iy, hn::Load(tag, leave[1] + r));
      const auto fz = hn::MulSub(far(2), iz, hn::Load(tag, leave[2] + r));
      const auto first = hn::Max(hn::Max(nx, ny), hn::Max(nz, hn::Load(tag, t_min + r)));
      const auto last = hn::Min(hn::Min(fx, fy), hn::Min(fz, hn::Load(tag, t_max + r)));
      mask |= movemask(tag, hn::Le(first, last)) << r;
    }
    return mask;
  }

  HWY_INLINE void end_at(size_t r, double t) {
    t_max[r] = static_cast<float>(t * (1 + BoxRay<float>::kMargin));
  }
  HWY_INLINE void end(size_t r) { t_max[r] = -1; }
  HWY_INLINE float last_t_max() const {
    const FloatTag tag;
    auto v = hn::Load(tag, t_max);
    for (size_t r = hn::MaxLanes(tag); r < kPacketSize; r += hn::MaxLanes(tag))
      v = hn::Max(v, hn::Load(tag, t_max + r));
    return hn::GetLane(hn::MaxOfLanes(tag, v));
  }
};

/// Boxes against all rays of a packet at once, by intervals of origins and reciprocals: what any
/// ray enters is entered. The margin covers the rounding here as it does in make_usual_box_ray().
struct PacketLanes {
  using Lanes = hn::Vec<FloatTag>;
  Lanes near_x, near_y, near_z, far_x, far_y, far_z;  // origins to measure from
  Lanes low_x, low_y, low_z, high_x, high_y, high_z;  // reciprocals
  hn::Vec<IntTag> t_min;

  HWY_INLINE explicit PacketLanes(const PacketRays& r) {
    const FloatTag tag;
    const auto origin = [&](int a, bool near) HWY_ATTR {
      return hn::Set(tag, ((r.near_row[a] & 1) != 0) == near ? r.lowest[a] : r.highest[a]);
    };
    near_x = origin(0, true), near_y = origin(1, true), near_z = origin(2, true);
    far_x = origin(0, false), far_y = origin(1, false), far_z = origin(2, false);
    const auto extremes = [&](const float* v, Lanes& low, Lanes& high) HWY_ATTR {
      low = high = hn::Load(tag, v);
      for (size_t at = hn::MaxLanes(tag); at < kPacketSize; at += hn::MaxLanes(tag)) {
        low = hn::Min(low, hn::Load(tag, v + at));
        high = hn::Max(high, hn::Load(tag, v + at));
      }
      low = hn::MinOfLanes(tag, low), high = hn::MaxOfLanes(tag, high);
    };
    extremes(r.inverse[0], low_x, high_x);
    extremes(r.inverse[1], low_y, high_y);
    extremes(r.inverse[2], low_z, high_z);
    Lanes first, unused;
    extremes(r.t_min, first, unused);
    t_min = hn::BitCast(IntTag(), first);
    for (int a = 0; a < 3; ++a) {
      near_at[a] = 8 * static_cast<size_t>(r.near_row[a]);
      far_at[a] = 8 * static_cast<size_t>(r.near_row[a] ^ 1);
    }
  }

  HWY_INLINE uint32_t enter(const WideNode& node, float t_max, int32_t* entered) const {
    const FloatTag tag;
    const IntTag integer;
    uint32_t mask = 0;
    for (size_t lane = 0; lane < 8; lane += hn::MaxLanes(tag)) {
      const float* row = node.bounds[0] + lane;
      const auto near = [&](int a, Lanes from, Lanes low, Lanes high) HWY_ATTR {
        const auto d = hn::Sub(hn::Load(tag, row + near_at[a]), from);
        return hn::BitCast(integer, hn::Min(hn::Mul(d, low), hn::Mul(d, high)));
      };
      const auto far = [&](int a, Lanes from, Lanes low, Lanes high) HWY_ATTR {
        const auto d = hn::Sub(hn::Load(tag, row + far_at[a]), from);
        return hn::BitCast(integer, hn::Max(hn::Mul(d, low), hn::Mul(d, high)));
      };
      const auto limit = hn::BitCast(integer, hn::Set(tag, t_max));
      const auto first =
          hn::Max(hn::Max(near(0, near_x, low_x, high_x), near(1, near_y, low_y, high_y)),
                  hn::Max(near(2, near_z, low_z, high_z), t_min));
      const auto last = hn::Min(hn::Min(far(0, far_x, low_x, high_x), far(1, far_y, low_y, high_y)),
                                hn::Min(far(2, far_z, low_z, high_z), limit));
      hn::Store(first, integer, entered + lane);
      mask |= (movemask(integer, hn::Gt(first, last)) ^ ((1u << hn::MaxLanes(tag)) - 1)) << lane;
    }
    return mask;
  }

  /// A leaf is kept as its node and its place there, where its box is.
  HWY_INLINE uint32_t name_child(uint32_t node, uint32_t place, uint32_t child) const {
    return child & TraversalTree::kLeaf ? TraversalTree::kLeaf | node << 3 | place : child;
  }
  static constexpr size_t kMaxUnits = size_t{1} << 28;

 private:
  size_t near_at[3], far_at[3];  // in floats from the start of a node
};

HWY_INLINE PacketLanes lanes_of(const PacketLanes& lanes) { return lanes; }

/// What the exact test wants of each ray of a packet.
struct PreparedRays {
  alignas(TriangleRay) std::byte memory[kPacketSize * sizeof(TriangleRay)];
  bool ready = false;

  HWY_NOINLINE void set(std::span<const Ray> rays) {
    for (size_t r = 0; r < rays.size(); ++r)
      new (memory + r * sizeof(TriangleRay)) TriangleRay(rays[r]);
    ready = true;
  }
  HWY_INLINE const TriangleRay& operator[](size_t r) const {
    return *std::launder(reinterpret_cast<const TriangleRay*>(memory) + r);
  }
};

/// Whether packets can go through the tree.
HWY_INLINE bool takes_packets(const TraversalTree& tree) {
  return !(tree.root & TraversalTree::kLeaf) && tree.units.size() < PacketLanes::kMaxUnits;
}

/// The node and the place there that PacketLanes::name_child() made a leaf's name of.
struct PacketLeaf {
  const WideNode& node;
  uint32_t place;

  HWY_INLINE PacketLeaf(const TraversalTree& tree, uint32_t name)
      : node(*reinterpret_cast<const WideNode*>(tree.units.data() +
                                                ((name & ~TraversalTree::kLeaf) >> 3))),
        place(name & 7) {}
  HWY_INLINE uint32_t reference() const { return node.child[place]; }
};

/// Whether the mesh's tree takes the packet, which is set up then.
HWY_INLINE bool set_up(const MeshTree& mesh, std::span<const Ray> rays, std::span<const Hit> hits,
                       PacketRays& packet) {
  if (!takes_packets(mesh.tree)) return false;
  if (mesh.cut_planes.count > 0) {
    for (const Ray& ray : rays)
      if (mesh.cut_planes.must_visit_all(ray, mesh.tree.extent)) return false;
  }
  return packet.set(rays, hits, mesh.tree.usual_extent);
}

bool mesh_closest_packet(const MeshTree& mesh, std::span<const Ray> rays, std::span<Hit> hits,
                         TraversalCounters& counters) {
  PacketRays packet;
  if (!set_up(mesh, rays, hits, packet)) return false;
  PreparedRays prepared;  // once one of them enters a leaf
  TraversalCounters done;
  float t_max = packet.last_t_max();
  PacketLanes lanes(packet);
  closest_in_tree<true>(
      mesh.tree, lanes, t_max,
      done.node_visits, [&](uint32_t name) HWY_ATTR __attribute__((always_inline)) {
        const PacketLeaf leaf(mesh.tree, name);
        bool nearer = false;
        uint32_t mask = packet.enter_child(leaf.node, leaf.place);
        if (mask != 0 && !prepared.ready) prepared.set(rays);
        for (; mask != 0; mask &= mask - 1) {
          const auto r = static_cast<size_t>(std::countr_zero(mask));
          const TriangleTester tester(mesh, prepared[r]);
          if (!tester.closest(leaf.reference(), hits[r], done.primitive_tests)) continue;
          packet.end_at(r, hits[r].t);
          nearer = true;
        }
        if (nearer) t_max = packet.last_t_max();
        return nearer;
      });
  counters.node_visits += done.node_visits;
  counters.primitive_tests += done.primitive_tests;
  return true;
}

bool mesh_any_packet(const MeshTree& mesh, std::span<const Ray> rays, uint32_t& hit,
                     TraversalCounters& counters) {
  PacketRays packet;
  if (!set_up(mesh, rays, {}, packet)) return false;
  PreparedRays prepared;
  TraversalCounters done;
  float t_max = packet.last_t_max();
  PacketLanes lanes(packet);
  hit = 0;
  any_in_tree<true>(
      mesh.tree, lanes, t_max,
      done.node_visits, [&](uint32_t name) HWY_ATTR __attribute__((always_inline)) {
        const PacketLeaf leaf(mesh.tree, name);
        const uint32_t before = hit;
        uint32_t mask = packet.enter_child(leaf.node, leaf.place);
        if (mask != 0 && !prepared.ready) prepared.set(rays);
        for (; mask != 0; mask &= mask - 1) {
          const auto r = static_cast<size_t>(std::countr_zero(mask));
          const TriangleTester tester(mesh, prepared[r]);
          if (!tester.any(leaf.reference(), done.primitive_tests)) continue;
          hit |= 1u << r;
          packet.end(r);
        }
        if (hit == before) return false;
        t_max = packet.last_t_max();
        return t_max < 0;
      });
  counters.node_visits += done.node_visits;
  counters.primitive_tests += done.primitive_tests;
  return true;
}

/// Some rays of a packet, by bits.
struct SomeRays {
  Uninitialized<Ray, kPacketSize> rays;
  uint32_t number[kPacketSize];
  size_t count = 0;

  HWY_INLINE SomeRays(std::span<const Ray> all, uint32_t mask) {
    for (; mask != 0; mask &= mask - 1) {
      number[count] = static_cast<uint32_t>(std::countr_zero(mask));
      rays[count] = all[number[count]];
      ++count;
    }
  }
  HWY_INLINE std::span<const Ray> span() const { return {rays.data(), count}; }
};

/// Tests the rays of `mask` against one instance, and updates their hits.
HWY_NOINLINE void closest_of_some(const Instance& instance, uint32_t number,
                                  std::span<const Ray> rays, std::span<Hit> hits, uint32_t mask,
                                  TraversalCounters& counters) {
  if (!instance.shape->takes_batches()) {
    for (; mask != 0; mask &= mask - 1) {
      const auto r = static_cast<size_t>(std::countr_zero(mask));
      closest_hit_of(instance, number, rays[r], hits[r], counters);
    }
    return;
  }
  const SomeRays some(rays, mask);
  Uninitialized<Hit, kPacketSize> theirs;
  for (size_t i = 0; i < some.count; ++i) theirs[i] = hits[some.number[i]];
  closest_hits_of(instance, number, some.span(), {theirs.data(), some.count}, counters);
  for (size_t i = 0; i < some.count; ++i) hits[some.number[i]] = theirs[i];
}

HWY_NOINLINE uint32_t any_of_some(const Instance& instance, std::span<const Ray> rays,
                                  uint32_t mask, TraversalCounters& counters) {
  uint32_t hit = 0;
  if (!instance.shape->takes_batches()) {
    for (; mask != 0; mask &= mask - 1) {
      const int r = std::countr_zero(mask);
      if (any_hit_of(instance, rays[static_cast<size_t>(r)], counters)) hit |= 1u << r;
    }
    return hit;
  }
  const SomeRays some(rays, mask);
  for (uint64_t left = any_hits_of(instance, some.span(), counters); left != 0; left &= left - 1)
    hit |= 1u << some.number[std::countr_zero(left)];
  return hit;
}

HWY_INLINE uint32_t bits_of_all(std::span<const Ray> rays) {
  return static_cast<uint32_t>((uint64_t{1} << rays.size()) - 1);
}

bool instance_closest_packet(const InstanceTree& scene, std::span<const Ray> rays,
                             std::span<Hit> hits, TraversalCounters& counters) {
  PacketRays packet;
  if (!takes_packets(scene.tree) || !packet.set(rays, hits, scene.tree.usual_extent)) return false;
  for (const uint32_t i : scene.endless)
    closest_of_some(scene.instances[i], i, rays, hits, bits_of_all(rays), counters);
  const auto end_at_hits = [&](uint32_t mask) HWY_ATTR {
    for (; mask != 0; mask &= mask - 1) {
      const auto r = static_cast<size_t>(std::countr_zero(mask));
      packet.end_at(r, std::min(rays[r].t_max, hits[r].t));
    }
    return packet.last_t_max();
  };
  float t_max = end_at_hits(bits_of_all(rays));
  PacketLanes lanes(packet);
  closest_in_tree<false>(
      scene.tree, lanes, t_max, counters.node_visits, [&](uint32_t name) HWY_ATTR {
        const PacketLeaf leaf(scene.tree, name);
        const uint32_t mask = packet.enter_child(leaf.node, leaf.place);
        if (mask == 0) return false;
        const NodeReference run{leaf.reference()};
        for (uint32_t i = 0; i < run.blocks(); ++i) {
          const uint32_t number = scene.slots[run.first_block() + i];
          closest_of_some(scene.instances[number], number, rays, hits, mask, counters);
        }
        t_max = end_at_hits(mask);
        return true;
      });
  return true;
}

bool instance_any_packet(const InstanceTree& scene, std::span<const Ray> rays, uint32_t& hit,
                         TraversalCounters& counters) {
  PacketRays packet;
  if (!takes_packets(scene.tree) || !packet.set(rays, {}, scene.tree.usual_extent)) return false;
  hit = 0;
  const auto ask = [&](uint32_t number, uint32_t mask) HWY_ATTR {
    uint32_t found = any_of_some(scene.instances[number], rays, mask & ~hit, counters);
    hit |= found;
    for (; found != 0; found &= found - 1) packet.end(static_cast<size_t>(std::countr_zero(found)));
  };
  for (const uint32_t i : scene.endless) ask(i, bits_of_all(rays));
  float t_max = packet.last_t_max();
  if (t_max < 0) return true;
  PacketLanes lanes(packet);
  any_in_tree<false>(scene.tree, lanes, t_max, counters.node_visits, [&](uint32_t name) HWY_ATTR {
    const PacketLeaf leaf(scene.tree, name);
    const uint32_t mask = packet.enter_child(leaf.node, leaf.place), before = hit;
    const NodeReference run{leaf.reference()};
    for (uint32_t i = 0; i < run.blocks() && (mask & ~hit) != 0; ++i)
      ask(scene.slots[run.first_block() + i], mask);
    if (hit == before) return false;
    t_max = packet.last_t_max();
    return t_max < 0;
  });
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
