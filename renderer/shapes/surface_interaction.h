#pragma once

#include "renderer/math/rounding.h"
#include "renderer/math/transform.h"
#include "renderer/shapes/shape.h"

namespace tessera {

/// The surface at a hit in world space: what shading sees. Its geometric normal shows the front,
/// the shading normal leans at most 120 degrees from it, and the error bound counts the rounding of
/// later transforms of the point. Of the same type, so that none need be copied into the other:
/// wide loads of what was written in parts make the processor wait.
using SurfaceInteraction = LocalSurface;

/// Where the cosine between the normals of vertices and face is less, the mesh's normals are taken
/// to point inward and are flipped; others may lean as far from the face as they do.
inline constexpr double kFlipCosine = -0.5;

#include "renderer/shapes/surface_interaction-inl.h"

/// Takes the surface into world space where it stands. Normals go by the inverse transpose, so that
/// the front stays the front under a mirroring transform too; `flip_normals` turns them round.
void take_to_world(const Transform& world_from_object, bool flip_normals, uint32_t instance,
                   LocalSurface& surface);
/// The same where the transform is the identity and the shading normal is the geometric one.
inline void take_flat_to_world(bool flip_normals, uint32_t instance, LocalSurface& s) {
  Vec3 point = to_vec(s.point);
  keep_point(point, s.point_error);
  s.point = to_point(point);
  Vec3 n = kept_normal(static_cast<Vec3>(s.geometric_normal));
  if (flip_normals) n = -n;
  s.geometric_normal = s.shading_normal = to_normal(n);
  s.instance = instance;
}
inline SurfaceInteraction to_world(LocalSurface surface, const Transform& world_from_object,
                                   bool flip_normals, uint32_t instance) {
  take_to_world(world_from_object, flip_normals, instance, surface);
  return surface;
}

/// Where rays that leave a surface start, worked out once for each side of it: by moved_off(), so
/// that they do not meet the surface that they start on.
class RayOrigins {
 public:
  /// `from` must outlive this.
  explicit RayOrigins(const SurfaceInteraction& from) : from_(from) {}
  /// A ray to the side that `direction` points to.
  Ray spawn(const Vec3& direction) { return {towards(direction), direction}; }
  /// The stretch up to `target`: direction target - origin, t_max 1. The target is to lie on no
  /// surface (a point light): one that does must be moved off it by its error bound and by what
  /// rounding makes of the stretch, some units of its length (N24).
  Ray spawn_to(const Point3& target) {
    Ray ray{towards(target - from_.point), {}};
    ray.direction = target - ray.origin;
    ray.t_max = 1;
    return ray;
  }
  /// Where rays to the side that `direction` points to start.
  const Point3& towards(const Vec3& direction) {
    const bool behind = dot(from_.geometric_normal, direction) < 0;
    if (!known_[behind]) work_out(behind);
    return origins_[behind];
  }

 private:
  void work_out(bool behind) {
    origins_[behind] = to_point(moved_off(to_vec(from_.point), from_.point_error,
                                          static_cast<Vec3>(from_.geometric_normal), behind));
    known_[behind] = true;
  }

  const SurfaceInteraction& from_;
  Point3 origins_[2];
  bool known_[2] = {false, false};
};

inline Ray spawn_ray(const SurfaceInteraction& from, const Vec3& direction) {
  return RayOrigins(from).spawn(direction);
}
inline Ray spawn_ray_to(const SurfaceInteraction& from, const Point3& target) {
  return RayOrigins(from).spawn_to(target);
}

}  // namespace tessera
