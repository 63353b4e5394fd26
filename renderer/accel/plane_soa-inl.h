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
#include "renderer/math/lanes-inl.h"
#include "renderer/shapes/ray.h"
#include "renderer/shapes/shape_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// BvhKernels::planes_met: Plane::intersect() with each, a lane a plane.
uint32_t planes_met(const PlaneSoA& planes, const Ray& ray, double limit, double* t) {
  const Lanes3 origin = broadcast(ray.origin), direction = broadcast(ray.direction);
  const Lanes first = broadcast(ray.t_min), last = broadcast(ray.t_max), most = broadcast(limit);
  uint32_t met = 0, in_front = 0;
  for (size_t i = 0; i < planes.count; i += kLanes) {
    const PlaneEquation plane{load(planes.normal, i), hn::Load(kLaneTag, planes.offset + i)};
    const Lanes approach = dot(plane.normal, direction), height = plane.signed_distance(origin);
    const Lanes at = hn::Neg(height) / approach;
    const auto inside = hn::And(hn::And(hn::Gt(at, first), hn::Lt(at, last)), hn::Le(at, most));
    const auto is_off = hn::Gt(hn::Abs(height), plane.distance_error(origin));
    hn::StoreU(at, kLaneTag, t + i);
    met |= movemask(hn::And(inside, is_off)) << i;
    in_front |= movemask(hn::Lt(approach, hn::Zero(kLaneTag))) << i;
  }
  return met & ((in_front & planes.from_front) | (~in_front & planes.from_behind));
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
