#pragma once

#include "renderer/math/transform.h"
#include "renderer/shapes/shape.h"

namespace tessera {

/// The surface at a hit in world space: what shading sees. Its geometric normal shows the front,
/// the shading normal is on the same side, and the error bound counts the rounding of later
/// transforms of the point.
struct SurfaceInteraction : LocalSurface {
  uint32_t instance = 0;
};

/// Normals go by the inverse transpose, so that the front stays the front under a mirroring
/// transform too; `flip_normals` turns them round.
SurfaceInteraction to_world(const LocalSurface& surface, const Transform& world_from_object,
                            bool flip_normals, uint32_t instance);

/// A ray from the surface to the side that `direction` points to, its origin moved off by the error
/// bound and rounded outward (PBRT 4ed, 6.8.6): it does not meet the surface that it starts on.
Ray spawn_ray(const SurfaceInteraction& from, const Vec3& direction);
/// The stretch from the surface up to `target`, a point that lies on no surface (a point light):
/// direction target - origin, t_max 1.
Ray spawn_ray_to(const SurfaceInteraction& from, const Point3& target);

}  // namespace tessera
