#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "renderer/math/transform.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/shape.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/surface_interaction.h"

namespace tessera {

class MeshBoundary;

/// A shape at a place in the world. Many instances may share one shape. The front of a surface is
/// what its shape calls so, under mirroring transforms too.
struct Instance {
  std::shared_ptr<const Shape> shape;
  Transform world_from_object{};
  bool casts_shadow = true;   ///< else any_hit passes through it
  Cull cull = Cull::none;     ///< sides that no ray sees, besides those that the ray culls
  bool flip_normals = false;  ///< front and back, and the normals, change places
};

/// closest_hit_of() and any_hit_of() for any shape, any transform and any ray.
bool closest_hit_of_any(const Instance& instance, uint32_t number, const Ray& ray, Hit& hit,
                        TraversalCounters& counters);
bool any_hit_of_any(const Instance& instance, const Ray& ray, TraversalCounters& counters);

/// Whether in_place() can answer.
inline bool is_simple(const Instance& instance, const Ray& ray) {
  return instance.shape->kind() != ShapeKind::other && instance.world_from_object.is_identity() &&
         ray.cull == Cull::none;
}
/// The sides of its shape that no ray sees.
inline Cull seen_cull(const Instance& instance) {
  const Cull cull = instance.cull;
  if (!instance.flip_normals || cull == Cull::none) return cull;
  return cull == Cull::back ? Cull::front : Cull::back;
}
/// Where the ray meets, at t <= `limit`, a shape that is tested where it stands and has but one
/// primitive.
inline bool in_place(const Instance& instance, const Ray& ray, double limit, double& t,
                     TraversalCounters& counters) {
  ++counters.primitive_tests;
  const Cull cull = seen_cull(instance);
  return instance.shape->kind() == ShapeKind::plane
             ? static_cast<const Plane&>(*instance.shape).intersect(ray, cull, limit, t)
             : static_cast<const Sphere&>(*instance.shape).intersect(ray, cull, limit, t);
}

/// Takes the hit of instance `number`, of one primitive, at t <= hit.t, if it counts. Of hits at
/// equal t the smaller instance does, whatever its primitive.
inline bool take_if_closer(double t, uint32_t number, Hit& hit) {
  if (t == hit.t && (number > hit.instance || (number == hit.instance && hit.primitive == 0))) {
    return false;
  }
  hit = {t, 0, 0, number, 0};
  return true;
}
/// As Shape::closest_hit for instance `number` and a ray in world space; sets hit.instance.
inline bool closest_hit_of(const Instance& instance, uint32_t number, const Ray& ray, Hit& hit,
                           TraversalCounters& counters) {
  if (!is_simple(instance, ray)) return closest_hit_of_any(instance, number, ray, hit, counters);
  double t;
  return in_place(instance, ray, hit.t, t, counters) && take_if_closer(t, number, hit);
}
/// As Shape::any_hit; never for an instance that casts no shadow.
inline bool any_hit_of(const Instance& instance, const Ray& ray, TraversalCounters& counters) {
  if (!is_simple(instance, ray)) return any_hit_of_any(instance, ray, counters);
  double t;
  return instance.casts_shadow && in_place(instance, ray, ray.t_max, t, counters);
}
/// The two above for at most RayBatch::kMost rays that cull nothing, by Shape::closest_hits() and
/// any_hits(): a bit each.
void closest_hits_of(const Instance& instance, uint32_t number, std::span<const Ray> rays,
                     std::span<Hit> hits, TraversalCounters& counters);
uint64_t any_hits_of(const Instance& instance, std::span<const Ray> rays,
                     TraversalCounters& counters);
/// Whether rays that go much the same way meet some of them faster together.
bool any_takes_batches(std::span<const Instance> instances);
/// As Shape::all_hits for instance `number` and a ray in world space; sets Hit::instance.
void all_hits_of(const Instance& instance, uint32_t number, const Ray& ray, std::vector<Hit>& hits,
                 TraversalCounters& counters);
/// As Shape::crossing_number for the hits of this instance and a ray in world space.
int crossing_number_of(const Instance& instance, const Ray& ray, std::span<const Hit> hits);
/// Whether a world-space ray starts inside the instance's shape; `hits` are all hits with it.
/// Only what is_closed() has an inside.
bool holds_start_of(const Instance& instance, const Ray& ray, std::span<const Hit> hits);
/// As MeshBoundary::goes_around for an open mesh and where a world-space ray starts. `hits`: all of
/// the ray with the instance.
bool goes_around_start_of(const Instance& instance, const MeshBoundary& boundary, const Ray& ray,
                          std::span<const Hit> hits);
/// Whether the shape has an inside: a solid with no part left out, or a closed mesh. Takes a
/// sort of a mesh's edges.
bool is_closed(const Shape& shape);
/// In world space. Endless for an endless shape.
Bounds3 bounds_of(const Instance& instance);

/// What lies at a hit that an accelerator over `instances` reported for this world-space ray.
SurfaceInteraction surface_at(std::span<const Instance> instances, const Ray& ray, const Hit& hit);

}  // namespace tessera
