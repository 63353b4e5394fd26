#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/accel/deferred_mesh.h"
#include "renderer/accel/instance.h"
#include "renderer/camera/camera.h"
#include "renderer/film/tile.h"
#include "renderer/sampler/sampler.h"
#include "renderer/scene/area_lights.h"
#include "renderer/scene/light_grid.h"
#include "renderer/scene/occluders.h"
#include "renderer/scene/origins.h"
#include "renderer/scene/read_settings.h"
#include "renderer/scene/sample_cones.h"
#include "renderer/shading/background.h"
#include "renderer/shading/environment_sampler.h"
#include "renderer/shading/glass_albedo.h"
#include "renderer/shading/light.h"
#include "renderer/shading/material.h"
#include "renderer/shading/material_inputs.h"

namespace tessera {

/// What shading needs to know of an instance.
struct InstanceShading {
  uint32_t first_material = 0;  ///< into Scene::material_slots
  uint32_t material_count = 1;
  uint32_t light_set = 0;
  bool has_alpha = false;  ///< may let any ray through unbent
};

/// What tracing this scene may leave out.
struct SceneFeatures {
  bool shadows = false;  ///< some light casts shadows and something may
  bool rich = false;     ///< materials with textures, or of other models than classic and unlit
  bool alpha = false;    ///< some surface may let a ray through unbent
  bool lambert = false;  ///< no material but classic ones that only scatter evenly or emit
  /// No fog, and lights whose ambient part reaches all, and that an occluder blocks whole.
  bool plain_light = false;

  int absent() const { return !shadows + !rich + lambert + plain_light; }
};

/// One frame, ready to be traced: made of exactly what its picture depends on. Immutable once built
/// and shared by threads.
struct Scene {
  RenderSettings settings;
  std::optional<Camera> camera;    ///< always there once built
  std::optional<Sampler> sampler;  ///< always there once built
  Background background;
  Fog fog;
  SceneFeatures features;

  std::vector<Material> materials;
  std::vector<MaterialInputs> inputs;  ///< by Material::inputs
  std::vector<Texture> textures;
  SampleCones cones;
  std::vector<uint32_t> material_slots;  ///< indices into materials
  std::vector<Instance> instances;
  std::vector<InstanceShading> shading;    ///< one an instance
  std::shared_ptr<const Origins> origins;  ///< of instances; null where nobody asks for them
  std::vector<Light> lights;
  LightGrid global_lights;                           ///< indices into lights
  std::vector<std::vector<uint32_t>> scoped_lights;  ///< the others of each scope, ascending

  // For the path integrator.
  std::vector<std::unique_ptr<const GlassAlbedo>> glass_albedos;  ///< of `materials`
  AreaLights area_lights;
  std::shared_ptr<const EnvironmentSampler> environment;  ///< null: directions spread evenly do

  std::shared_ptr<const Accelerator> surfaces;  ///< every instance
  Occluders occluders;                          ///< of the light of `lights`
  /// Of light from emissive surfaces and the background: all that stops a path.
  Occluders path_occluders;

  CounterMap counters;  ///< of building
  /// Trees of meshes built since it was last set to 0; null where all were built with the scene.
  std::shared_ptr<DeferredBuilds> built_when_hit;

  /// Pixels outside this rectangle of the frame look past everything: none of their samples can
  /// hit.
  PixelRect seen;

  const Material& material(uint32_t instance, uint32_t index) const {
    const InstanceShading& s = shading[instance];
    const uint32_t slot = index < s.material_count ? index : s.material_count - 1;
    return materials[material_slots[s.first_material + slot]];
  }
  /// Calls `visit` with the index of each light that reaches the instance and may reach the point,
  /// in ascending order. Returns how many of the first do not reach the point.
  template <typename Visit>
  [[gnu::always_inline]] uint64_t for_each_light(uint32_t instance, const Point3& point,
                                                 const Visit& visit) const {
    const std::span<const uint32_t> globals = global_lights.at(point);
    for_each_light(globals, scoped_lights[shading[instance].light_set], visit);
    return global_lights.all().size() - globals.size();
  }
  /// Of both, one of the lists of global_lights and one of scoped_lights, in ascending order.
  template <typename Visit>
  [[gnu::always_inline]] static void for_each_light(std::span<const uint32_t> globals,
                                                    std::span<const uint32_t> scope,
                                                    const Visit& visit) {
    auto global = globals.begin(), scoped = scope.begin();
    // From one place, so that it is compiled where it stands.
    while (global != globals.end() || scoped != scope.end()) {
      const bool from_scope =
          scoped != scope.end() && (global == globals.end() || *scoped < *global);
      visit(from_scope ? *scoped++ : *global++);
    }
  }
};

}  // namespace tessera
