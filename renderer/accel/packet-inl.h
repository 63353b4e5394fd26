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

  /// False where a ray is unusual or leaves the others' octant.
  HWY_INLINE bool set(std::span<const Ray> rays, std::span<const Hit> hits, float extent) {
    for (size_t r = 0; r < kPacketSize; ++r) {
      const bool used = r < rays.size();
      const Ray& ray = rays[used ? r : 0];
      BoxRay<float> b;
      if (!make_usual_box_ray(ray, std::min(ray.t_max, hits[used ? r : 0].t), extent, b))
        return false;
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
      mask |= bits_of(tag, hn::Le(first, last)) << r;
    }
    return mask;
  }

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
      mask |= (bits_of(integer, hn::Gt(first, last)) ^ ((1u << hn::MaxLanes(tag)) - 1)) << lane;
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
  HWY_INLINE const TriangleRay& operator[](int r) const {
    return *std::launder(reinterpret_cast<const TriangleRay*>(memory) + r);
  }
};

bool mesh_packet(const MeshTree& mesh, std::span<const Ray> rays, std::span<Hit> hits,
                 TraversalCounters& counters) {
  const TraversalTree& tree = mesh.tree;
  if ((tree.root & TraversalTree::kLeaf) || tree.units.size() >= PacketLanes::kMaxUnits)
    return false;
  if (mesh.cut_planes.count > 0)
    for (const Ray& ray : rays)
      if (mesh.cut_planes.must_visit_all(ray, tree.extent)) return false;
  PacketRays packet;
  if (rays.size() < 2 || !packet.set(rays, hits, tree.usual_extent)) return false;
  PreparedRays prepared;  // once one of them enters a leaf
  TraversalCounters done;
  float t_max = packet.last_t_max();
  PacketLanes lanes(packet);
  closest_in_tree<true>(
      tree, lanes, t_max,
      done.node_visits, [&](uint32_t leaf) HWY_ATTR __attribute__((always_inline)) {
        const uint32_t unit = (leaf & ~TraversalTree::kLeaf) >> 3;
        const WideNode& node = *reinterpret_cast<const WideNode*>(tree.units.data() + unit);
        bool nearer = false;
        uint32_t mask = packet.enter_child(node, leaf & 7);
        if (mask != 0 && !prepared.ready) prepared.set(rays);
        for (; mask != 0; mask &= mask - 1) {
          const int r = std::countr_zero(mask);
          Hit& hit = hits[static_cast<size_t>(r)];
          const TriangleTester tester(mesh, prepared[r]);
          if (!tester.closest(node.child[leaf & 7], hit, done.primitive_tests)) continue;
          packet.t_max[r] = static_cast<float>(hit.t * (1 + BoxRay<float>::kMargin));
          nearer = true;
        }
        if (nearer) t_max = packet.last_t_max();
        return nearer;
      });
  counters.node_visits += done.node_visits;
  counters.primitive_tests += done.primitive_tests;
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
