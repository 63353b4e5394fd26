#include "renderer/scene/area_lights.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "renderer/scene/scene.h"
#include "renderer/shapes/triangle_sampler.h"

namespace tessera {

namespace {

bool has_texture(const Scene& scene, const Material& material) {
  if (material.inputs == kNoMaterialInputs) return false;
  const auto& slots = scene.inputs[material.inputs].slots;
  return std::any_of(slots.begin(), slots.end(), [](const MaterialInputs::Slot& slot) {
    return slot.target == MaterialInputs::Target::emission;
  });
}

LitSides lit_sides(const AreaLight& light) {
  if (is_black(light.back)) return LitSides::front;
  return is_black(light.front) ? LitSides::back : LitSides::both;
}

/// Whether vertex colours let some of what is behind the mesh through: alpha in part, whatever its
/// material.
bool has_alpha(const TriangleMesh& mesh) {
  return std::any_of(mesh.colors.begin(), mesh.colors.end(),
                     [](const Float4& color) { return color.w < 1; });
}

/// Makes what all instances of a mesh share once.
class Samplers {
 public:
  std::shared_ptr<const SurfaceSampler> make(const Instance& instance, const TriangleMesh* mesh,
                                             uint32_t slot, LitSides sides) {
    const Transform& to_world = instance.world_from_object;
    if (mesh == nullptr) {
      if (slot > 0) return nullptr;
      return instance.shape->make_sampler(to_world, instance.flip_normals);
    }
    const bool has_backs = instance.cull == Cull::none;
    auto& triangles = triangles_[{mesh, slot, has_backs}];
    if (!triangles) {
      triangles = std::make_shared<TriangleSet>(
          has_alpha(*mesh) ? TriangleSet() : TriangleSet::of(*mesh, slot, has_backs));
    }
    return make_triangle_sampler(triangles, to_world, instance.flip_normals, sides);
  }

 private:
  /// By mesh, material and whether it has backs.
  std::map<std::tuple<const TriangleMesh*, uint32_t, bool>, std::shared_ptr<const TriangleSet>>
      triangles_;
};

void set_dark_side(AreaLight& light) {
  Vec3 normal;
  if (!light.sampler->is_flat(light.at, normal)) return;
  if (is_black(light.front)) light.dark_normal = normal;
  if (is_black(light.back)) light.dark_normal = -normal;
}

}  // namespace

AreaLights find_area_lights(const Scene& scene, std::span<const TriangleMesh* const> meshes) {
  std::vector<AreaLight> lights;
  Samplers samplers;
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    for (uint32_t slot = 0; slot < scene.shading[i].material_count; ++slot) {
      const Material& material = scene.material(i, slot);
      AreaLight light;
      light.instance = i;
      light.material = slot;
      light.front = material.emitted();
      light.has_texture = has_texture(scene, material);
      if (!material.hides_back()) light.back = light.front;
      if (material.has_other_back()) {
        light.back = scene.materials[material.back].emitted();
        light.has_texture |= has_texture(scene, scene.materials[material.back]);
      }
      if (is_black(light.front) && is_black(light.back)) continue;
      light.sampler = samplers.make(scene.instances[i], meshes[i], slot, lit_sides(light));
      if (!light.sampler) continue;
      set_dark_side(light);
      lights.push_back(std::move(light));
    }
  }
  return AreaLights(std::move(lights));
}

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
