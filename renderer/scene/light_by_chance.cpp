#include "renderer/scene/light_by_chance.h"

#include <algorithm>

namespace tessera {

double light_by_chance(const Scene& scene) {
  double most = 1;
  if (scene.settings.integrator != IntegratorKind::path ||
      std::none_of(scene.materials.begin(), scene.materials.end(),
                   [](const Material& material) { return material.throws_light(); })) {
    return most;
  }
  for (uint32_t i = 0; i < scene.area_lights.size(); ++i) {
    const AreaLight& light = scene.area_lights[i];
    most = std::max({most, max_component(light.front), max_component(light.back)});
  }
  const Background& background = scene.background;
  const bool has_sun = background.daylight && background.has_sun_disc;
  return has_sun ? std::max(most, max_component(background.daylight->sun_at_center())) : most;
}

}  // namespace tessera
