#include "renderer/shapes/shape.h"

#include "renderer/shapes/outline_points.h"
#include "renderer/shapes/solid.h"
#include "renderer/shapes/surface_sampler.h"

namespace tessera {

int Shape::crossing_number(const Ray& ray, std::span<const Hit> hits) const {
  int sum = 0;
  for (const Hit& hit : hits) {
    const double along = dot(static_cast<Vec3>(surface(ray, hit).geometric_normal), ray.direction);
    sum += (along < 0 ? 1 : 0) - (along > 0 ? 1 : 0);
  }
  return sum;
}

std::unique_ptr<const SurfaceSampler> Shape::make_sampler(const Transform&, bool) const {
  return nullptr;
}

std::vector<Point3> Shape::outline() const { return box_corners(bounds()); }

int Solid::crossing_number(const Ray& ray, std::span<const Hit> hits) const {
  if (!closed()) return Shape::crossing_number(ray, hits);
  thread_local std::vector<SolidEvent> events;
  events.clear();
  crossings(ray, {}, events);
  int sum = 0;
  for (const SolidEvent& e : events)
    if (e.t > ray.t_min && e.t < ray.t_max) sum += e.entering ? 1 : -1;
  return sum;
}

bool Solid::holds_start(const Ray& ray) const {
  thread_local std::vector<SolidEvent> events;
  events.clear();
  crossings(ray, {}, events);
  int sum = 0;
  for (const SolidEvent& e : events)
    if (e.t <= 0) sum += e.entering ? 1 : -1;
  return sum > 0;
}

}  // namespace tessera
