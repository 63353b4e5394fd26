#pragma once

#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/light_sampling.h"
#include "renderer/integrator/surface_point.h"
#include "renderer/shading/bsdf.h"

namespace tessera {

// What light one vertex of a path gets from where it is sampled, and what it is weighed by where the
// path finds it by itself. `density` is that of the path's last direction, 0 where there was no
// other way to go; `media` are those on the viewer's side of the vertex.

/// Of the background along `direction`.
inline double background_weight(const Scene& scene, double density, const Vec3& direction) {
  if (!(density > 0) || !scene.environment) return 1;
  return power_heuristic(density,
                         environment_share(scene) * scene.environment->density(direction));
}
/// Of what shines at `point`, from where the path scattered last.
inline double emission_weight(const Scene& scene, const SurfacePoint& point, double density,
                              const Point3& from, const Vec3& from_normal) {
  if (!(density > 0)) return 1;
  return power_heuristic(density, light_density(scene, point, from, from_normal));
}

/// What the background's sample brings, over its density.
template <bool kRich, typename Scatter>
Color light_from_environment(const Scene& scene, const EnvironmentSampler::Sample& there,
                             const SurfacePoint& point, const Scatter& scatter, RayOrigins& origins,
                             const Media& media, double width, TraceState& state) {
  if (!(there.density > 0)) return kBlack;
  const BsdfValue value = scatter.evaluate(there.wi);
  const bool is_dark = is_black(value.share);
  if (is_dark && scene.skips.dark_shadow_rays) {
    ++state.counters.shadow_rays_skipped;
    return kBlack;
  }
  const Ray ray = origins.spawn(there.wi);
  const Color visible = ray_visibility<kRich>(scene, point, ray, media, width, state);
  if (is_black(visible) || is_dark) return kBlack;
  return scene.background.radiance(ray.origin, ray.direction, scene.lights) * value.share *
         visible * (power_heuristic(there.density, value.density) / there.density);
}

/// Adds what the lights without an extent bring.
template <bool kRich, typename Scatter>
void add_lights(const Scene& scene, const SurfacePoint& point, const Scatter& scatter,
                RayOrigins& origins, const Media& media, double path_length, double width,
                TraceState& state, Color& sum) {
  const auto add_light = [&](uint32_t index) {
    const Light& light = scene.lights[index];
    LightSample sample;
    const auto leave_out = [&](bool skips) {
      if (skips) {
        ++state.counters.shadow_rays_skipped;
      } else {
        trace_for_nothing<kRich>(scene, point, media, light, sample, width, state);
      }
    };
    if (!sample_light(light, point.surface.point, path_length, sample)) {
      leave_out(scene.skips.unreached_lights);
      return;
    }
    const Color share = scatter.evaluate(sample.wi).share * (portable::kPi * sample.factor);
    const Color arriving = light.intensity * share;
    if (is_black(arriving)) {
      leave_out(scene.skips.dark_shadow_rays);
      return;
    }
    Color visible = kWhite;
    if (light.casts_shadow) {
      visible =
          light_visibility<kRich>(scene, point, origins, media, light, sample, width, state);
    }
    sum += arriving * visible;
  };
  state.counters.lights_culled +=
      scene.for_each_light(point.surface.instance, point.surface.point, add_light);
}

}  // namespace tessera
