#pragma once

#include <algorithm>
#include <cmath>

#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/light_sampling.h"
#include "renderer/integrator/path_numbers.h"
#include "renderer/integrator/surface_point.h"
#include "renderer/shading/bsdf.h"

namespace tessera {

// What light that a path finds by itself is weighed by; `density` is that of its last direction, 0
// where there was no other way to go.

/// Of the background along `direction`; `place` as EnvironmentSampler::density() takes it.
inline double background_weight(const Scene& scene, double density, const Vec3& direction,
                                const Vec2* place = nullptr) {
  if (!(density > 0) || !scene.environment) return 1;
  return power_heuristic(density,
                         environment_share(scene) * scene.environment->density(direction, place));
}
/// The light emitted at `point`, met by a hit of that primitive, from where the path scattered
/// last.
inline double emission_weight(const Scene& scene, const SurfacePoint& point, uint32_t primitive,
                              double density, const LitPoint& from) {
  if (!(density > 0)) return 1;
  return power_heuristic(density, light_density(scene, point, primitive, from));
}

/// Where a path is scattered. Without kRich the scene must have no textures.
template <bool kRich, typename Scatter>
struct PathVertex {
  const Scene& scene;
  const SurfacePoint& point;
  const Scatter& scatter;
  RayOrigins& origins;
  const Media& media;  ///< on the viewer's side
  double path_length;  ///< metres from the camera
  double width;        ///< cone_width()
  TraceState& state;

  /// What lights of all kinds bring, of those with an extent and the background by one sample.
  /// Also a lane each, of Lambert surfaces, in path_wavefront-inl.h.
  template <typename Numbers>
  Color direct_light(const Numbers& numbers) const {
    Color sum = kBlack;
    const double to_sky = environment_share(scene);
    if (has_sampled_lights(scene)) {
      // One number picks twice.
      double u = picks_light(scene) ? numbers.pick().x : 0;
      if (u < to_sky) {
        sum += from_environment(to_sky, numbers.on_light());
      } else {
        u = (u - to_sky) / (1 - to_sky);
        const LightTree::Pick pick =
            scene.area_lights.tree().pick(point.surface.point, point.geometric_normal, u);
        const AreaLight& light = scene.area_lights[pick.index];
        if (light.is_dark_from(point.surface.point)) {
          ++state.counters.shadow_rays_skipped;
        } else {
          SurfaceSample there;
          const double density =
              light.sampler->sample({point.surface.point, point.geometric_normal},
                                    numbers.on_light(), there) *
              pick.probability * (1 - to_sky);
          sum += from_area_light(light, there, density);
        }
      }
    }
    add_lights(sum);
    return sum;
  }

  /// Of the background, which is chosen by the share `to_sky`.
  Color from_environment(double to_sky, const Vec2& on_light) const {
    EnvironmentSampler::Sample there = scene.environment->sample(on_light);
    there.density *= to_sky;
    if (!(there.density > 0)) return kBlack;
    const BsdfValue value = scatter.evaluate(there.wi);
    if (is_black(value.f_cosine)) {
      ++state.counters.shadow_rays_skipped;
      return kBlack;
    }
    const Ray ray = origins.spawn(there.wi);
    const Color visible = ray_visibility<kRich>(scene, point, ray, media, width, state);
    if (is_black(visible)) return kBlack;
    return scene.background.radiance(ray.origin, ray.direction, scene.lights) * value.f_cosine *
           visible * (power_heuristic(there.density, value.density) / there.density);
  }

  /// Of a point of a light that was chosen with that density.
  /// Also a lane each, of LambertBsdf, in path_wavefront_lights-inl.h, bit for bit.
  Color from_area_light(const AreaLight& light, const SurfaceSample& there, double density) const {
    if (!(density > 0)) return kBlack;
    const Vec3 wi = normalize(there.point - point.surface.point);
    Color emitted = dot(wi, there.normal) < 0 ? light.front : light.back;
    // Facing away, or nothing goes that way: no ray.
    BsdfValue value;
    if (!is_black(emitted)) value = scatter.evaluate(wi);
    if (is_black(value.f_cosine)) {
      ++state.counters.shadow_rays_skipped;
      return kBlack;
    }
    const Color visible =
        point_visibility<kRich>(scene, point, origins, media, there, width, state);
    if (is_black(visible)) return kBlack;
    if constexpr (kRich) {
      if (light.has_texture) {
        emitted = looked_up_emission(scene, light.instance, there, point.surface.point, width,
                                     state.counters);
      }
    }
    const double weight = power_heuristic(density, value.density);
    return emitted * value.f_cosine * visible * (weight / density);
  }

  /// Adds what the lights without an extent bring.
  void add_lights(Color& sum) const {
    const auto add_light = [&](uint32_t index) {
      const Light& light = scene.lights[index];
      LightSample sample{};
      if (!sample_light(light, point.surface.point, path_length, sample)) {
        ++state.counters.shadow_rays_skipped;
        return;
      }
      const Color share = scatter.evaluate(sample.wi).f_cosine * (portable::kPi * sample.factor);
      const Color arriving = light.intensity * share;
      if (is_black(arriving)) {
        ++state.counters.shadow_rays_skipped;
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
};

/// Whether a path goes on through the surface, by the share that is not there.
template <typename Numbers>
bool goes_straight(const SurfacePoint& point, const Numbers& numbers) {
  const Coverage coverage = straight_coverage(point);
  return coverage.through > 0 && (coverage.covered <= 0 || numbers.pick().y < coverage.through);
}

/// The way on of a path that was scattered `bounces` times before; false where it ends. Multiplies
/// `throughput`, and `radiance_scale`, what of it media of other density make.
/// Also a lane each, of Lambert surfaces, in path_wavefront-inl.h.
template <typename Numbers>
bool choose_way(const Bsdf& bsdf, uint32_t bounces, const Numbers& numbers, Color& throughput,
                double& radiance_scale, BsdfSample& sample, TraceCounters& counters) {
  const Vec2 choice = numbers.choice();
  if (!bsdf.sample(choice.x, numbers.direction(), sample)) return false;
  throughput = throughput * sample.weight;
  radiance_scale *= sample.radiance_scale;
  // What lies ahead is as bright whatever the medium makes of radiance.
  const double worth = max_component(throughput) / radiance_scale;
  if (!(worth > 0)) return false;
  if (bounces >= kSafeDepth) {
    const double survival = std::min(std::sqrt(worth), 1.0);
    if (choice.y >= survival) {
      ++counters.roulette_ends;
      return false;
    }
    throughput = throughput * (1 / survival);
  }
  ++(sample.is_transmitted ? counters.rays_refraction : counters.rays_reflection);
  return true;
}

}  // namespace tessera
