#include "renderer/integrator/direct_light.h"

#include <algorithm>
#include <cmath>

#include "renderer/integrator/light_sampling.h"
#include "renderer/shading/local_share.h"

namespace tessera {

namespace {

/// Whether the light is behind the facet but in front of the curved surface that it stands for:
/// then the facets themselves must not stop it, lest they show where the shading turns dark.
bool sees_over_facet(const SurfacePoint& point, const Vec3& wi) {
  return dot(point.surface.smooth_shift, point.geometric_normal) > 0 && dot(point.normal, wi) > 0;
}

/// The stretch between a point and a light on which occluders count.
[[gnu::always_inline]] inline Ray shadow_ray(const SurfacePoint& point, RayOrigins& origins,
                                             const Light& light, const LightSample& sample) {
  const bool placed = light.is_placed();
  double t_max = placed ? 1 : sample.distance;
  if (std::isfinite(light.shadow_distance)) {
    t_max = std::min(t_max, light.shadow_distance / (placed ? sample.distance : 1));
  }
  // Which side of the surface it leaves from is told by the whole way to a light's place.
  const Vec3 towards = placed ? light.position - point.surface.point : sample.wi;
  Point3 origin;
  if (sees_over_facet(point, sample.wi)) {
    origin = origins.towards(point.geometric_normal) + point.surface.smooth_shift;
  } else {
    origin = origins.towards(towards);
  }
  return {origin, placed ? light.position - origin : sample.wi, 0, t_max};
}

Color through_media(const Media& media, double metres) {
  const Color& absorption = media.absorption();
  return is_black(absorption) ? kWhite : transmittance(absorption, metres);
}

/// What transparent occluders, and the `media` that the ray begins in, leave of the light, from
/// the point outwards. Light goes straight through them: there are no caustics here.
template <bool kRich, bool kThroughGlass = true>
Color clear_transmittance(const Scene& scene, const Occluders& occluders, Ray ray, Media media,
                          [[maybe_unused]] double width, TraceState& state) {
  Color left = kWhite;
  const double metres = length(ray.direction);
  for (uint32_t pass = 0; pass < kMaxPasses && !is_black(left); ++pass) {
    Hit hit;
    if (!occluders.clear->closest_hit(ray, hit, state.counters.traversal)) {
      // The light is in that medium too; one without a place is beyond all of it.
      return std::isfinite(ray.t_max) ? left * through_media(media, ray.t_max * metres) : left;
    }
    SurfacePoint point(scene, occluders.clear_instances[hit.instance], ray, hit);
    if constexpr (kRich) look_up_textures(scene, ray, width, point, state.counters);
    const Coverage coverage = straight_coverage(point);
    const Material& material = *point.material;
    Color through = kWhite * coverage.through;
    if (kThroughGlass && material.refracted() > 0)
      through += transmission_tint(material) * (coverage.covered * material.refracted());
    left = left * through;
    note_media_before(media, point);
    left = left * through_media(media, hit.t * metres);
    pass_into(media, point);
    const double t_max = ray.t_max - hit.t;
    ray = spawn_ray(point.surface, ray.direction);
    ray.t_max = t_max;
  }
  if (!is_black(left)) ++state.counters.paths_cut;
  return left;
}

/// light_visibility(), compiled where it stands. `buffer` is that of the light among
/// Occluders::buffers_at() the point, or null.
template <bool kRich>
[[gnu::always_inline]] inline Color visibility_of(const Scene& scene, const SurfacePoint& point,
                                                  RayOrigins& origins, const LightBuffer* buffer,
                                                  const Media& media, const Light& light,
                                                  const LightSample& sample, double width,
                                                  TraceState& state) {
  const Occluders& occluders = scene.occluders;
  ++state.counters.rays_shadow;
  uint32_t boxes = 0;
  if (buffer) {
    boxes = buffer->boxes_met(point.surface.point, sample.wi, sample.distance);
    if (!occluders.clear && !occluders.few->holds_any(boxes)) return kWhite;
  }
  const Ray ray = shadow_ray(point, origins, light, sample);
  if (buffer ? occluders.few->any_hit_among(boxes, ray, state.counters.traversal)
             : is_stopped(scene, light, ray, state))
    return kWhite * (1 - light.shadow_intensity);
  if (!occluders.clear) return kWhite;
  const bool begins_beyond =
      dot(point.geometric_normal, ray.direction) < 0 && !sees_over_facet(point, sample.wi);
  const Color visible = clear_transmittance<kRich>(
      scene, occluders, ray, begins_beyond ? media_beyond(media, point) : media, width, state);
  return kWhite - light.shadow_intensity * (kWhite - visible);
}

}  // namespace

template <bool kRich>
Color light_visibility(const Scene& scene, const SurfacePoint& point, RayOrigins& origins,
                       const Media& media, const Light& light, const LightSample& sample,
                       double width, TraceState& state) {
  const LightBuffer* const buffers = scene.occluders.buffers_at(point.surface);
  const LightBuffer* const buffer = buffers ? buffers + (&light - scene.lights.data()) : nullptr;
  return visibility_of<kRich>(scene, point, origins, buffer, media, light, sample, width, state);
}

template <bool kRich>
Color ray_visibility(const Scene& scene, const SurfacePoint& point, const Ray& ray,
                     const Media& media, double width, TraceState& state) {
  const Occluders& occluders = scene.path_occluders;
  ++state.counters.rays_shadow;
  if (occluders.opaque && occluders.opaque->any_hit(ray, state.counters.traversal)) {
    return kBlack;
  }
  const bool begins_beyond = dot(point.geometric_normal, ray.direction) < 0;
  const Media inside = begins_beyond ? media_beyond(media, point) : media;
  return ray_transmittance<kRich>(scene, ray, inside, width, state);
}

template <bool kRich>
Color ray_transmittance(const Scene& scene, const Ray& ray, const Media& inside, double width,
                        TraceState& state) {
  if (scene.path_occluders.clear) {
    return clear_transmittance<kRich, false>(scene, scene.path_occluders, ray, inside, width,
                                             state);
  }
  // What comes from beyond all surfaces has no way through a medium.
  return std::isfinite(ray.t_max) ? through_media(inside, ray.t_max * length(ray.direction))
                                  : kWhite;
}

template <bool kRich>
Color point_visibility(const Scene& scene, const SurfacePoint& point, RayOrigins& origins,
                       const Media& media, const SurfaceSample& there, double width,
                       TraceState& state) {
  const Vec3 back = point.surface.point - there.point;
  const Vec3 end = end_before(to_vec(there.point), there.point_error, there.normal, back);
  Ray ray = origins.spawn(-back);
  ray.direction = to_point(end) - ray.origin;
  ray.t_max = 1;
  return ray_visibility<kRich>(scene, point, ray, media, width, state);
}

template <bool kRich>
Color local_radiance(const Scene& scene, const SurfacePoint& point, RayOrigins& origins,
                     const Vec3& wo, const Media& media, double path_length, TraceState& state) {
  const Material& material = *point.material;
  if (!material.is_lit()) return emission(point);
  // A refracting surface sends the share that it lets through elsewhere (scene.proto, REFRACT).
  const LocalShare<kRich> local(material, surface_diffuse(point), 1 - material.refracted(), wo,
                                point.normal, point.geometric_normal);
  Color ambient = scene.settings.ambient;
  Color sum = material.emission;
  const double width = cone_width(state.cone, path_length);
  const bool has_shadows = scene.features.shadows;
  const LightBuffer* const buffers =
      has_shadows ? scene.occluders.buffers_at(point.surface) : nullptr;
  const auto add_light = [&](uint32_t index) __attribute__((always_inline)) {
    const Light& light = scene.lights[index];
    if (!light.ambient_attenuated) ambient += light.ambient;
    LightSample sample{};
    if (!sample_light(light, point.surface.point, path_length, sample)) {
      ++state.counters.shadow_rays_skipped;
      return;
    }
    if (light.ambient_attenuated) ambient += light.ambient * sample.factor;
    // Light behind a surface that subtracts it is in the shadow of that surface.
    const bool shades_itself = has_shadows &&
                               material.diffuse_model == DiffuseModel::signed_lambert &&
                               light.casts_shadow && light.shadow_intensity == 1 &&
                               material.is_opaque() && dot(point.geometric_normal, sample.wi) < 0;
    Color arriving = light.intensity * sample.factor;
    const Color share = local.reflected(sample.wi);
    if (shades_itself || is_black(arriving) || is_black(share)) {
      ++state.counters.shadow_rays_skipped;
      return;
    }
    if (has_shadows && light.casts_shadow)
      arriving = arriving * visibility_of<kRich>(scene, point, origins,
                                                 buffers ? buffers + index : nullptr, media, light,
                                                 sample, width, state);
    sum += arriving * share;
  };
  state.counters.lights_culled +=
      scene.for_each_light(point.surface.instance, point.surface.point, add_light);
  return sum + local.ambient(ambient);
}

template Color local_radiance<false>(const Scene&, const SurfacePoint&, RayOrigins&, const Vec3&,
                                     const Media&, double, TraceState&);
template Color local_radiance<true>(const Scene&, const SurfacePoint&, RayOrigins&, const Vec3&,
                                    const Media&, double, TraceState&);
template Color light_visibility<false>(const Scene&, const SurfacePoint&, RayOrigins&, const Media&,
                                       const Light&, const LightSample&, double, TraceState&);
template Color light_visibility<true>(const Scene&, const SurfacePoint&, RayOrigins&, const Media&,
                                      const Light&, const LightSample&, double, TraceState&);
template Color ray_visibility<false>(const Scene&, const SurfacePoint&, const Ray&, const Media&,
                                     double, TraceState&);
template Color ray_visibility<true>(const Scene&, const SurfacePoint&, const Ray&, const Media&,
                                    double, TraceState&);
template Color ray_transmittance<false>(const Scene&, const Ray&, const Media&, double,
                                        TraceState&);
template Color ray_transmittance<true>(const Scene&, const Ray&, const Media&, double, TraceState&);
template Color point_visibility<false>(const Scene&, const SurfacePoint&, RayOrigins&, const Media&,
                                       const SurfaceSample&, double, TraceState&);
template Color point_visibility<true>(const Scene&, const SurfacePoint&, RayOrigins&, const Media&,
                                      const SurfaceSample&, double, TraceState&);

}  // namespace tessera
