#include "renderer/scene/plain_features.h"

#include <algorithm>
#include <cmath>

namespace tessera {

void find_plain_features(Scene& scene, bool is_clear) {
  SceneFeatures& features = scene.features;
  const Skips& skips = scene.skips;
  const auto is_simple = [&](const Light& light) {
    const bool whole_shadow = light.casts_shadow && light.shadow_intensity == 1;
    return !light.ambient_attenuated && (whole_shadow || !features.shadows);
  };
  const auto is_plain = [&](const Light& light) {
    return !std::isfinite(light.shadow_distance) || !features.shadows;
  };
  const auto all_are = [&](bool (Material::*kind)() const) {
    return std::all_of(scene.materials.begin(), scene.materials.end(),
                       [&](const Material& material) { return (material.*kind)(); });
  };
  features.simple = skips.absent_features && skips.dark_shadow_rays && skips.unreached_lights &&
                    !is_clear && !features.rich && !scene.occluders.clear &&
                    scene.fog.kind == FogKind::none &&
                    std::all_of(scene.lights.begin(), scene.lights.end(), is_simple) &&
                    all_are(&Material::is_simple);
  features.plain = features.simple && !features.secondary &&
                   std::all_of(scene.lights.begin(), scene.lights.end(), is_plain) &&
                   all_are(&Material::is_plain);
}

}  // namespace tessera
