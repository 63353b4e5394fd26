#include "renderer/integrator/direct_light.h"

#include <algorithm>
#include <cmath>

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
  const bool placed = light.kind == LightKind::point || light.kind == LightKind::spot;
  Ray ray;
  if (sees_over_facet(point, sample.wi)) {
    ray = origins.spawn(point.geometric_normal);
    ray.origin = ray.origin + point.surface.smooth_shift;
    ray.direction = placed ? light.position - ray.origin : sample.wi;
    ray.t_max = 1;
  } else {
    ray = placed ? origins.spawn_to(light.position) : origins.spawn(sample.wi);
  }
  if (!placed) ray.t_max = sample.distance;
  if (std::isfinite(light.shadow_distance)) {
    ray.t_max = std::min(ray.t_max, light.shadow_distance / (placed ? sample.distance : 1));
  }
  return ray;
}

Color through_medium(const Color& medium, double metres) {
  return is_black(medium) ? kWhite : transmittance(medium, metres);
}

/// What transparent occluders, and the `medium` that the ray begins in, leave of the light, from
/// the point outwards. Light goes straight through them: there are no caustics here.
template <bool kRich, bool kThroughGlass = true>
Color clear_transmittance(const Scene& scene, const Occluders& occluders, Ray ray, Color medium,
                          [[maybe_unused]] double width, TraceCounters& counters) {
  Color left = kWhite;
  const double metres = length(ray.direction);
  for (uint32_t pass = 0; pass < kMaxPasses && !is_black(left); ++pass) {
    Hit hit;
    if (!occluders.clear->closest_hit(ray, hit, counters.traversal)) {
      // The light is in that medium too; one without a place is beyond all of it.
      return std::isfinite(ray.t_max) ? left * through_medium(medium, ray.t_max * metres) : left;
    }
    SurfacePoint point(scene, occluders.clear_instances[hit.instance], ray, hit);
    if constexpr (kRich) look_up_textures(scene, ray, width, point, counters);
    const Coverage coverage = straight_coverage(point);
    const Material& material = *point.material;
    Color through = kWhite * coverage.through;
    if (kThroughGlass && material.transmission == Transmission::refract && coverage.covered > 0) {
      through += transmission_tint(material) * (coverage.covered * material.transparency);
    }
    left = left * through;
    left = left * through_medium(medium_before(medium, point), hit.t * metres);
    medium = medium_beyond(medium, point);
    const double t_max = ray.t_max - hit.t;
    ray = spawn_ray(point.surface, ray.direction);
    ray.t_max = t_max;
  }
  if (!is_black(left)) ++counters.paths_cut;
  return left;
}

}  // namespace

template <bool kRich>
Color light_visibility(const Scene& scene, const SurfacePoint& point, RayOrigins& origins,
                       const Color& medium, const Light& light, const LightSample& sample,
                       double width, TraceCounters& counters) {
  const Ray ray = shadow_ray(point, origins, light, sample);
  const Occluders& occluders = scene.occluders;
  ++counters.rays_shadow;
  if (occluders.opaque && occluders.opaque->any_hit(ray, counters.traversal)) {
    return kWhite * (1 - light.shadow_intensity);
  }
  if (!occluders.clear) return kWhite;
  const bool begins_beyond =
      dot(point.geometric_normal, ray.direction) < 0 && !sees_over_facet(point, sample.wi);
  const Color visible = clear_transmittance<kRich>(
      scene, occluders, ray, begins_beyond ? medium_beyond(medium, point) : medium, width,
      counters);
  return kWhite - light.shadow_intensity * (kWhite - visible);
}

template <bool kRich>
Color ray_visibility(const Scene& scene, const SurfacePoint& point, const Ray& ray,
                     const Color& medium, double width, TraceCounters& counters) {
  const Occluders& occluders = scene.path_occluders;
  ++counters.rays_shadow;
  if (occluders.opaque && occluders.opaque->any_hit(ray, counters.traversal)) {
    return kBlack;
  }
  const bool begins_beyond = dot(point.geometric_normal, ray.direction) < 0;
  const Color inside = begins_beyond ? medium_beyond(medium, point) : medium;
  if (occluders.clear) {
    return clear_transmittance<kRich, false>(scene, occluders, ray, inside, width, counters);
  }
  // What comes from beyond all surfaces has no way through a medium.
  return std::isfinite(ray.t_max) ? through_medium(inside, ray.t_max * length(ray.direction))
                                  : kWhite;
}

template <bool kRich>
Color point_visibility(const Scene& scene, const SurfacePoint& point, RayOrigins& origins,
                       const Color& medium, const SurfaceSample& there, double width,
                       TraceCounters& counters) {
  // The stretch ends before the light's own surface, as it begins after that of the point.
  const Vec3 back = point.surface.point - there.point;
  const Vec3 side = dot(back, there.normal) < 0 ? -there.normal : there.normal;
  constexpr double kRoundings = 0x1p-48;
  const double lift = dot(abs(side), there.point_error) + kRoundings * length(back);
  Ray ray = origins.spawn(-back);
  ray.direction = there.point + side * lift - ray.origin;
  ray.t_max = 1;
  return ray_visibility<kRich>(scene, point, ray, medium, width, counters);
}

template <bool kRich>
[[gnu::cold, gnu::noinline]] void trace_for_nothing(const Scene& scene, const SurfacePoint& point,
                                                    const Color& medium, const Light& light,
                                                    const LightSample& sample, double width,
                                                    TraceCounters& counters) {
  if (!light.casts_shadow || !(sample.distance > 0)) return;
  RayOrigins origins(point.surface);
  light_visibility<kRich>(scene, point, origins, medium, light, sample, width, counters);
}

template <bool kShadows, bool kRich>
Color local_radiance(const Scene& scene, const SurfacePoint& point, const Vec3& wo,
                     const Color& medium, double path_length, TraceCounters& counters) {
  const Material& material = *point.material;
  if (material.model == MaterialModel::unlit) {
    return emission(point);
  }
  // A refracting surface sends the share that it lets through elsewhere (scene.proto, REFRACT).
  const double kept =
      material.transmission == Transmission::refract ? 1 - material.transparency : 1.0;
  const Color diffuse = surface_diffuse(point);
  const Color kept_diffuse = diffuse * kept;
  Color ambient = scene.settings.ambient;
  Color sum = material.emission;
  [[maybe_unused]] RayOrigins origins(point.surface);
  const auto add_light = [&](uint32_t index) {
    const Light& light = scene.lights[index];
    if (!light.ambient_attenuated) ambient += light.ambient;
    LightSample sample;
    const auto leave_out = [&](bool skips) {
      if (skips) {
        ++counters.shadow_rays_skipped;
      } else if constexpr (kShadows) {
        trace_for_nothing<kRich>(scene, point, medium, light, sample,
                                 cone_width(scene, path_length), counters);
      }
    };
    if (!sample_light(light, point.surface.point, path_length, sample)) {
      leave_out(scene.skips.unreached_lights);
      return;
    }
    if (light.ambient_attenuated) ambient += light.ambient * sample.factor;
    Color arriving = light.intensity * sample.factor;
    Color share;
    if (kRich && material.model != MaterialModel::classic) {
      share = any_reflected_share(material, diffuse, point.normal, sample.wi, wo);
    } else {
      share = reflected_share(material, kept_diffuse, point.normal, sample.wi, wo);
    }
    if (is_black(arriving) || is_black(share)) {
      leave_out(scene.skips.dark_shadow_rays);
      return;
    }
    if constexpr (kShadows) {
      // Light behind a surface that subtracts it is in the shadow of that surface.
      const bool shades_itself = material.diffuse_model == DiffuseModel::signed_lambert &&
                                 light.shadow_intensity == 1 && material.is_opaque() &&
                                 dot(point.geometric_normal, sample.wi) < 0;
      if (light.casts_shadow && shades_itself) {
        leave_out(scene.skips.dark_shadow_rays);
        return;
      }
      if (light.casts_shadow)
        arriving = arriving * light_visibility<kRich>(scene, point, origins, medium, light, sample,
                                                      cone_width(scene, path_length), counters);
    }
    sum += arriving * share;
  };
  counters.lights_culled +=
      scene.for_each_light(point.surface.instance, point.surface.point, add_light);
  if (kRich && material.model != MaterialModel::classic) {
    return sum + ambient * ambient_share(material, diffuse) * kept;
  }
  return sum + ambient * material.ambient *
                   (material.ambient_times_diffuse ? kept_diffuse : kWhite * kept);
}

template Color local_radiance<false, false>(const Scene&, const SurfacePoint&, const Vec3&,
                                            const Color&, double, TraceCounters&);
template Color local_radiance<false, true>(const Scene&, const SurfacePoint&, const Vec3&,
                                           const Color&, double, TraceCounters&);
template Color local_radiance<true, false>(const Scene&, const SurfacePoint&, const Vec3&,
                                           const Color&, double, TraceCounters&);
template Color local_radiance<true, true>(const Scene&, const SurfacePoint&, const Vec3&,
                                          const Color&, double, TraceCounters&);

template Color light_visibility<false>(const Scene&, const SurfacePoint&, RayOrigins&, const Color&,
                                       const Light&, const LightSample&, double, TraceCounters&);
template Color light_visibility<true>(const Scene&, const SurfacePoint&, RayOrigins&, const Color&,
                                      const Light&, const LightSample&, double, TraceCounters&);
template void trace_for_nothing<false>(const Scene&, const SurfacePoint&, const Color&,
                                       const Light&, const LightSample&, double, TraceCounters&);
template void trace_for_nothing<true>(const Scene&, const SurfacePoint&, const Color&, const Light&,
                                      const LightSample&, double, TraceCounters&);
template Color ray_visibility<false>(const Scene&, const SurfacePoint&, const Ray&, const Color&,
                                     double, TraceCounters&);
template Color ray_visibility<true>(const Scene&, const SurfacePoint&, const Ray&, const Color&,
                                    double, TraceCounters&);
template Color point_visibility<false>(const Scene&, const SurfacePoint&, RayOrigins&, const Color&,
                                       const SurfaceSample&, double, TraceCounters&);
template Color point_visibility<true>(const Scene&, const SurfacePoint&, RayOrigins&, const Color&,
                                      const SurfaceSample&, double, TraceCounters&);

}  // namespace tessera
