// Part of bvh_kernels.cpp, compiled once for each instruction set: the exact test of leaves.
#if defined(TESSERA_TEST_TRIANGLES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_TEST_TRIANGLES_INL_H
#undef TESSERA_TEST_TRIANGLES_INL_H
#else
#define TESSERA_TEST_TRIANGLES_INL_H
#endif

#include <bit>
#include <cstdint>
#include <vector>

#include "renderer/accel/bvh_kernels.h"
#include "renderer/accel/traverse-inl.h"
#include "renderer/math/mask_bits-inl.h"
#include "renderer/shapes/triangle.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// The exact test, four triangles at a time: the operations and their order are those of shear() in
/// triangle.h, so the edge functions have the same bits.
class TriangleTester {
 public:
  TriangleTester(const MeshTree& mesh, const TriangleRay& ray)
      : units_(mesh.tree.units.data()), ray_(ray) {}

  HWY_INLINE bool closest(uint32_t leaf, Hit& hit, uint64_t& tests) const {
    bool found = false;
    Lanes lanes;
    for (const TriangleBlock* block = first_block(leaf);; ++block) {
      tests += 4;
      const auto take = [&](int lane, const TriangleHit& h) HWY_ATTR {
        const uint32_t primitive = block->primitive[lane] & ~TriangleBlock::kLast;
        if (h.t > hit.t || (h.t == hit.t && primitive >= hit.primitive)) return;
        hit = {h.t, h.u, h.v, hit.instance, primitive};
        found = true;
      };
      Verdict verdict = test<true>(*block, hit.t, lanes);
      for (; verdict.sure != 0; verdict.sure &= verdict.sure - 1) {
        const int lane = std::countr_zero(verdict.sure);
        take(lane, {lanes.t[lane], lanes.u[lane], lanes.v[lane]});
      }
      for (; verdict.unsure != 0; verdict.unsure &= verdict.unsure - 1) [[unlikely]] {
          const int lane = std::countr_zero(verdict.unsure);
          TriangleHit h;
          if (test_alone(*block, lane, h)) take(lane, h);
        }
      if (block->primitive[3] & TriangleBlock::kLast) return found;
    }
  }

  /// Appends every hit inside (t_min, t_max).
  HWY_INLINE void all(uint32_t leaf, std::vector<Hit>& hits, uint64_t& tests) const {
    Lanes lanes;
    for (const TriangleBlock* block = first_block(leaf);; ++block) {
      tests += 4;
      const auto take = [&](int lane, const TriangleHit& h) HWY_ATTR {
        hits.push_back({h.t, h.u, h.v, 0, block->primitive[lane] & ~TriangleBlock::kLast});
      };
      Verdict verdict = test<true>(*block, ray_.t_max, lanes);
      for (; verdict.sure != 0; verdict.sure &= verdict.sure - 1) {
        const int lane = std::countr_zero(verdict.sure);
        take(lane, {lanes.t[lane], lanes.u[lane], lanes.v[lane]});
      }
      for (; verdict.unsure != 0; verdict.unsure &= verdict.unsure - 1) [[unlikely]] {
          const int lane = std::countr_zero(verdict.unsure);
          TriangleHit h;
          if (test_alone(*block, lane, h)) take(lane, h);
        }
      if (block->primitive[3] & TriangleBlock::kLast) return;
    }
  }

  HWY_INLINE bool any(uint32_t leaf, uint64_t& tests) const {
    Lanes lanes;
    for (const TriangleBlock* block = first_block(leaf);; ++block) {
      tests += 4;
      Verdict verdict = test<false>(*block, ray_.t_max, lanes);
      if (verdict.sure != 0) return true;
      for (; verdict.unsure != 0; verdict.unsure &= verdict.unsure - 1) [[unlikely]] {
          TriangleHit h;
          if (test_alone(*block, std::countr_zero(verdict.unsure), h)) return true;
        }
      if (block->primitive[3] & TriangleBlock::kLast) return false;
    }
  }

 private:
  HWY_INLINE const TriangleBlock* first_block(uint32_t leaf) const {
    return reinterpret_cast<const TriangleBlock*>(unit_at(units_, leaf));
  }

  /// Triangles of a block, by bits. `unsure`: where finish_triangle() takes one of its rare ways.
  struct Verdict {
    uint32_t sure = 0, unsure = 0;
  };
  /// Of those that are surely hit.
  struct alignas(32) Lanes {
    double t[4], u[4], v[4];
  };

  template <bool kKeep>
  HWY_INLINE Verdict test(const TriangleBlock& block, double t_max, Lanes& lanes) const {
    const DoubleTag tag;
    const HalfFloatTag half;
    Verdict verdict;
    for (size_t lane = 0; lane < 4; lane += hn::MaxLanes(tag)) {
      const auto ox = hn::Set(tag, ray_.origin.x), oy = hn::Set(tag, ray_.origin.y);
      const auto oz = hn::Set(tag, ray_.origin.z), sx = hn::Set(tag, ray_.sx);
      const auto sy = hn::Set(tag, ray_.sy), sz = hn::Set(tag, ray_.sz);
      const auto load = [&](int vertex, int axis) HWY_ATTR {
        return hn::PromoteTo(tag, hn::Load(half, block.vertex[vertex][axis] + lane));
      };
      ShearedLanes s;
      const auto adz = hn::Sub(load(0, ray_.kz), oz);
      const auto bdz = hn::Sub(load(1, ray_.kz), oz);
      const auto cdz = hn::Sub(load(2, ray_.kz), oz);
      s.ax = hn::Sub(hn::Sub(load(0, ray_.kx), ox), hn::Mul(sx, adz));
      s.bx = hn::Sub(hn::Sub(load(1, ray_.kx), ox), hn::Mul(sx, bdz));
      s.cx = hn::Sub(hn::Sub(load(2, ray_.kx), ox), hn::Mul(sx, cdz));
      s.ay = hn::Sub(hn::Sub(load(0, ray_.ky), oy), hn::Mul(sy, adz));
      s.by = hn::Sub(hn::Sub(load(1, ray_.ky), oy), hn::Mul(sy, bdz));
      s.cy = hn::Sub(hn::Sub(load(2, ray_.ky), oy), hn::Mul(sy, cdz));
      s.u = hn::Sub(hn::Mul(s.cx, s.by), hn::Mul(s.cy, s.bx));
      s.v = hn::Sub(hn::Mul(s.ax, s.cy), hn::Mul(s.ay, s.cx));
      s.w = hn::Sub(hn::Mul(s.bx, s.ay), hn::Mul(s.by, s.ax));
      const auto zero = hn::Zero(tag);
      const auto one_sided = hn::Or(hn::Ge(hn::Min(hn::Min(s.u, s.v), s.w), zero),
                                    hn::Le(hn::Max(hn::Max(s.u, s.v), s.w), zero));
      s.az = hn::Mul(sz, adz), s.bz = hn::Mul(sz, bdz), s.cz = hn::Mul(sz, cdz);
      // A hit behind the origin is told by a product: to wait for a division before the branch
      // below can be known to be guessed wrong costs more than all else here.
      s.det = hn::Add(hn::Add(s.u, s.v), s.w);
      s.scaled_t = hn::Add(hn::Add(hn::Mul(s.u, s.az), hn::Mul(s.v, s.bz)), hn::Mul(s.w, s.cz));
      const auto ahead = hn::Ge(hn::Mul(s.scaled_t, s.det), zero);
      // t is never below the nearest vertex by more than rounding.
      const auto nearest = hn::Mul(hn::Min(hn::Min(s.az, s.bz), s.cz), hn::Set(tag, 1 - 0x1p-40));
      const auto in_reach = hn::Le(nearest, hn::Set(tag, t_max));
      const auto candidate = hn::And(hn::And(ahead, in_reach), one_sided);
      if (movemask(tag, candidate) == 0) continue;
      finish<kKeep>(s, candidate, t_max, lane, lanes, verdict);
    }
    return verdict;
  }

  /// ShearedTriangle, in lanes.
  struct ShearedLanes {
    hn::Vec<DoubleTag> ax, ay, az, bx, by, bz, cx, cy, cz, u, v, w;
    hn::Vec<DoubleTag> det, scaled_t;  ///< scaled by det
  };

  /// finish_triangle() with t_error(), the same operations in the same order.
  template <bool kKeep, typename Mask>
  HWY_INLINE void finish(const ShearedLanes& s, Mask candidate, double t_max, size_t lane,
                         Lanes& lanes, Verdict& verdict) const {
    const DoubleTag tag;
    const auto zero = hn::Zero(tag);
    const auto scaled = [&](double factor, auto v)
                            HWY_ATTR { return hn::Mul(hn::Set(tag, factor), v); };
    const auto largest = [&](auto a, auto b, auto c) HWY_ATTR {
      return hn::Max(hn::Max(hn::Abs(a), hn::Abs(b)), hn::Abs(c));
    };
    const auto inverse_det = hn::Div(hn::Set(tag, 1), s.det);
    const auto t = hn::Mul(s.scaled_t, inverse_det);
    const auto max_x = largest(s.ax, s.bx, s.cx), max_y = largest(s.ay, s.by, s.cy);
    const auto max_z = largest(s.az, s.bz, s.cz), max_e = largest(s.u, s.v, s.w);
    const auto max_depth = scaled(ray_.depth, max_z);
    const auto delta_x = scaled(gamma(5), hn::Add(max_x, max_depth));
    const auto delta_y = scaled(gamma(5), hn::Add(max_y, max_depth));
    const auto delta_z = scaled(gamma(3), max_z);
    const auto delta_e =
        scaled(2, hn::Add(scaled(gamma(2), hn::Mul(max_x, max_y)),
                          hn::Add(hn::Mul(delta_y, max_x), hn::Mul(delta_x, max_y))));
    const auto error =
        hn::Mul(scaled(3, hn::Add(scaled(gamma(3), hn::Mul(max_e, max_z)),
                                  hn::Add(hn::Mul(delta_e, max_z), hn::Mul(delta_z, max_e)))),
                hn::Abs(inverse_det));
    const auto least = hn::Min(hn::Min(hn::Abs(s.u), hn::Abs(s.v)), hn::Abs(s.w));
    const auto usual = hn::And(hn::Gt(least, zero), hn::Le(error, scaled(kMostErrorOfT, t)));
    auto inside =
        hn::And(hn::Gt(t, hn::Set(tag, ray_.t_min)),
                hn::And(hn::Lt(t, hn::Set(tag, ray_.t_max)), hn::Le(t, hn::Set(tag, t_max))));
    if (ray_.ray.cull == Cull::back) inside = hn::And(inside, hn::Ge(s.det, zero));
    if (ray_.ray.cull == Cull::front) inside = hn::And(inside, hn::Le(s.det, zero));
    verdict.sure |= movemask(tag, hn::And(candidate, hn::And(usual, inside))) << lane;
    verdict.unsure |= movemask(tag, hn::AndNot(usual, candidate)) << lane;
    if (!kKeep) return;
    hn::Store(t, tag, lanes.t + lane);
    hn::Store(hn::Mul(s.v, inverse_det), tag, lanes.u + lane);
    hn::Store(hn::Mul(s.w, inverse_det), tag, lanes.v + lane);
  }

  HWY_NOINLINE bool test_alone(const TriangleBlock& block, int lane, TriangleHit& hit) const {
    const auto corner = [&](int vertex) HWY_ATTR {
      const auto& v = block.vertex[vertex];
      return Point3{v[0][lane], v[1][lane], v[2][lane]};
    };
    return intersect_triangle(ray_, corner(0), corner(1), corner(2), hit);
  }

  const TreeUnit* units_;
  const TriangleRay& ray_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
