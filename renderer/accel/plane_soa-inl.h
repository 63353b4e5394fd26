// Part of bvh_kernels.cpp, compiled once for each instruction set: a ray against planes.
#if defined(TESSERA_PLANE_SOA_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_PLANE_SOA_INL_H
#undef TESSERA_PLANE_SOA_INL_H
#else
#define TESSERA_PLANE_SOA_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "renderer/accel/plane_soa.h"
#include "renderer/math/mask_bits-inl.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/ray.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// BvhKernels::planes_met: Plane::intersect() line by line, and no product fused with a sum.
uint32_t planes_met(const PlaneSoA& planes, const Ray& ray, double limit, double* t) {
  const hn::CappedTag<double, 4> tag;
  using FourLanes = hn::Vec<decltype(tag)>;
  const auto broadcast = [&](double value) HWY_ATTR { return hn::Set(tag, value); };
  const FourLanes ox = broadcast(ray.origin.x), oy = broadcast(ray.origin.y),
                  oz = broadcast(ray.origin.z);
  const FourLanes dx = broadcast(ray.direction.x), dy = broadcast(ray.direction.y),
                  dz = broadcast(ray.direction.z);
  const FourLanes first = broadcast(ray.t_min), last = broadcast(ray.t_max),
                  most = broadcast(limit);
  const FourLanes rounding = broadcast(gamma(4)), zero = hn::Zero(tag);
  uint32_t met = 0, in_front = 0;
  for (size_t i = 0; i < planes.count; i += hn::MaxLanes(tag)) {
    const FourLanes nx = hn::Load(tag, planes.normal[0] + i),
                    ny = hn::Load(tag, planes.normal[1] + i),
                    nz = hn::Load(tag, planes.normal[2] + i),
                    offset = hn::Load(tag, planes.offset + i);
    const auto sum = [](FourLanes a, FourLanes b, FourLanes c) HWY_ATTR { return a + b + c; };
    const FourLanes approach = sum(nx * dx, ny * dy, nz * dz);
    const FourLanes x = nx * ox, y = ny * oy, z = nz * oz;
    const FourLanes height = sum(x, y, z) - offset;
    const FourLanes at = hn::Neg(height) / approach;
    const FourLanes error = rounding * (sum(hn::Abs(x), hn::Abs(y), hn::Abs(z)) + hn::Abs(offset));
    const auto inside = hn::And(hn::And(hn::Gt(at, first), hn::Lt(at, last)), hn::Le(at, most));
    hn::StoreU(at, tag, t + i);
    met |= movemask(tag, hn::And(inside, hn::Gt(hn::Abs(height), error))) << i;
    in_front |= movemask(tag, hn::Lt(approach, zero)) << i;
  }
  return met & ((in_front & planes.from_front) | (~in_front & planes.from_behind));
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
