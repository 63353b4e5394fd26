// Part of path_rows.cpp, compiled once for each instruction set: paths that have come as far, and
// what they meet.
#if defined(TESSERA_PATH_FRONT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_PATH_FRONT_INL_H
#undef TESSERA_PATH_FRONT_INL_H
#else
#define TESSERA_PATH_FRONT_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "renderer/accel/ray_row.h"
#include "renderer/integrator/path_numbers.h"
#include "renderer/integrator/row_follower-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/shading/media.h"
#include "renderer/shapes/lane_surface-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Paths that have met as many surfaces.
struct PathFront : RayFront {
  alignas(64) double radiance_scale[RayRow::kRoom];
  // Of the last bounce, where there was one.
  alignas(64) double density[RayRow::kRoom];
  alignas(64) double from[3][RayRow::kRoom], from_normal[3][RayRow::kRoom];
  // Where something may be passed straight, or absorbs.
  uint32_t bounces[RayRow::kMost];  ///< so far
  Media media[RayRow::kMost];       ///< that the ray begins in
};

constexpr uint8_t bit_of(VertexNumbers::Pair pair) { return static_cast<uint8_t>(1u << pair); }

/// What a front's paths meet, those of one instance side by side. All is worked out of all of them
/// before what depends on it: to read as a vector what was just written one by one makes the
/// processor wait.
struct Met {
  size_t count = 0;
  size_t even = 0;                         ///< the first so many surfaces scatter evenly
  uint32_t place[RayRow::kMost + kLanes];  ///< in the front
  LaneSurfaces<RayRow::kRoom> surface;
  alignas(64) double diffuse[3][RayRow::kRoom];
  uint32_t triangle[RayRow::kMost + kLanes];    ///< and other primitives
  uint8_t is_back[RayRow::kRoom / kLanes + 1];  ///< a bit for each lane
  // Numbers, and which pairs each path asked for, a bit each.
  alignas(64) double on_light[2][RayRow::kRoom], direction[2][RayRow::kRoom];
  alignas(64) double choice[2][RayRow::kRoom], pick[2][RayRow::kRoom];
  uint8_t read[RayRow::kRoom];

  bool from_behind(size_t i) const { return (is_back[i / kLanes] >> i % kLanes & 1) != 0; }
  /// A path that chooses a point of a light has its direction drawn, too.
  Vec2 read_on_light(size_t i) {
    read[i] |= bit_of(VertexNumbers::kOnLight) | bit_of(VertexNumbers::kDirection);
    return {on_light[0][i], on_light[1][i]};
  }
};

/// Some paths where they are, a lane each. What fills the vector up is the front's first again.
struct PathBundle {
  size_t at;      ///< of the first
  uint32_t bits;  ///< of lanes that are paths
  LaneSurface surface;
  Lanes3 facet;  ///< the geometric normal, towards the viewer
  Lanes3 throughput;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
