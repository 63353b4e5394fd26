// Part of path_batches.cpp, compiled once for each instruction set: what a front's paths meet, a
// lane a path where that is a rectangle or a mesh.
#if defined(TESSERA_PATH_WAVEFRONT_HITS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_PATH_WAVEFRONT_HITS_INL_H
#undef TESSERA_PATH_WAVEFRONT_HITS_INL_H
#else
#define TESSERA_PATH_WAVEFRONT_HITS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/uninitialized.h"
#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/lane_batch-inl.h"
#include "renderer/integrator/path_rays-inl.h"
#include "renderer/integrator/path_surfaces.h"
#include "renderer/integrator/surface_point.h"
#include "renderer/integrator/wavefront-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/shapes/lane_surface-inl.h"
#include "renderer/shapes/lane_transform-inl.h"
#include "renderer/shapes/lane_triangle-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Finds the surfaces that paths meet, and what they are like there.
class PathWavefrontHits : public Wavefront<PathRays> {
 protected:
  PathWavefrontHits(const PathSurfaces& surfaces, std::span<Color> found, TraceState& state)
      : Wavefront(surfaces.scene(), found, state), surfaces_(surfaces) {}

  /// Finds what the front's paths meet, those that scatter evenly first, unless all are to be
  /// `alone`; calls act(places, count) for those that meet nothing, with room behind `places`.
  template <typename Act>
  void meet(bool alone, const Act& act) {
    find_hits();
    uint32_t left[RayBatch::kMost], missed[RayBatch::kMost + kLanes];
    size_t n = 0, misses = 0;
    for (uint32_t i = 0; i < now_->rays.count; ++i) {
      left[n] = missed[misses] = i;
      n += is_hit(i);
      misses += !is_hit(i);
    }
    if (misses > 0) act(missed, misses);
    state_.counters.hits += n;
    met_.count = n;
    met_.even = 0;
    // Of those that scatter otherwise the instances, and where each one's places end.
    size_t uneven = 0, groups = 0;
    uint32_t instances[RayBatch::kMost], ends[RayBatch::kMost];
    while (n > 0) {
      const uint32_t instance = hits_[left[0]].instance;
      const size_t begin = met_.even, end = begin + take_instance(left, n, met_.place + begin);
      if (scene_.features.rich && !surfaces_.placed(instance).has_inputs)
        state_.counters.texture_points_skipped += end - begin;
      if (alone || !surfaces_.placed(instance).is_even) {
        std::copy(met_.place + begin, met_.place + end, uneven_ + uneven);
        uneven += end - begin;
        instances[groups] = instance;
        ends[groups++] = static_cast<uint32_t>(uneven);
        continue;
      }
      place_surfaces(instance, begin, end);
      met_.even = end;
    }
    fill_up_even();
    for (size_t group = 0, from = 0; group < groups; from = ends[group++]) {
      const size_t begin = met_.even + from, end = met_.even + ends[group];
      std::copy(uneven_ + from, uneven_ + ends[group], met_.place + begin);
      std::fill_n(met_.place + end, kLanes, met_.place[begin]);
      if (is_known(instances[group])) place_surfaces(instances[group], begin, end);
    }
    std::fill_n(met_.place + met_.count, kLanes, met_.place[0]);
  }
  /// The points in full, for what is done one by one.
  template <typename Do>
  void at_point(size_t i, const Do& act) const {
    const uint32_t place = met_.place[i];
    const Hit& hit = hits_[place];
    const Ray ray = now_->rays.ray(place);
    if (is_known(hit.instance)) {
      SurfacePoint point(scene_, known_surface(i, hit.instance), ray.direction);
      act(point);
    } else {
      SurfacePoint point(scene_, hit.instance, ray, hit);
      act(point);
    }
  }
  /// The same with their textures, once each. The path has been measured up to here.
  template <typename Do>
  void at_looked_up(size_t i, const Do& act) {
    const uint32_t place = met_.place[i];
    at_point(i, [&](SurfacePoint& point) {
      if (surfaces_.placed(point.surface.instance).has_inputs)
        look_up_textures(scene_, now_->rays.ray(place), width_at(place), point, state_.counters);
      act(point);
    });
  }
  /// Of what a path's sample stands for.
  double width_at(uint32_t place) const {
    if (!scene_.features.rich) return 0;
    return cone_width(cones_[now_->number[place]], now_->path_length[place]);
  }

  const PathSurfaces& surfaces_;
  Met met_;

 private:
  /// So that the last vector is whole.
  void fill_up_even() {
    if (met_.even == 0) return;
    for (size_t i = met_.even; i % kLanes != 0; ++i) {
      for (auto* const parts :
           {&met_.surface.point, &met_.surface.error, &met_.surface.front, &met_.surface.shading})
        put(vec_at(*parts, 0), i, *parts);
    }
  }

  void place_surfaces(uint32_t instance, size_t begin, size_t end) {
    const PathSurfaces::Placed& placed = surfaces_.placed(instance);
    if (placed.form == PathSurfaces::Form::other) {
      for (size_t i = begin; i < end; ++i) place_surface(i);
      return;
    }
    for (size_t i = begin; i < end; ++i) met_.triangle[i] = hits_[met_.place[i]].primitive;
    std::fill_n(met_.triangle + end, kLanes, met_.triangle[begin]);
    for (size_t i = begin; i < end; i += kLanes) {
      const LaneIndices at = indices_of(met_.place + i);
      const Lanes u = gather_hits<&Hit::u>(hits_.data(), at);
      const Lanes v = gather_hits<&Hit::v>(hits_.data(), at);
      uint32_t bad = 0;
      LaneSurface s;
      if (placed.form == PathSurfaces::Form::rectangle) {
        s = surface_of(*placed.rectangle, u, v);
        keep_point(s.point, s.error);
        s.front = s.shading = broadcast(placed.normal);
      } else {
        s = surface_of(*placed.mesh, met_.triangle + i, u, v, bad);
        take_to_world(placed.instance->world_from_object, placed.instance->flip_normals, s);
      }
      met_.surface.store(s, i);
      for (bad &= (1u << std::min(kLanes, end - i)) - 1; bad != 0;)
        place_surface(i + take_lowest_lane(bad));
    }
  }
  void place_surface(size_t i) {
    const uint32_t place = met_.place[i];
    const SurfaceInteraction s = surface_at(scene_.instances, now_->rays.ray(place), hits_[place]);
    put(s.point - Point3{}, i, met_.surface.point);
    put(s.point_error, i, met_.surface.error);
    put(static_cast<Vec3>(s.geometric_normal), i, met_.surface.front);
    put(static_cast<Vec3>(s.shading_normal), i, met_.surface.shading);
  }

  /// Whether a surface is no more than what is placed: only lights without an extent ask what its
  /// normals stand for.
  bool is_known(uint32_t instance) const {
    return surfaces_.placed(instance).is_uniform && scene_.lights.empty();
  }
  SurfaceInteraction known_surface(size_t i, uint32_t instance) const {
    const Vec3 at = vec_at(met_.surface.point, i);
    SurfaceInteraction s;
    s.point = {at.x, at.y, at.z};
    s.point_error = vec_at(met_.surface.error, i);
    s.geometric_normal = to_normal(vec_at(met_.surface.front, i));
    s.shading_normal = to_normal(vec_at(met_.surface.shading, i));
    s.instance = instance;
    return s;
  }

  uint32_t uneven_[RayBatch::kMost];
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
