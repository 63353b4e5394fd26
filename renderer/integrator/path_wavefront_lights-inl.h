// Part of path_batches.cpp, compiled once for each instruction set: PathVertex::from_area_light(),
// a lane a path.
#if defined(TESSERA_PATH_WAVEFRONT_LIGHTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_PATH_WAVEFRONT_LIGHTS_INL_H
#undef TESSERA_PATH_WAVEFRONT_LIGHTS_INL_H
#else
#define TESSERA_PATH_WAVEFRONT_LIGHTS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/lane_batch-inl.h"
#include "renderer/integrator/light_sampling.h"
#include "renderer/integrator/path_rays-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/scene/scene.h"
#include "renderer/shading/lambert_lanes-inl.h"
#include "renderer/shapes/lane_surface-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

#include "renderer/integrator/light_sampling-inl.h"

/// Light of points of area lights, to what a front's paths meet.
class PathWavefrontLights {
 public:
  /// `passes`: PathSurfaces::passes().
  PathWavefrontLights(const Scene& scene, bool passes, TraceState& state)
      : scene_(scene), passes_(passes), state_(state) {}

  /// Before the paths of a front are lit, which have those numbers.
  void begin(const uint32_t* numbers) {
    numbers_ = numbers;
    shadows_.rays.begin(0, 1);
  }
  /// One for each path that scatters evenly and does not choose the background, for which its
  /// numbers are read all the same. `width_of(i)` is that of what a path's sample stands for, of
  /// lights with textures.
  template <typename Width>
  void choose_points(Met& met, const Width& width_of) {
    const double to_sky = environment_share(scene_);
    const bool picks = picks_light(scene_);
    for (size_t i = 0; i < met.even; ++i) {
      const double which = picks ? met.pick[0][i] : 0;
      points_.density[i] = 0;
      if (which < to_sky) {
        met.read_on_light(i);
        continue;
      }
      choose_point(met, i, (which - to_sky) / (1 - to_sky), 1 - to_sky, width_of);
    }
    const size_t whole = (met.even + kLanes - 1) / kLanes * kLanes;
    for (size_t i = met.even; i < whole; ++i) points_.density[i] = 0;
    for (size_t i = 0; i < whole; ++i) {
      if (points_.density[i] > 0) continue;
      // Some place that is not the point's own.
      put(vec_at(met.surface.point, i) + vec_at(met.surface.front, i), i, points_.point);
      put(Vec3{}, i, points_.error), put(Vec3{}, i, points_.normal);
      put(kBlack, i, points_.front), put(kBlack, i, points_.back);
    }
  }
  /// What they bring. Black if it may be added later, of those that nothing stops.
  /// `transmittance(place, ray)` is that along such a ray, which is asked where something passes.
  template <typename Transmittance>
  Lanes3 brought(const Met& met, const PathBundle& bundle, const Lambert& lambert, bool may_wait,
                 const Transmittance& transmittance) {
    const Lanes zero = hn::Zero(kLaneTag);
    const Lanes3 none{zero, zero, zero};
    const size_t at = bundle.at;
    const Lanes density = hn::Load(kLaneTag, points_.density + at);
    const uint32_t chosen = movemask(hn::Gt(density, zero)) & bundle.bits;
    if (chosen == 0) return none;
    const Lanes3 place = load(points_.point, at), normal = load(points_.normal, at);
    const LaneSurface& here = bundle.surface;
    const Lanes3 wi = normalize(place - here.point);
    const auto in_front = hn::Lt(dot(wi, normal), zero);
    const Lanes3 emitted = select(in_front, load(points_.front, at), load(points_.back, at));
    BsdfValue value = lambert.evaluate(wi);
    const auto emits_none = is_black(emitted);
    value.density = hn::IfThenZeroElse(emits_none, value.density);
    const auto is_dark = hn::Or(emits_none, is_black(value.f_cosine));
    const uint32_t asked = chosen & ~movemask(is_dark);
    state_.counters.shadow_rays_skipped += static_cast<uint64_t>(std::popcount(chosen & ~asked));
    state_.counters.rays_shadow += static_cast<uint64_t>(std::popcount(asked));
    const Lanes3 back = here.point - place;
    const Lanes3 origin = origin_towards(here, -back);
    const Lanes3 stretch = end_before(place, load(points_.error, at), normal, back) - origin;
    const Lanes3 light = select(is_dark, none, emitted * value.f_cosine);
    const Lanes weight =
        hn::IfThenZeroElse(is_dark, power_heuristic(density, value.density) / density);
    if (may_wait) {
      append_shadow_rays(met, bundle, asked, origin, stretch, light, weight);
      return none;
    }
    const uint32_t arrives = asked & ~stopped(origin, stretch, asked);
    if (!passes_) return select(mask_of(arrives), light * weight, none);
    const Stored3 origins(origin), stretches(stretch);
    Stored3 visible(none);
    for (uint32_t lanes = arrives; lanes != 0;) {
      const size_t lane = take_lowest_lane(lanes);
      const Color share =
          transmittance(met.place[at + lane], Ray{origins.point(lane), stretches.vec(lane), 0, 1});
      visible.put(lane, {share.r, share.g, share.b});
    }
    const Lanes3 all_of_it = light * visible.load() * weight;
    return select(mask_of(arrives), all_of_it, none);
  }
  /// What was to be added later; `transmittance` as for brought().
  template <typename Transmittance>
  void add_not_stopped(std::span<Color> found, const Transmittance& transmittance) {
    const Accelerator* const opaque = scene_.path_occluders.opaque.get();
    const RayBatch& rays = shadows_.rays;
    if (rays.count == 0) return;
    const uint64_t stopped = opaque ? opaque->any_hits(rays, state_.counters.traversal) : 0;
    for (uint32_t i = 0; i < rays.count; ++i) {
      if ((stopped >> i & 1) != 0) continue;
      Color light = color_at(shadows_.light, i);
      const uint32_t place = shadows_.place[i];
      if (passes_) {
        const Color visible = transmittance(place, rays.ray(i));
        light = color_at(shadows_.throughput, i) * (light * visible * shadows_.weight[i]);
      }
      found[numbers_[place]] += light;
    }
  }

 private:
  /// Of the paths that choose one, a point of an area light.
  struct LightPoints {
    alignas(64) double point[3][RayBatch::kPadded], error[3][RayBatch::kPadded],
        normal[3][RayBatch::kPadded];
    alignas(64) double front[3][RayBatch::kPadded], back[3][RayBatch::kPadded];
    alignas(64) double density[RayBatch::kPadded];  ///< 0 where there is none
  };
  /// The stretches from surfaces to area lights, and what light they bring to each path.
  struct ShadowRows {
    RayBatch rays;
    alignas(64) double light[3][RayBatch::kPadded];  ///< with what follows, unless something passes
    alignas(64) double weight[RayBatch::kPadded], throughput[3][RayBatch::kPadded];
    uint32_t place[RayBatch::kMost];
  };

  template <typename Width>
  void choose_point(Met& met, size_t i, double u, double share, const Width& width_of) {
    const AreaLights& lights = scene_.area_lights;
    const Point3 from = Point3{} + vec_at(met.surface.point, i);
    const Vec3 front = vec_at(met.surface.front, i), facet = met.from_behind(i) ? -front : front;
    const LightTree::Pick pick = lights.tree().pick(from, facet, u);
    const AreaLight& light = lights[pick.index];
    if (light.is_dark_from(from)) {
      ++state_.counters.shadow_rays_skipped;
      return;
    }
    SurfaceSample sample;
    const double density = light.sampler->sample({from, facet}, met.read_on_light(i), sample) *
                           pick.probability * share;
    if (!(density > 0)) return;
    points_.density[i] = density;
    put(sample.point - Point3{}, i, points_.point);
    put(sample.point_error, i, points_.error);
    put(sample.normal, i, points_.normal);
    put(light.front, i, points_.front);
    put(light.back, i, points_.back);
    if (!light.has_texture) return;
    const Color emitted =
        looked_up_emission(scene_, light.instance, sample, from, width_of(i), state_.counters);
    if (!is_black(light.front)) put(emitted, i, points_.front);
    if (!is_black(light.back)) put(emitted, i, points_.back);
  }

  /// Of stretches in the lanes of `asked` those that something stops.
  uint32_t stopped(const Lanes3& origin, const Lanes3& stretch, uint32_t asked) {
    const Accelerator* const opaque = scene_.path_occluders.opaque.get();
    const Stored3 origins(origin), stretches(stretch);
    uint32_t lanes = 0;
    for (uint32_t left = opaque ? asked : 0; left != 0;) {
      const size_t lane = take_lowest_lane(left);
      const Ray ray{origins.point(lane), stretches.vec(lane), 0, 1};
      lanes |= uint32_t{opaque->any_hit(ray, state_.counters.traversal)} << lane;
    }
    return lanes;
  }
  void append_shadow_rays(const Met& met, const PathBundle& bundle, uint32_t asked,
                          const Lanes3& origin, const Lanes3& stretch, const Lanes3& light,
                          Lanes weight) {
    RayBatch& rays = shadows_.rays;
    append(origin, asked, rays.count, rays.origin);
    append(stretch, asked, rays.count, rays.direction);
    if (passes_) {
      append(light, asked, rays.count, shadows_.light);
      append(weight, asked, shadows_.weight + rays.count);
      append(bundle.throughput, asked, rays.count, shadows_.throughput);
    } else {
      append(bundle.throughput * (light * weight), asked, rays.count, shadows_.light);
    }
    while (asked != 0)
      shadows_.place[rays.count++] = met.place[bundle.at + take_lowest_lane(asked)];
  }

  const Scene& scene_;
  const bool passes_;
  TraceState& state_;
  const uint32_t* numbers_ = nullptr;  ///< of the paths, by place
  LightPoints points_;
  ShadowRows shadows_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
