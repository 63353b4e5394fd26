#include "renderer/integrator/direct_light.h"

#include <algorithm>

namespace tessera {

namespace {

/// The stretch between a point and a light on which occluders count.
Ray shadow_ray(const SurfacePoint& point, const Light& light, const LightSample& sample) {
  if (light.kind == LightKind::point || light.kind == LightKind::spot) {
    Ray ray = spawn_ray_to(point.surface, light.position);
    ray.t_max = std::min(ray.t_max, light.shadow_distance / sample.distance);
    return ray;
  }
  Ray ray = spawn_ray(point.surface, sample.wi);
  ray.t_max = std::min(sample.distance, light.shadow_distance);
  return ray;
}

/// What transparent occluders leave of the light, from the point outwards. Light goes straight
/// through them: there are no caustics here.
Color clear_transmittance(const Scene& scene, Ray ray, TraceCounters& counters) {
  Color left = kWhite;
  const double metres = length(ray.direction);
  for (uint32_t pass = 0; pass < kMaxPasses && !is_black(left); ++pass) {
    Hit hit;
    if (!scene.clear_occluders->closest_hit(ray, hit, counters.traversal)) break;
    const SurfacePoint point = surface_point(scene, scene.clear_instances[hit.instance], ray, hit);
    const Coverage coverage = straight_coverage(point);
    const bool bends = point.material->transmission == Transmission::refract && !point.is_hidden &&
                       point.surface.vertex_alpha >= 1;
    left = left * (bends ? point.material->transparency : coverage.through);
    if (point.is_back && !point.is_hidden && !is_black(point.material->absorption)) {
      left = left * transmittance(point.material->absorption, hit.t * metres);
    }
    const double t_max = ray.t_max - hit.t;
    ray = spawn_ray(point.surface, ray.direction);
    ray.t_max = t_max;
  }
  return left;
}

Color visibility(const Scene& scene, const SurfacePoint& point, const Light& light,
                 const LightSample& sample, TraceCounters& counters) {
  const Ray ray = shadow_ray(point, light, sample);
  ++counters.rays_shadow;
  Color visible = kWhite;
  if (scene.opaque_occluders && scene.opaque_occluders->any_hit(ray, counters.traversal)) {
    visible = kBlack;
  } else if (scene.clear_occluders) {
    visible = clear_transmittance(scene, ray, counters);
  }
  return kWhite - light.shadow_intensity * (kWhite - visible);
}

Color diffuse_color(const SurfacePoint& point) {
  const Material& material = *point.material;
  if (!point.surface.has_vertex_color) return material.diffuse;
  return material.vertex_color_replaces_diffuse ? point.surface.vertex_color
                                                : material.diffuse * point.surface.vertex_color;
}

}  // namespace

template <bool kShadows>
Color local_radiance(const Scene& scene, const SurfacePoint& point, const Vec3& wo,
                     double path_length, TraceCounters& counters) {
  const Material& material = *point.material;
  if (material.unlit) {
    return point.surface.has_vertex_color ? material.emission * point.surface.vertex_color
                                          : material.emission;
  }
  // A refracting surface sends the share that it lets through elsewhere (scene.proto, REFRACT).
  const double kept =
      material.transmission == Transmission::refract ? 1 - material.transparency : 1.0;
  const Color diffuse = diffuse_color(point) * kept;
  Color ambient = scene.settings.ambient;
  Color sum = material.emission;
  for (const uint32_t index : scene.lights_of(point.surface.instance)) {
    const Light& light = scene.lights[index];
    if (!light.ambient_attenuated) ambient += light.ambient;
    LightSample sample;
    if (!sample_light(light, point.surface.point, path_length, sample)) {
      ++counters.shadow_rays_skipped;
      continue;
    }
    if (light.ambient_attenuated) ambient += light.ambient * sample.factor;
    Color arriving = light.intensity * sample.factor;
    const Color share = reflected_share(material, diffuse, point.normal, sample.wi, wo);
    if (is_black(arriving) || is_black(share)) {
      ++counters.shadow_rays_skipped;
      continue;
    }
    if constexpr (kShadows) {
      // Light behind a surface that subtracts it is in the shadow of that surface.
      const bool shades_itself = material.diffuse_model == DiffuseModel::signed_lambert &&
                                 light.shadow_intensity == 1 && material.is_opaque() &&
                                 dot(point.geometric_normal, sample.wi) < 0;
      if (light.casts_shadow && shades_itself) {
        ++counters.shadow_rays_skipped;
        continue;
      }
      if (light.casts_shadow)
        arriving = arriving * visibility(scene, point, light, sample, counters);
    }
    sum += arriving * share;
  }
  return sum + ambient * material.ambient * kept;
}

template Color local_radiance<false>(const Scene&, const SurfacePoint&, const Vec3&, double,
                                     TraceCounters&);
template Color local_radiance<true>(const Scene&, const SurfacePoint&, const Vec3&, double,
                                    TraceCounters&);

}  // namespace tessera
