#include "renderer/accel/instance.h"

#include <algorithm>
#include <limits>

#include "base/uninitialized.h"
#include "renderer/accel/mesh_shape.h"
#include "renderer/accel/ray_batch.h"
#include "renderer/shapes/mesh_boundary.h"
#include "renderer/shapes/solid.h"

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

/// The rays in the frame of the instance's shape, in `room` unless they are the same there.
std::span<const Ray> to_object(const Instance& instance, std::span<const Ray> rays,
                               Uninitialized<Ray, RayBatch::kMost>& room) {
  const Cull cull = seen_cull(instance);
  if (cull == Cull::none && instance.world_from_object.is_identity()) return rays;
  for (size_t i = 0; i < rays.size(); ++i) room[i] = to_object(instance, rays[i], cull);
  return {room.data(), rays.size()};
}

}  // namespace

void closest_hits_of(const Instance& instance, uint32_t number, std::span<const Ray> rays,
                     std::span<Hit> hits, TraversalCounters& counters) {
  Uninitialized<Ray, RayBatch::kMost> room;
  // As closest_hit_of_any() lends one; `instance`, which shapes leave, keeps what was lent.
  Uninitialized<Hit, RayBatch::kMost> lent;
  for (size_t i = 0; i < hits.size(); ++i) {
    lent[i] = hits[i];
    if (number < hits[i].instance) lent[i].primitive = std::numeric_limits<uint32_t>::max();
    if (number > hits[i].instance) lent[i].primitive = 0;
    lent[i].instance = lent[i].primitive;
  }
  instance.shape->closest_hits(to_object(instance, rays, room), {lent.data(), hits.size()},
                               counters);
  for (size_t i = 0; i < hits.size(); ++i) {
    const uint32_t before = lent[i].instance;
    if (lent[i].t == hits[i].t && lent[i].primitive == before) continue;
    hits[i] = lent[i];
    hits[i].instance = number;
  }
}

uint64_t any_hits_of(const Instance& instance, std::span<const Ray> rays,
                     TraversalCounters& counters) {
  if (!instance.casts_shadow) return 0;
  Uninitialized<Ray, RayBatch::kMost> room;
  return instance.shape->any_hits(to_object(instance, rays, room), counters);
}

bool any_takes_batches(std::span<const Instance> instances) {
  return std::ranges::any_of(
      instances, [](const Instance& instance) { return instance.shape->takes_batches(); });
}

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

void all_hits_of(const Instance& instance, uint32_t number, const Ray& ray, std::vector<Hit>& hits,
                 TraversalCounters& counters) {
  const size_t before = hits.size();
  query_local(instance, ray, [&](const Ray& local) {
    instance.shape->all_hits(local, hits, counters);
    return true;
  });
  for (size_t i = before; i < hits.size(); ++i) hits[i].instance = number;
}

int crossing_number_of(const Instance& instance, const Ray& ray, std::span<const Hit> hits) {
  const int number = instance.shape->crossing_number(to_object(instance, ray, Cull::none), hits);
  return instance.flip_normals ? -number : number;
}

bool is_closed(const Shape& shape) {
  if (const auto* solid = dynamic_cast<const Solid*>(&shape)) return solid->closed();
  const auto* mesh = dynamic_cast<const MeshShape*>(&shape);
  return mesh != nullptr && is_closed(mesh->mesh());
}

bool holds_start_of(const Instance& instance, const Ray& ray, std::span<const Hit> hits) {
  const Ray local = to_object(instance, ray, Cull::none);
  const auto* solid = dynamic_cast<const Solid*>(instance.shape.get());
  return solid ? solid->holds_start(local) : instance.shape->crossing_number(local, hits) != 0;
}

bool goes_around_start_of(const Instance& instance, const MeshBoundary& boundary, const Ray& ray,
                          std::span<const Hit> hits) {
  const Ray local = to_object(instance, ray, Cull::none);
  return boundary.goes_around(local, instance.shape->crossing_number(local, hits));
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
