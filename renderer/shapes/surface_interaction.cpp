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

void place_moved(const Transform& world_from_object, LocalSurface& s) {
  const Point3 world = world_from_object.point(s.point);
  s.point_error = world_from_object.point_error(s.point, s.point_error) +
                  round_trip_error(world_from_object, world);
  s.point = world;
  const bool is_flat = s.shading_normal == s.geometric_normal;
  s.geometric_normal = normalize(world_from_object.normal(s.geometric_normal));
  s.shading_normal =
      is_flat ? s.geometric_normal : normalize(world_from_object.normal(s.shading_normal));
  s.smooth_shift = world_from_object.vector(s.smooth_shift);
  s.dpdu = world_from_object.vector(s.dpdu);
  s.dpdv = world_from_object.vector(s.dpdv);
  if (s.has_second_uv) {
    s.second_dpdu = world_from_object.vector(s.second_dpdu);
    s.second_dpdv = world_from_object.vector(s.second_dpdv);
  }
  s.tangent = world_from_object.vector(s.tangent);
  s.bitangent = world_from_object.vector(s.bitangent);
}

/// What place_moved() does, to the last bit, under the identity.
void place_unmoved(LocalSurface& s) {
  const Vec3 zero{};
  const auto placed = [&](const Normal3& normal) {
    const Vec3 n = static_cast<Vec3>(normal) + zero;
    return to_normal(length_squared(n) == 1 ? n : normalize(n));
  };
  const bool is_flat = s.shading_normal == s.geometric_normal;
  s.point = s.point + zero;  // no -0
  const Vec3 size = abs(s.point - Point3{}) * gamma(4);
  s.point_error = s.point_error * (gamma(3) + 1) + size + size;
  s.geometric_normal = placed(s.geometric_normal);
  s.shading_normal = is_flat ? s.geometric_normal : placed(s.shading_normal);
}

}  // namespace

void take_to_world(const Transform& world_from_object, bool flip_normals, uint32_t instance,
                   LocalSurface& s) {
  if (world_from_object.is_identity()) {
    place_unmoved(s);
  } else {
    place_moved(world_from_object, s);
  }
  if (flip_normals) s.geometric_normal = -s.geometric_normal, s.shading_normal = -s.shading_normal;
  if (dot(s.geometric_normal, s.shading_normal) < kFlipCosine) s.shading_normal = -s.shading_normal;
  s.instance = instance;
}

}  // namespace tessera
