#include "renderer/integrator/surface_point.h"

namespace tessera {

SurfacePoint surface_point(const Scene& scene, uint32_t instance_index, const Ray& ray,
                           const Hit& hit) {
  SurfacePoint point;
  Hit numbered = hit;
  numbered.instance = instance_index;
  point.surface = surface_at(scene.instances, ray, numbered);
  point.is_back = dot(point.surface.geometric_normal, ray.direction) > 0;
  point.material = &scene.material(instance_index, point.surface.material);
  if (point.is_back && point.material->sides != Sides::two_sided) {
    point.is_hidden = point.material->sides == Sides::front_only;
    if (!point.is_hidden) point.material = &scene.materials[point.material->back];
  }
  point.geometric_normal = static_cast<Vec3>(point.surface.geometric_normal);
  point.normal = point.material->flat ? point.geometric_normal
                                      : static_cast<Vec3>(point.surface.shading_normal);
  if (point.is_back) {
    point.geometric_normal = -point.geometric_normal;
    point.normal = -point.normal;
  }
  return point;
}

Coverage straight_coverage(const SurfacePoint& point) {
  if (point.is_hidden) return {1, 0};
  const Material& material = *point.material;
  const double alpha = point.surface.vertex_alpha;
  if (alpha < 1) {
    const double covered =
        material.vertex_color_replaces_diffuse ? alpha : (1 - material.transparency) * alpha;
    return {1 - covered, covered};
  }
  if (material.transmission == Transmission::refract) return {};
  return {material.transparency, 1 - material.transparency};
}

}  // namespace tessera
