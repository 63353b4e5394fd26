// Part of bvh_kernels.cpp, compiled once for each instruction set: a ray against a row of planes.
#if defined(TESSERA_PLANE_ROW_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_PLANE_ROW_INL_H
#undef TESSERA_PLANE_ROW_INL_H
#else
#define TESSERA_PLANE_ROW_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "renderer/accel/plane_row.h"
#include "renderer/math/mask_bits-inl.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/ray.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// BvhKernels::planes_met: Plane::intersect() line by line, and no product fused with a sum.
uint32_t planes_met(const PlaneRow& row, const Ray& ray, double limit, double* t) {
  const hn::CappedTag<double, 4> tag;
  using FourLanes = hn::Vec<decltype(tag)>;
  const auto all = [&](double value) HWY_ATTR { return hn::Set(tag, value); };
  const FourLanes ox = all(ray.origin.x), oy = all(ray.origin.y), oz = all(ray.origin.z);
  const FourLanes dx = all(ray.direction.x), dy = all(ray.direction.y), dz = all(ray.direction.z);
  const FourLanes first = all(ray.t_min), last = all(ray.t_max), most = all(limit);
  const FourLanes rounding = all(gamma(4)), zero = hn::Zero(tag);
  uint32_t met = 0, in_front = 0;
  for (size_t i = 0; i < row.count; i += hn::MaxLanes(tag)) {
    const FourLanes nx = hn::Load(tag, row.normal[0] + i), ny = hn::Load(tag, row.normal[1] + i),
                    nz = hn::Load(tag, row.normal[2] + i), offset = hn::Load(tag, row.offset + i);
    const auto sum = [](FourLanes a, FourLanes b, FourLanes c)
                         HWY_ATTR { return hn::Add(hn::Add(a, b), c); };
    const FourLanes approach = sum(hn::Mul(nx, dx), hn::Mul(ny, dy), hn::Mul(nz, dz));
    const FourLanes x = hn::Mul(nx, ox), y = hn::Mul(ny, oy), z = hn::Mul(nz, oz);
    const FourLanes height = hn::Sub(sum(x, y, z), offset);
    const FourLanes at = hn::Div(hn::Neg(height), approach);
    const FourLanes error =
        hn::Mul(rounding, hn::Add(sum(hn::Abs(x), hn::Abs(y), hn::Abs(z)), hn::Abs(offset)));
    const auto inside = hn::And(hn::And(hn::Gt(at, first), hn::Lt(at, last)), hn::Le(at, most));
    hn::StoreU(at, tag, t + i);
    met |= bits_of(tag, hn::And(inside, hn::Gt(hn::Abs(height), error))) << i;
    in_front |= bits_of(tag, hn::Lt(approach, zero)) << i;
  }
  return met & ((in_front & row.from_front) | (~in_front & row.from_behind));
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
