#include "renderer/shapes/surface_interaction.h"

#include "renderer/math/rounding.h"

namespace tessera {
namespace {

void place_moved(const Transform& world_from_object, LocalSurface& s) {
  Vec3 point = to_vec(s.point);
  move_point(world_from_object.matrix(), world_from_object.inverse_matrix(), point, s.point_error);
  s.point = to_point(point);
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

/// What place_moved() does, bit for bit, under the identity.
void place_unmoved(LocalSurface& s) {
  const auto kept = [](const Normal3& n) { return to_normal(kept_normal(static_cast<Vec3>(n))); };
  const bool is_flat = s.shading_normal == s.geometric_normal;
  Vec3 point = to_vec(s.point);
  keep_point(point, s.point_error);
  s.point = to_point(point);
  s.geometric_normal = kept(s.geometric_normal);
  s.shading_normal = is_flat ? s.geometric_normal : kept(s.shading_normal);
}

}  // namespace

void take_to_world(const Transform& world_from_object, bool flip_normals, uint32_t instance,
                   LocalSurface& s) {
  if (world_from_object.is_identity()) {
    place_unmoved(s);
  } else {
    place_moved(world_from_object, s);
  }
  Vec3 front = static_cast<Vec3>(s.geometric_normal), shading = static_cast<Vec3>(s.shading_normal);
  turn_normals(flip_normals, front, shading);
  s.geometric_normal = to_normal(front), s.shading_normal = to_normal(shading);
  s.instance = instance;
}

}  // namespace tessera
