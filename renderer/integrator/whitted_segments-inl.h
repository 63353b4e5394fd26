// Part of whitted_batches.cpp, compiled once for each instruction set: the segments that Whitted's
// batches follow, those that wait for others, and hits that are looked at a lane a ray.
#if defined(TESSERA_WHITTED_SEGMENTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_WHITTED_SEGMENTS_INL_H
#undef TESSERA_WHITTED_SEGMENTS_INL_H
#else
#define TESSERA_WHITTED_SEGMENTS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "renderer/accel/ray_batch.h"
#include "renderer/integrator/wavefront-inl.h"
#include "renderer/integrator/whitted_hit.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/shading/clamped_normal.h"
#include "renderer/shading/media.h"
#include "renderer/shapes/lane_surface-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Some rays that hit one instance, a lane each, and what lies there. What fills the vector up is
/// one of them again.
struct HitBundle {
  uint32_t places[kLanes];  ///< in the front
  uint32_t bits;            ///< of lanes that are rays
  Lanes3 direction;
  Lanes path_length;  ///< up to the hit
  Lanes3 throughput;

  LaneSurface surface;
  Lanes3 shift;                     ///< LocalSurface::smooth_shift
  Lanes3 tint;                      ///< LocalSurface::vertex_color, in the lanes `tinted`
  uint32_t tinted;                  ///< lanes that have a vertex colour
  uint32_t materials[kLanes];       ///< LocalSurface::material
  Lanes3 geometric_normal, normal;  ///< seen from where the rays came
  Lanes3 diffuse;
  Lanes3 seen;  ///< from there, by the surface itself

  // Of the light that is asked for now.
  uint32_t lit;     ///< lanes that it reaches, whatever is in the way
  uint32_t shaded;  ///< those where something is
  Lanes3 arriving, share;
};

/// Of shadow_ray().
inline Lanes3 shadow_origin(const HitBundle& bundle, const Lanes3& wi, const Lanes3& towards) {
  const Lanes zero = hn::Zero(kLaneTag);
  const auto lifted = hn::Gt(dot(bundle.shift, bundle.geometric_normal), zero);
  const auto over_facet = hn::And(lifted, hn::Gt(dot(bundle.normal, wi), zero));
  if (hn::AllFalse(kLaneTag, over_facet)) return origin_towards(bundle.surface, towards);
  const Lanes3 origin =
      origin_towards(bundle.surface, select(over_facet, bundle.geometric_normal, towards));
  return select(over_facet, origin + bundle.shift, origin);
}

/// mirror_direction() in the lanes `bent`.
inline Lanes3 bent_back(const HitBundle& bundle, const Lanes3& way, uint32_t bent) {
  if (bent == 0) return way;
  const Stored3 shading(bundle.normal), facets(bundle.geometric_normal), d(bundle.direction);
  Stored3 ways(way);
  while (bent != 0) {
    const size_t lane = take_lowest_lane(bent);
    const Vec3 facet = facets.vec(lane), wo = -d.vec(lane);
    ways.put(lane, mirror_direction(clamped_normal(shading.vec(lane), facet, wo), facet, wo));
  }
  return ways.load();
}

/// At most one segment of each camera ray.
struct WhittedRays : WavefrontRays {
  uint32_t depth[RayBatch::kMost];  ///< reflections and refractions so far
  // Where not all surfaces are simple.
  uint32_t passes[RayBatch::kMost];       ///< surfaces passed unbent so far
  double view_distance[RayBatch::kMost];  ///< metres back to the viewer or the last bend
  Media media[RayBatch::kMost];           ///< that the ray begins in
};

/// Segments that wait until others of their camera ray are followed: of each ray those put aside
/// last come first.
class WaitingSegments {
 public:
  /// For so many camera rays, whose first segments are followed without waiting.
  void begin(size_t rays) {
    std::fill_n(top_, rays, WaitingSegment::kNone);
    std::fill_n(followed_, rays, 1u);
    all_.clear();
    free_ = WaitingSegment::kNone;
  }
  void put_aside(const PathSegment& segment, uint32_t ray) {
    if (free_ == WaitingSegment::kNone) {
      free_ = static_cast<uint32_t>(all_.size());
      all_.emplace_back();
    }
    const uint32_t at = free_;
    free_ = all_[at].below;
    all_[at] = {segment, top_[ray]};
    top_[ray] = at;
  }
  bool any(uint32_t ray) const { return top_[ray] != WaitingSegment::kNone; }
  /// Whether the ray has had as many segments as are followed; then none waits any more.
  bool is_cut(uint32_t ray) {
    if (followed_[ray]++ < kMaxSegments) return false;
    top_[ray] = WaitingSegment::kNone;
    return true;
  }
  /// The last of those that wait; its place is free, so that it lasts until the next is put aside.
  const PathSegment& take(uint32_t ray) {
    const uint32_t at = top_[ray];
    top_[ray] = std::exchange(all_[at].below, free_);
    free_ = at;
    return all_[at].segment;
  }

 private:
  std::vector<WaitingSegment>& all_ = waiting_segments();
  uint32_t top_[RayBatch::kMost];       ///< by camera ray, what waits last, in all_, or kNone
  uint32_t followed_[RayBatch::kMost];  ///< likewise, segments
  uint32_t free_ = WaitingSegment::kNone;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
