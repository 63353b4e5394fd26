// Part of path_batches.cpp, compiled once for each instruction set: paths that have come as far,
// and what they meet.
#if defined(TESSERA_PATH_RAYS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_PATH_RAYS_INL_H
#undef TESSERA_PATH_RAYS_INL_H
#else
#define TESSERA_PATH_RAYS_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "renderer/accel/ray_batch.h"
#include "renderer/integrator/path_numbers.h"
#include "renderer/integrator/wavefront-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/shading/media.h"
#include "renderer/shapes/lane_surface-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Paths that have met as many surfaces.
struct PathRays : WavefrontRays {
  alignas(64) double radiance_scale[RayBatch::kPadded];
  // Of the last bounce, where there was one.
  alignas(64) double density[RayBatch::kPadded];
  alignas(64) double from[3][RayBatch::kPadded], from_normal[3][RayBatch::kPadded];
  // Where something may be passed straight, or absorbs, and in fog.
  double view_distance[RayBatch::kMost];  ///< metres back to the camera or the last bounce
  uint32_t bounces[RayBatch::kMost];      ///< so far
  Media media[RayBatch::kMost];           ///< that the ray begins in
};

constexpr uint8_t bit_of(VertexNumbers::Pair pair) { return static_cast<uint8_t>(1u << pair); }

/// What a front's paths meet, those of one instance side by side. All is worked out of all of them
/// before what depends on it: to read as a vector what was just written one by one makes the
/// processor wait.
struct Met {
  size_t count = 0;
  size_t even = 0;                           ///< the first so many surfaces scatter evenly
  uint32_t place[RayBatch::kMost + kLanes];  ///< in the front
  LaneSurfaces<RayBatch::kPadded> surface;
  alignas(64) double diffuse[3][RayBatch::kPadded];
  uint32_t triangle[RayBatch::kMost + kLanes];      ///< and other primitives
  uint8_t is_back[RayBatch::kPadded / kLanes + 1];  ///< a bit for each lane
  // Numbers, and which pairs each path asked for, a bit each.
  alignas(64) double on_light[2][RayBatch::kPadded], direction[2][RayBatch::kPadded];
  alignas(64) double choice[2][RayBatch::kPadded], pick[2][RayBatch::kPadded];
  uint8_t read[RayBatch::kPadded];

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
