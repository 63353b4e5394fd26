#include "renderer/integrator/path_surfaces.h"

#include <algorithm>

#include "renderer/accel/mesh_shape.h"
#include "renderer/integrator/surface_point.h"
#include "renderer/shapes/csg_shape.h"

namespace tessera {

namespace {

/// Whether it scatters evenly wherever it is looked up. Beside other models a black surface is one
/// that does not scatter, to be counted as such.
bool is_even(const Scene& scene, const Material& material) {
  Material plain = material;
  plain.inputs = kNoMaterialInputs;
  if (!plain.is_lambert() || fills(plain) || !plain.is_lit()) return false;
  if (!scene.features.lambert && is_black(material.diffuse)) return false;
  if (material.inputs == kNoMaterialInputs) return true;
  using Target = MaterialInputs::Target;
  return std::ranges::all_of(scene.inputs[material.inputs].slots, [](const auto& slot) {
    return slot.target == Target::ambient || slot.target == Target::diffuse ||
           slot.target == Target::emission;
  });
}

}  // namespace

PathSurfaces::PathSurfaces(const Scene& scene)
    : scene_(scene),
      passes_(scene.fog.kind != FogKind::none || scene.path_occluders.clear ||
              scene.features.alpha ||
              std::ranges::any_of(scene.materials, [](const Material& material) {
                return !is_black(material.absorption);
              })) {
  if (passes_) at_camera_ = media_at_camera(scene);
  for (const Material& material : scene.materials)
    sides_.push_back({material.diffuse, !is_black(material.emission)});
  for (uint32_t i = 0; i < scene.instances.size(); ++i) placed_.push_back(place(i));
}

PathSurfaces::Placed PathSurfaces::place(uint32_t number) const {
  const Instance& instance = scene_.instances[number];
  Placed placed;
  placed.instance = &instance;
  if (const auto* const mesh = dynamic_cast<const MeshShape*>(instance.shape.get())) {
    constexpr size_t kMostVertices = size_t{1} << 29;  // their parts are numbered by 31 bits
    placed.mesh = &mesh->mesh();
    if (placed.mesh->positions.size() <= kMostVertices) placed.form = Form::mesh;
  }
  const auto* const rectangle = dynamic_cast<const Rectangle*>(instance.shape.get());
  if (rectangle && instance.world_from_object.is_identity()) {
    placed.form = Form::rectangle;
    placed.rectangle = rectangle;
    SurfaceInteraction surface = rectangle->surface({}, {});
    take_to_world(instance.world_from_object, instance.flip_normals, number, surface);
    placed.normal = static_cast<Vec3>(surface.geometric_normal);
  }
  find_sides(number, placed);
  return placed;
}

void PathSurfaces::find_sides(uint32_t number, Placed& placed) const {
  const InstanceShading& shading = scene_.shading[number];
  const auto back_of = [&](const Material& material) -> const Material& {
    return material.has_other_back() ? scene_.materials[material.back] : material;
  };
  placed.is_even = !shading.has_alpha;
  for (uint32_t i = 0; i < shading.material_count; ++i) {
    const Material& material = scene_.material(number, i);
    for (const Material* const side : {&material, &back_of(material)}) {
      placed.is_even &= is_even(scene_, *side);
      placed.has_inputs |= side->inputs != kNoMaterialInputs;
    }
  }
  // Solids made of others may have any that theirs have.
  const bool has_colors = (placed.mesh && !placed.mesh->colors.empty()) ||
                          dynamic_cast<const CsgShape*>(placed.instance->shape.get()) != nullptr;
  placed.is_uniform = shading.material_count == 1 && !has_colors && !placed.has_inputs;
  if (!placed.is_uniform) return;
  const Material& front = scene_.material(number, 0);
  const Material& back = back_of(front);
  if (!front.flat) placed.front = &sides_[static_cast<size_t>(&front - scene_.materials.data())];
  if (!back.flat) placed.back = &sides_[static_cast<size_t>(&back - scene_.materials.data())];
}

}  // namespace tessera
