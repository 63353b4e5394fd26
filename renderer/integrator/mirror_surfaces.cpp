#include "renderer/integrator/mirror_surfaces.h"

#include <algorithm>
#include <iterator>

#include "renderer/shapes/plane.h"
#include "renderer/shapes/surface_interaction.h"

namespace tessera {

MirrorSurfaces::MirrorSurfaces(const Scene& scene, const MirrorPathFollower& alone)
    : scene_(scene), alone_(alone) {
  for (const std::vector<uint32_t>& scoped : scene.scoped_lights) {
    const std::span<const uint32_t> everywhere = scene.global_lights.all();
    std::vector<uint32_t>& lights = lights_.emplace_back();
    std::ranges::merge(everywhere, scoped, std::back_inserter(lights));
  }
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    Placed& placed = placed_.emplace_back();
    placed.lights = lights_[scene.shading[i].light_set];
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
