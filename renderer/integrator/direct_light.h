#pragma once

#include "renderer/integrator/integrator.h"
#include "renderer/integrator/surface_point.h"

namespace tessera {

/// Emission, ambient light and the light of every light of the point's set, towards `wo`.
/// `media` are those on the viewer's side, `path_length` that from the camera to
/// the point. Without kRich the scene must have no rich materials.
/// Also a lane each, of simple features, in whitted_wavefront-inl.h, bit for bit.
template <bool kRich>
Color local_radiance(const Scene& scene, const SurfacePoint& point, RayOrigins& origins,
                     const Vec3& wo, const Media& media, double path_length, TraceState& state);

/// The share of the light of `light`, one of the scene's, that shadows leave.
template <bool kRich>
Color light_visibility(const Scene& scene, const SurfacePoint& point, RayOrigins& origins,
                       const Media& media, const Light& light, const LightSample& sample,
                       double width, TraceState& state);
/// The share of light from a point of a surface that arrives. What refracts lets nothing through.
template <bool kRich>
Color point_visibility(const Scene& scene, const SurfacePoint& point, RayOrigins& origins,
                       const Media& media, const SurfaceSample& there, double width,
                       TraceState& state);

/// The same of light from the background along `ray`, which leaves the point.
template <bool kRich>
Color ray_visibility(const Scene& scene, const SurfacePoint& point, const Ray& ray,
                     const Media& media, double width, TraceState& state);

/// The share of light that transparent surfaces on `ray`, and media, leave; the ray begins in
/// `inside`. What is opaque is not asked here.
template <bool kRich>
Color ray_transmittance(const Scene& scene, const Ray& ray, const Media& inside, double width,
                        TraceState& state);

/// Whether something opaque stops this shadow ray. What stopped the last one to this light is asked
/// first.
[[gnu::always_inline]] inline bool is_stopped(const Scene& scene, const Light& light,
                                              const Ray& ray, TraceState& state) {
  const Occluders& occluders = scene.occluders;
  TraceCounters& counters = state.counters;
  if (!occluders.opaque) return false;
  if (!occluders.takes_guesses) return occluders.opaque->any_hit(ray, counters.traversal);
  uint32_t& last = state.last_occluders.of_light(static_cast<size_t>(&light - scene.lights.data()));
  const uint32_t before = last;
  if (!occluders.opaque->any_hit_by(ray, last, counters.traversal)) return false;
  if (last == before) ++counters.occluders_met_again;
  return true;
}

/// The width, in metres, of what one sample stands for at the end of a path.
inline double cone_width(const Camera::PixelCone& cone, double path_length) {
  return cone.at_eye + cone.spread * path_length;
}

}  // namespace tessera
