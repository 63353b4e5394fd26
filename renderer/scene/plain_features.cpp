#include "renderer/scene/plain_features.h"

#include <algorithm>
#include <cmath>

namespace tessera {

bool has_plain_features(const Scene& scene) {
  const SceneFeatures& features = scene.features;
  const Skips& skips = scene.skips;
  const auto is_plain = [&](const Light& light) {
    const bool whole_shadow =
        light.casts_shadow && light.shadow_intensity == 1 && !std::isfinite(light.shadow_distance);
    return !light.ambient_attenuated && (whole_shadow || !features.shadows);
  };
  return skips.absent_features && skips.dark_shadow_rays && skips.unreached_lights &&
         !features.secondary && !features.rich && !scene.occluders.clear &&
         scene.fog.kind == FogKind::none &&
         std::all_of(scene.lights.begin(), scene.lights.end(), is_plain) &&
         std::all_of(scene.materials.begin(), scene.materials.end(),
                     [](const Material& material) { return material.is_plain(); });
}

}  // namespace tessera
