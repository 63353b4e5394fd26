#pragma once

#include "renderer/integrator/surface_point.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// How often the background is chosen among the lights.
inline double environment_share(const Scene& scene) {
  if (!scene.environment) return 0;
  return scene.area_lights.empty() ? 1 : 0.5;
}

/// Whether there is a light to choose a point or a direction of.
inline bool has_sampled_lights(const Scene& scene) {
  return environment_share(scene) > 0 || !scene.area_lights.empty();
}
/// Whether a number chooses between lights.
inline bool picks_light(const Scene& scene) {
  const double to_sky = environment_share(scene);
  return to_sky < 1 && (to_sky > 0 || scene.area_lights.size() > 1);
}

/// The density, per steradian, with which a light's point is chosen in this one's direction, met by
/// a hit of that primitive; 0 where the surface is in no set of lights, or this side of it.
inline double light_density(const Scene& scene, const SurfacePoint& point, uint32_t primitive,
                            const LitPoint& from) {
  const auto light = scene.area_lights.find(point.surface.instance, point.surface.material);
  if (!light) return 0;
  const AreaLight& of = scene.area_lights[*light];
  if (is_black(point.is_back ? of.back : of.front)) return 0;
  return (1 - environment_share(scene)) *
         scene.area_lights.tree().probability(from.at, from.normal, *light) *
         of.sampler->density(from, point.surface.point, point.geometric_normal, primitive);
}

/// By what fraction of its length, for the rounding of that, a shadow ray to a point of a surface
/// stops before it, beyond the bound of the point's error.
inline constexpr double kLiftRoundings = 0x1p-48;

#include "renderer/integrator/light_sampling-inl.h"

}  // namespace tessera
