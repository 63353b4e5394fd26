#include "renderer/scene/simple_features.h"

#include <algorithm>

namespace tessera {

bool has_simple_features(const Scene& scene, bool is_clear) {
  const auto is_simple = [&](const Light& light) {
    const bool whole_shadow = light.casts_shadow && light.shadow_intensity == 1;
    return !light.ambient_attenuated && (whole_shadow || !scene.features.shadows);
  };
  return !is_clear && !scene.features.rich && !scene.occluders.clear &&
         scene.fog.kind == FogKind::none && std::ranges::all_of(scene.lights, is_simple) &&
         std::ranges::all_of(scene.materials, &Material::is_simple);
}

}  // namespace tessera
