#include "renderer/scene/occluders.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "renderer/accel/make_accelerator.h"
#include "renderer/accel/tree_boxes.h"
#include "renderer/shapes/plane.h"

namespace tessera {

namespace {

/// Whether a table for each takes little room and time to make.
bool are_few_and_near(std::span<const Light> lights) {
  constexpr size_t kMost = 64;  // of 12 KiB each
  constexpr double kFarthest = 1e38;
  return !lights.empty() && lights.size() <= kMost &&
         std::all_of(lights.begin(), lights.end(), [](const Light& light) {
           return max_component(abs(light.position - Point3{})) < kFarthest;
         });
}

/// Of one instance too: to look up that it is not in the way takes less than to test it.
bool fit_a_row(std::span<const Instance> instances) {
  const auto held = std::count_if(instances.begin(), instances.end(), [](const Instance& instance) {
    return can_be_held(instance, bounds_of(instance));
  });
  return held > 0 && held <= std::ptrdiff_t{BoxSoA::kMost};
}

LightBuffer buffer_of(const Light& light, const BoxSoA& row) {
  return light.is_placed() ? LightBuffer::of_place(row, light.position)
                           : LightBuffer::of_direction(row, light.direction);
}

}  // namespace

Occluders make_occluders(std::span<const Instance> instances, const std::vector<bool>& is_clear,
                         const std::vector<bool>& counts,
                         const std::shared_ptr<const Accelerator>& all,
                         std::span<const Light> lights, const TreeSettings& settings) {
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
                                     *settings.code);
  };
  const bool looks_up = settings.kind != AcceleratorKind::linear && are_few_and_near(lights);
  if (is_as_all && opaque.size() == instances.size()) {
    result.opaque = all;
  } else if (looks_up && fit_a_row(opaque)) {
    result.opaque = std::make_shared<FewInstances>(std::move(opaque), *settings.code);
  } else {
    result.opaque = make(std::move(opaque));
  }
  result.clear = make(std::move(clear));
  result.takes_guesses = result.opaque && result.opaque->takes_guesses();
  if (looks_up) result.few = dynamic_cast<const FewInstances*>(result.opaque.get());
  if (result.few && !result.few->is_all_in_boxes()) result.few = nullptr;
  for (size_t i = 0; result.few && i < lights.size(); ++i)
    result.buffers.push_back(buffer_of(lights[i], result.few->boxes()));
  return result;
}

bool shades_nothing(const Instance& instance, std::span<const Light> lights) {
  if (instance.shape->kind() != ShapeKind::plane || instance.cull != Cull::back) return false;
  if (!instance.world_from_object.is_identity() || instance.flip_normals) return false;
  const auto& plane = static_cast<const Plane&>(*instance.shape);
  constexpr double kClearly = 1e-9;  // far above the rounding of what follows
  return std::all_of(lights.begin(), lights.end(), [&](const Light& light) {
    if (!light.casts_shadow) return true;
    if (!light.is_placed()) return dot(plane.normal(), light.direction) < -kClearly;
    const double height = plane.signed_distance(light.position);
    return height > kClearly * (std::abs(height) + length(light.position - Point3{}));
  });
}

}  // namespace tessera
