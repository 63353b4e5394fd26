#include "renderer/accel/instance.h"

#include <limits>

namespace tessera {
namespace {

Cull opposite(Cull cull) {
  return cull == Cull::back ? Cull::front : cull == Cull::front ? Cull::back : Cull::none;
}

/// `ray` in the frame of the instance's shape. The direction is not made of unit length, so that t
/// is the same in both frames.
Ray to_object(const Instance& instance, const Ray& ray, Cull cull) {
  const Transform& place = instance.world_from_object;
  if (place.is_identity()) return {ray.origin, ray.direction, ray.t_min, ray.t_max, cull};
  return {place.inverse_point(ray.origin), place.inverse_vector(ray.direction), ray.t_min,
          ray.t_max, cull};
}

/// Calls query(local) with the ray in the shape's frame; false where every side is culled.
template <typename Query>
bool query_local(const Instance& instance, const Ray& ray, const Query& query) {
  Cull cull = instance.cull;
  if (ray.cull != Cull::none) {
    if (cull != Cull::none && cull != ray.cull) return false;
    cull = ray.cull;
  }
  if (instance.flip_normals) cull = opposite(cull);
  if (cull == ray.cull && instance.world_from_object.is_identity()) return query(ray);
  return query(to_object(instance, ray, cull));
}

}  // namespace

bool closest_hit_of_any(const Instance& instance, uint32_t number, const Ray& ray, Hit& hit,
                        TraversalCounters& counters) {
  // Of hits at equal t the smaller instance counts, whatever its primitive. The hit itself is lent
  // to the shape: to copy what was just written in parts makes the processor wait.
  const uint32_t primitive = hit.primitive;
  if (number < hit.instance) hit.primitive = std::numeric_limits<uint32_t>::max();
  if (number > hit.instance) hit.primitive = 0;
  const bool found = query_local(instance, ray, [&](const Ray& local) {
    return instance.shape->closest_hit(local, hit, counters);
  });
  if (found)
    hit.instance = number;
  else
    hit.primitive = primitive;
  return found;
}

bool any_hit_of_any(const Instance& instance, const Ray& ray, TraversalCounters& counters) {
  if (!instance.casts_shadow) return false;
  return query_local(instance, ray,
                     [&](const Ray& local) { return instance.shape->any_hit(local, counters); });
}

Bounds3 bounds_of(const Instance& instance) {
  return instance.world_from_object.bounds(instance.shape->bounds());
}

/// surface_at() of a plane that stands as it is and has no texture coordinates.
static SurfaceInteraction surface_in_place(const Plane& plane, const Instance& instance,
                                           const Ray& ray, const Hit& hit) {
  SurfaceInteraction surface;
  plane.place_surface(ray, hit, surface);
  take_flat_to_world(instance.flip_normals, hit.instance, surface);
  return surface;
}

SurfaceInteraction surface_at(std::span<const Instance> instances, const Ray& ray, const Hit& hit) {
  const Instance& instance = instances[hit.instance];
  const bool is_moved = !instance.world_from_object.is_identity();
  if (!is_moved && instance.shape->kind() == ShapeKind::plane) {
    const auto& plane = static_cast<const Plane&>(*instance.shape);
    if (!plane.keeps_uv()) return surface_in_place(plane, instance, ray, hit);
  }
  SurfaceInteraction surface =
      is_moved ? instance.shape->surface(to_object(instance, ray, ray.cull), hit)
               : instance.shape->surface(ray, hit);
  take_to_world(instance.world_from_object, instance.flip_normals, hit.instance, surface);
  return surface;
}

}  // namespace tessera
