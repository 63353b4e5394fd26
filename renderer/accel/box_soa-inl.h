// Part of bvh_kernels.cpp, compiled once for each instruction set: a ray against boxes.
#if defined(TESSERA_BOX_SOA_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_BOX_SOA_INL_H
#undef TESSERA_BOX_SOA_INL_H
#else
#define TESSERA_BOX_SOA_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>

#include "renderer/accel/box_soa.h"
#include "renderer/math/mask_bits-inl.h"
#include "renderer/math/vec.h"
#include "renderer/shapes/ray.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// What a slab test wants of one axis: one over the direction, never infinite, and the origin as
/// often.
struct SlabAxis {
  double inverse, offset;
  HWY_INLINE SlabAxis(double origin, double direction) {
    inverse = std::max(-BoxSoA::kMostInverse, std::min(1 / direction, BoxSoA::kMostInverse));
    offset = origin * inverse;
  }
};

/// BvhKernels::boxes_entered.
uint32_t boxes_entered(const BoxSoA& boxes, const Ray& ray, double t_max, double* entered) {
  // Sums, since a greatest part may hide one that is not a number.
  const double far = l1_norm(ray.origin - Point3{}), steep = l1_norm(ray.direction);
  const bool is_steep = steep >= BoxSoA::kLeastSteep && steep <= BoxSoA::kMostSteep;
  if (!(far <= boxes.farthest && is_steep)) [[unlikely]] {
    std::fill_n(entered, boxes.count, -Bounds3::kInfinity);
    return boxes.all | BoxSoA::kUnusual;
  }
  const SlabAxis x(ray.origin.x, ray.direction.x), y(ray.origin.y, ray.direction.y),
      z(ray.origin.z, ray.direction.z);
  const hn::CappedTag<double, 4> tag;
  const auto first = hn::Set(tag, ray.t_min), last = hn::Set(tag, t_max);
  uint32_t mask = 0;
  for (size_t i = 0; i < boxes.count; i += hn::MaxLanes(tag)) {
    auto enter = first, leave = last;
    const auto narrow = [&](const double* min, const double* max, const SlabAxis& axis) HWY_ATTR {
      const auto inverse = hn::Set(tag, axis.inverse), offset = hn::Set(tag, axis.offset);
      const auto a = hn::MulSub(hn::Load(tag, min + i), inverse, offset);
      const auto b = hn::MulSub(hn::Load(tag, max + i), inverse, offset);
      enter = hn::Max(enter, hn::Min(a, b));
      leave = hn::Min(leave, hn::Max(a, b));
    };
    narrow(boxes.min[0], boxes.max[0], x);
    narrow(boxes.min[1], boxes.max[1], y);
    narrow(boxes.min[2], boxes.max[2], z);
    hn::StoreU(enter, tag, entered + i);
    mask |= movemask(tag, hn::Le(enter, leave)) << i;
  }
  return mask & boxes.all;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
