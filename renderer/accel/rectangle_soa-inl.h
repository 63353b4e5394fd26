// Part of bvh_kernels.cpp, compiled once for each instruction set: a ray against
// rectangles.
#if defined(TESSERA_RECTANGLE_SOA_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_RECTANGLE_SOA_INL_H
#undef TESSERA_RECTANGLE_SOA_INL_H
#else
#define TESSERA_RECTANGLE_SOA_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>

#include "renderer/accel/rectangle_soa.h"
#include "renderer/math/mask_bits-inl.h"
#include "renderer/math/vec.h"
#include "renderer/shapes/ray.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// BvhKernels::rectangles_met.
RectanglesMet rectangles_met(const RectangleSoA& rectangles, const Ray& ray, double t_max,
                             double* entered) {
  const double far = l1_norm(ray.origin - Point3{}), steep = l1_norm(ray.direction);
  const bool is_steep = steep >= RectangleSoA::kLeastSteep && steep <= RectangleSoA::kMostSteep;
  const bool is_usual = far <= rectangles.farthest && is_steep && ray.t_min >= 0;
  if (!is_usual) [[unlikely]] {
    std::fill_n(entered, rectangles.count, -Bounds3::kInfinity);
    return {rectangles.all | RectangleSoA::kUnusual, 0};
  }
  const hn::CappedTag<double, 4> tag;
  using FourLanes = hn::Vec<decltype(tag)>;
  const auto broadcast = [&](double value) HWY_ATTR { return hn::Set(tag, value); };
  const FourLanes ox = broadcast(ray.origin.x), oy = broadcast(ray.origin.y),
                  oz = broadcast(ray.origin.z);
  const FourLanes dx = broadcast(ray.direction.x), dy = broadcast(ray.direction.y),
                  dz = broadcast(ray.direction.z);
  const double slack = 2 * RectangleSoA::kMargin * rectangles.extent / steep;
  const FourLanes first = broadcast(ray.t_min), last = broadcast(t_max + slack),
                  half = broadcast(0.5);
  const FourLanes t_slack = broadcast(slack), length = broadcast(steep);
  RectanglesMet met;
  for (size_t i = 0; i < rectangles.count; i += hn::MaxLanes(tag)) {
    const auto load = [&](const double* at) HWY_ATTR { return hn::Load(tag, at + i); };
    const auto product = [&](const double(*with)[RectangleSoA::kMost], FourLanes x, FourLanes y,
                             FourLanes z) HWY_ATTR {
      return hn::MulAdd(load(with[2]), z, hn::MulAdd(load(with[1]), y, load(with[0]) * x));
    };
    // From the origin to the corner.
    const FourLanes cx = load(rectangles.corner[0]) - ox, cy = load(rectangles.corner[1]) - oy,
                    cz = load(rectangles.corner[2]) - oz;
    const FourLanes approach = product(rectangles.normal, dx, dy, dz);
    const FourLanes t = product(rectangles.normal, cx, cy, cz) / approach;
    const FourLanes entered_at = t - t_slack;
    const FourLanes px = hn::MulSub(t, dx, cx), py = hn::MulSub(t, dy, cy),
                    pz = hn::MulSub(t, dz, cz);
    // Half where it is on the edge.
    const FourLanes u = hn::Abs(product(rectangles.share_u, px, py, pz) - half);
    const FourLanes v = hn::Abs(product(rectangles.share_v, px, py, pz) - half);
    const auto told = hn::Gt(hn::Abs(approach), load(rectangles.grazing) * length);
    const auto outside =
        hn::Or(hn::Gt(u, load(rectangles.out_u)), hn::Gt(v, load(rectangles.out_v)));
    const auto elsewhere = hn::Or(hn::Lt(t + t_slack, first), hn::Gt(t, last));
    const auto inside = hn::And(hn::Lt(u, load(rectangles.in_u)), hn::Lt(v, load(rectangles.in_v)));
    hn::StoreU(hn::IfThenElse(told, entered_at, broadcast(-Bounds3::kInfinity)), tag, entered + i);
    const uint32_t misses = movemask(tag, hn::And(told, hn::Or(outside, elsewhere)));
    met.maybe |= (misses ^ ((1u << hn::MaxLanes(tag)) - 1)) << i;
    met.inside |= movemask(tag, hn::And(told, inside)) << i;
  }
  met.maybe &= rectangles.all;
  met.inside &= rectangles.all;
  return met;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
