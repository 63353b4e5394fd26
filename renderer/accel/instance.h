#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "renderer/math/transform.h"
#include "renderer/shapes/shape.h"
#include "renderer/shapes/surface_interaction.h"

namespace tessera {

/// A shape at a place in the world. Many instances may share one shape. The front of a surface is
/// what its shape calls so, under mirroring transforms too.
struct Instance {
  std::shared_ptr<const Shape> shape;
  Transform world_from_object{};
  bool casts_shadow = true;   ///< else any_hit passes through it
  Cull cull = Cull::none;     ///< sides that no ray sees, besides those that the ray culls
  bool flip_normals = false;  ///< front and back, and the normals, change places
};

/// False for a ray with a part that is not finite, or no direction: it hits nothing.
inline bool can_hit(const Ray& ray) {
  return is_finite(ray.origin - Point3{}) && is_finite(ray.direction) && ray.direction != Vec3{};
}

/// As Shape::closest_hit for instance `number` and a ray in world space; sets hit.instance.
bool closest_hit_of(const Instance& instance, uint32_t number, const Ray& ray, Hit& hit,
                    TraversalCounters& counters);
/// As Shape::any_hit; never for an instance that casts no shadow.
bool any_hit_of(const Instance& instance, const Ray& ray, TraversalCounters& counters);
/// In world space. Endless for an endless shape.
Bounds3 bounds_of(const Instance& instance);

/// What lies at a hit that an accelerator over `instances` reported for this world-space ray.
SurfaceInteraction surface_at(std::span<const Instance> instances, const Ray& ray, const Hit& hit);

}  // namespace tessera
