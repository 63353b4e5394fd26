#include "renderer/integrator/whitted_surfaces.h"

#include "renderer/integrator/surface_point.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/surface_interaction.h"

namespace tessera {

WhittedSurfaces::WhittedSurfaces(const Scene& scene)
    : scene_(scene),
      batches_shadows_(scene.occluders.opaque && scene.occluders.opaque->takes_batches()),
      at_camera_(media_at_camera(scene)) {
  for (const std::vector<uint32_t>& scope : scene.scoped_lights) {
    Color& ambient = ambients_.emplace_back(scene.settings.ambient);
    Scene::for_each_light(scene.global_lights.all(), scope,
                          [&](uint32_t index) { ambient += scene.lights[index].ambient; });
  }
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    Placed& placed = placed_.emplace_back();
    placed.light_set = scene.shading[i].light_set;
    placed.is_simple = scene.features.plain_light && !scene.shading[i].has_alpha;
    for (uint32_t slot = 0; slot < scene.shading[i].material_count; ++slot) {
      const Material& material = scene.material(static_cast<uint32_t>(i), slot);
      placed.is_simple &= material.is_simple();
      are_simple_ &= !material.hides_back();
    }
    are_simple_ &= placed.is_simple;
    if (!instance.world_from_object.is_identity()) continue;
    placed.facing = instance.flip_normals ? -1 : 1;
    if (instance.shape->kind() == ShapeKind::sphere) placed.form = Form::sphere;
    if (instance.shape->kind() != ShapeKind::plane) continue;
    placed.form = Form::plane;
    SurfaceInteraction surface;
    surface.geometric_normal = to_normal(static_cast<const Plane&>(*instance.shape).normal());
    take_flat_to_world(instance.flip_normals, static_cast<uint32_t>(i), surface);
    placed.normal = static_cast<Vec3>(surface.geometric_normal);
  }
}

}  // namespace tessera
