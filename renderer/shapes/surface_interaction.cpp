#include "renderer/shapes/surface_interaction.h"

#include "renderer/math/rounding.h"

namespace tessera {
namespace {

/// What taking the point into the shape's frame again and back adds to its error.
Vec3 round_trip_error(const Transform& world_from_object, const Point3& world) {
  const auto& to = world_from_object.matrix().m;
  const auto& from = world_from_object.inverse_matrix().m;
  Vec3 local;
  for (int r = 0; r < 3; ++r)
    local[r] = gamma(4) * (std::abs(from[r][0] * world.x) + std::abs(from[r][1] * world.y) +
                           std::abs(from[r][2] * world.z) + std::abs(from[r][3]));
  Vec3 error;
  for (int r = 0; r < 3; ++r)
    error[r] =
        std::abs(to[r][0]) * local.x + std::abs(to[r][1]) * local.y + std::abs(to[r][2]) * local.z;
  return error;
}

Point3 offset_origin(const SurfaceInteraction& from, const Vec3& direction) {
  const Vec3 n = static_cast<Vec3>(from.geometric_normal);
  const double reach = dot(abs(n), from.point_error);
  const Vec3 offset = n * (dot(n, direction) < 0 ? -reach : reach);
  Point3 origin = from.point + offset;
  for (int a = 0; a < 3; ++a) {
    if (offset[a] > 0) origin[a] = next_up(origin[a]);
    if (offset[a] < 0) origin[a] = next_down(origin[a]);
  }
  return origin;
}

void place_moved(const LocalSurface& surface, const Transform& world_from_object,
                 SurfaceInteraction& s) {
  s.point = world_from_object.point(surface.point);
  s.point_error = world_from_object.point_error(surface.point, surface.point_error) +
                  round_trip_error(world_from_object, s.point);
  s.geometric_normal = normalize(world_from_object.normal(surface.geometric_normal));
  s.shading_normal = surface.shading_normal == surface.geometric_normal
                         ? s.geometric_normal
                         : normalize(world_from_object.normal(surface.shading_normal));
  s.dpdu = world_from_object.vector(surface.dpdu);
  s.dpdv = world_from_object.vector(surface.dpdv);
}

/// What place_moved() gives, to the last bit, under the identity.
void place_unmoved(const LocalSurface& surface, SurfaceInteraction& s) {
  const Vec3 zero{};
  s.point = surface.point + zero;  // no -0
  for (int a = 0; a < 3; ++a) {
    const double size = gamma(4) * std::abs(s.point[a]);
    s.point_error[a] = (gamma(3) + 1) * surface.point_error[a] + size + size;
  }
  const auto placed = [&](const Normal3& n) {
    return to_normal(normalize(static_cast<Vec3>(n) + zero));
  };
  s.geometric_normal = placed(surface.geometric_normal);
  s.shading_normal = surface.shading_normal == surface.geometric_normal
                         ? s.geometric_normal
                         : placed(surface.shading_normal);
  s.dpdu = surface.dpdu;
  s.dpdv = surface.dpdv;
}

}  // namespace

SurfaceInteraction to_world(const LocalSurface& surface, const Transform& world_from_object,
                            bool flip_normals, uint32_t instance) {
  SurfaceInteraction s;
  if (world_from_object.is_identity()) {
    place_unmoved(surface, s);
  } else {
    place_moved(surface, world_from_object, s);
  }
  if (flip_normals) s.geometric_normal = -s.geometric_normal, s.shading_normal = -s.shading_normal;
  if (dot(s.geometric_normal, s.shading_normal) < 0) s.shading_normal = -s.shading_normal;
  s.uv = surface.uv;
  s.vertex_color = surface.vertex_color;
  s.vertex_alpha = surface.vertex_alpha;
  s.has_vertex_color = surface.has_vertex_color;
  s.material = surface.material;
  s.instance = instance;
  return s;
}

Ray spawn_ray(const SurfaceInteraction& from, const Vec3& direction) {
  return {offset_origin(from, direction), direction};
}

Ray spawn_ray_to(const SurfaceInteraction& from, const Point3& target) {
  Ray ray{offset_origin(from, target - from.point), {}};
  ray.direction = target - ray.origin;
  ray.t_max = 1;
  return ray;
}

}  // namespace tessera
