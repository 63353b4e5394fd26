#include "renderer/scene/area_lights.h"

#include <algorithm>
#include <utility>

namespace tessera {

AreaLights::AreaLights(std::vector<AreaLight> lights) : lights_(std::move(lights)) {
  std::vector<LightTree::Light> in_tree;
  for (const AreaLight& light : lights_) {
    const Color both = light.front + light.back;
    in_tree.push_back(
        {light.sampler->bounds(), (both.r + both.g + both.b) * light.sampler->area()});
  }
  tree_ = LightTree(in_tree);
}

std::optional<uint32_t> AreaLights::find(uint32_t instance, uint32_t material) const {
  const auto key = [](const AreaLight& light) { return std::pair(light.instance, light.material); };
  const auto found = std::lower_bound(
      lights_.begin(), lights_.end(), std::pair(instance, material),
      [&](const AreaLight& light, const auto& wanted) { return key(light) < wanted; });
  if (found == lights_.end() || key(*found) != std::pair(instance, material)) return std::nullopt;
  return static_cast<uint32_t>(found - lights_.begin());
}

}  // namespace tessera
