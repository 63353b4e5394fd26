// Compiled once for each instruction set, as a part of wavefront-inl.h: what lights and
// panoramas are to many points and rays, a lane each.
#if defined(TESSERA_LIGHT_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_LIGHT_LANES_INL_H
#undef TESSERA_LIGHT_LANES_INL_H
#else
#define TESSERA_LIGHT_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <limits>

#include "renderer/accel/light_buffer.h"
#include "renderer/math/elementary.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/shading/background.h"
#include "renderer/shading/light.h"
#include "renderer/shapes/lane_surface-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

#include "renderer/shading/light-inl.h"
#include "renderer/shading/panorama-inl.h"

/// sample_light() of a light of any kind, point by point.
inline uint32_t sample_shaped(const Light& light, const Lanes3& point, Lanes path_length,
                              LightSample& sample) {
  const Stored3 points(point);
  alignas(64) double paths[kLanes], distances[kLanes], factors[kLanes];
  hn::Store(path_length, kLaneTag, paths);
  Stored3 ways(point);
  uint32_t reached = 0;
  for (size_t lane = 0; lane < kLanes; ++lane) {
    tessera::LightSample one{};
    if (sample_light(light, points.point(lane), paths[lane], one)) {
      reached |= 1u << lane;
    } else {
      one = {-light.direction, 1, 0};
    }
    ways.put(lane, one.wi);
    distances[lane] = one.distance, factors[lane] = one.factor;
  }
  sample = {ways.load(), hn::Load(kLaneTag, distances), hn::Load(kLaneTag, factors)};
  return reached;
}
/// sample_light(); a bit for each point that it reaches.
HWY_INLINE uint32_t sample(const Light& light, const Lanes3& point, Lanes path_length,
                           LightSample& sample) {
  if (!light.is_point_or_directional()) return sample_shaped(light, point, path_length, sample);
  if (!light.is_placed()) {
    sample = {broadcast(-light.direction), broadcast(std::numeric_limits<double>::infinity()),
              broadcast(1)};
    return ~0u;
  }
  const LaneMask is_elsewhere = sample_place(broadcast(light.position) - point, sample);
  return movemask(both(is_elsewhere, attenuate(light, path_length, sample)));
}

/// LightBuffer::boxes_met() in the lanes of `bits`.
HWY_INLINE void look_up(const LightBuffer& buffer, const LaneSurface& s, const LightSample& sampled,
                        uint32_t bits, uint32_t* boxes) {
  if (!buffer.is_of_place()) {
    const Stored3 points(s.point), wi(sampled.wi);
    while (bits != 0) {
      const size_t lane = take_lowest_lane(bits);
      boxes[lane] = buffer.boxes_met(points.point(lane), wi.vec(lane), 1);
    }
    return;
  }
  const Lanes3& d = sampled.wi;
  const Lanes zero = hn::Zero(kLaneTag), side = broadcast(LightBuffer::kSide);
  const Lanes x = hn::Abs(d.x), y = hn::Abs(d.y), z = hn::Abs(d.z);
  const auto by_x = hn::And(hn::Gt(x, y), hn::Gt(x, z)), by_y = hn::Gt(y, z);
  const auto of_axis = [&](Lanes of_x, Lanes of_y, Lanes of_z) HWY_ATTR {
    return hn::IfThenElse(by_x, of_x, hn::IfThenElse(by_y, of_y, of_z));
  };
  const auto cell = [](Lanes part) HWY_ATTR {
    return hn::Trunc((part + broadcast(LightBuffer::kEdge)) *
                     broadcast(LightBuffer::kCellsPerPart));
  };
  const Lanes below = hn::IfThenElseZero(hn::Lt(of_axis(d.x, d.y, d.z), zero), broadcast(1));
  const Lanes face = of_axis(zero, broadcast(2), broadcast(4)) + below;
  const Lanes column = cell(of_axis(d.y, d.z, d.x)), row = cell(of_axis(d.z, d.x, d.y));
  alignas(64) double cells[kLanes];
  hn::Store((face * side + row) * side + column, kLaneTag, cells);
  const uint32_t told = movemask(hn::Gt(sampled.distance, broadcast(LightBuffer::kLeastDistance)));
  while (bits != 0) {
    const size_t lane = take_lowest_lane(bits);
    boxes[lane] = (told >> lane & 1) != 0 ? buffer.boxes_of_cell(static_cast<size_t>(cells[lane]))
                                          : buffer.all_boxes();
  }
}

/// Where in a panorama lies what is seen along unit directions of the world.
HWY_INLINE Lanes2 place_in_panorama(const Background& beyond, const Lanes3& d) {
  const auto turned = [&](int axis) HWY_ATTR { return dot(broadcast(beyond.rotation[axis]), d); };
  return place_in_panorama(beyond.kind, beyond.angle, {turned(0), turned(1), turned(2)});
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
