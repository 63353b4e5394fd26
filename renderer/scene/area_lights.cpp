#include "renderer/scene/area_lights.h"

#include <algorithm>
#include <utility>

namespace tessera {

void AreaLights::add(AreaLight light) {
  const Color both = light.front + light.back;
  const double power = (both.r + both.g + both.b) * light.sampler->area();
  sums_.push_back((sums_.empty() ? 0 : sums_.back()) + power);
  lights_.push_back(std::move(light));
}

AreaLights::Pick AreaLights::pick(double u) const {
  if (lights_.size() == 1) return {};
  const auto found = std::upper_bound(sums_.begin(), sums_.end() - 1, u * sums_.back());
  const auto index = static_cast<uint32_t>(found - sums_.begin());
  return {index, probability(index)};
}

double AreaLights::probability(uint32_t index) const {
  return (sums_[index] - (index > 0 ? sums_[index - 1] : 0)) / sums_.back();
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
