#include "renderer/scene/occluders.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "renderer/accel/make_accelerator.h"
#include "renderer/shapes/plane.h"

namespace tessera {

Occluders make_occluders(std::span<const Instance> instances, const std::vector<bool>& is_clear,
                         const std::vector<bool>& counts,
                         const std::shared_ptr<const Accelerator>& all,
                         const TreeSettings& settings) {
  Occluders result;
  std::vector<Instance> opaque, clear;
  bool is_as_all = true;
  for (size_t i = 0; i < instances.size(); ++i) {
    if (!counts[i]) continue;
    (is_clear[i] ? clear : opaque).push_back(instances[i]);
    if (is_clear[i]) result.clear_instances.push_back(static_cast<uint32_t>(i));
    // any_hit() passes through what is said to cast none.
    Instance& added = is_clear[i] ? clear.back() : opaque.back();
    is_as_all &= std::exchange(added.casts_shadow, true);
  }
  const auto make = [&](std::vector<Instance> of) -> std::shared_ptr<const Accelerator> {
    if (of.empty()) return nullptr;
    return make_instance_accelerator(std::move(of), settings.kind, settings.threads,
                                     settings.scan_few);
  };
  result.opaque = is_as_all && opaque.size() == instances.size() ? all : make(std::move(opaque));
  result.clear = make(std::move(clear));
  return result;
}

bool shades_nothing(const Instance& instance, std::span<const Light> lights) {
  if (instance.shape->kind() != ShapeKind::plane || instance.cull != Cull::back) return false;
  if (!instance.world_from_object.is_identity() || instance.flip_normals) return false;
  const auto& plane = static_cast<const Plane&>(*instance.shape);
  constexpr double kClearly = 1e-9;  // far above the rounding of what follows
  return std::all_of(lights.begin(), lights.end(), [&](const Light& light) {
    if (!light.casts_shadow) return true;
    if (light.kind == LightKind::directional || light.kind == LightKind::cylinder) {
      return dot(plane.normal(), light.direction) < -kClearly;
    }
    const double height = plane.signed_distance(light.position);
    return height > kClearly * (std::abs(height) + length(light.position - Point3{}));
  });
}

}  // namespace tessera
