#include "renderer/accel/instance.h"

#include <limits>

namespace tessera {
namespace {

Cull opposite(Cull cull) {
  return cull == Cull::back ? Cull::front : cull == Cull::front ? Cull::back : Cull::none;
}

Ray to_object(const Instance& instance, const Ray& ray) {
  if (instance.world_from_object.is_identity()) return ray;
  Ray local = ray;
  local.origin = instance.world_from_object.inverse_point(ray.origin);
  // Not made of unit length, so that t is the same in both frames.
  local.direction = instance.world_from_object.inverse_vector(ray.direction);
  return local;
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
  Ray local = to_object(instance, ray);
  local.cull = cull;
  return query(local);
}

}  // namespace

bool closest_hit_of_any(const Instance& instance, uint32_t number, const Ray& ray, Hit& hit,
                        TraversalCounters& counters) {
  // Of hits at equal t the smaller instance counts, whatever its primitive.
  Hit candidate = hit;
  if (number < hit.instance) candidate.primitive = std::numeric_limits<uint32_t>::max();
  if (number > hit.instance) candidate.primitive = 0;
  const bool found = query_local(instance, ray, [&](const Ray& local) {
    return instance.shape->closest_hit(local, candidate, counters);
  });
  if (!found) return false;
  hit = candidate;
  hit.instance = number;
  return true;
}

bool any_hit_of_any(const Instance& instance, const Ray& ray, TraversalCounters& counters) {
  if (!instance.casts_shadow) return false;
  return query_local(instance, ray,
                     [&](const Ray& local) { return instance.shape->any_hit(local, counters); });
}

Bounds3 bounds_of(const Instance& instance) {
  return instance.world_from_object.bounds(instance.shape->bounds());
}

SurfaceInteraction surface_at(std::span<const Instance> instances, const Ray& ray, const Hit& hit) {
  const Instance& instance = instances[hit.instance];
  const bool is_moved = !instance.world_from_object.is_identity();
  SurfaceInteraction surface = is_moved ? instance.shape->surface(to_object(instance, ray), hit)
                                        : instance.shape->surface(ray, hit);
  take_to_world(instance.world_from_object, instance.flip_normals, hit.instance, surface);
  return surface;
}

}  // namespace tessera
