#include "renderer/accel/linear_scan.h"

#include <algorithm>

#include "renderer/accel/tree_boxes.h"
#include "renderer/shapes/triangle.h"

namespace tessera {

MeshLinearScan::MeshLinearScan(std::shared_ptr<const TriangleMesh> mesh)
    : mesh_(std::move(mesh)), bounds_(mesh_->bounds()) {}

bool MeshLinearScan::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  const TriangleRay prepared(ray);
  if (!prepared.valid()) return false;
  counters.primitive_tests += mesh_->triangles.size();
  bool found = false;
  for (size_t i = 0; i < mesh_->triangles.size(); ++i) {
    const auto [a, b, c] = mesh_->corners(i);
    TriangleHit candidate;
    if (!intersect_triangle(prepared, a, b, c, candidate)) continue;
    const auto primitive = static_cast<uint32_t>(i);
    if (candidate.t > hit.t || (candidate.t == hit.t && primitive >= hit.primitive)) continue;
    hit = {candidate.t, candidate.u, candidate.v, hit.instance, primitive};
    found = true;
  }
  return found;
}

bool MeshLinearScan::any_hit(const Ray& ray, TraversalCounters& counters) const {
  const TriangleRay prepared(ray);
  if (!prepared.valid()) return false;
  for (size_t i = 0; i < mesh_->triangles.size(); ++i) {
    ++counters.primitive_tests;
    const auto [a, b, c] = mesh_->corners(i);
    TriangleHit candidate;
    if (intersect_triangle(prepared, a, b, c, candidate)) return true;
  }
  return false;
}

void MeshLinearScan::all_hits(const Ray& ray, std::vector<Hit>& hits,
                              TraversalCounters& counters) const {
  const TriangleRay prepared(ray);
  if (!prepared.valid()) return;
  counters.primitive_tests += mesh_->triangles.size();
  for (uint32_t i = 0; i < mesh_->triangles.size(); ++i) {
    const auto [a, b, c] = mesh_->corners(i);
    TriangleHit at;
    if (intersect_triangle(prepared, a, b, c, at)) hits.push_back({at.t, at.u, at.v, 0, i});
  }
}

AcceleratorStatistics MeshLinearScan::statistics() const {
  return {.primitives = mesh_->triangles.size(), .references = mesh_->triangles.size()};
}

InstanceLinearScan::InstanceLinearScan(std::vector<Instance> instances)
    : instances_(std::move(instances)), takes_batches_(any_takes_batches(instances_)) {
  Bounds3 bounded;
  for (const Instance& instance : instances_) {
    const Bounds3 bounds = bounds_of(instance);
    bounds_.extend(bounds);
    if (can_be_held(instance, bounds)) bounded.extend(bounds);
  }
  if (!bounded.empty()) bounded_extent_ = max_component(bounded.max - bounded.min);
}

bool InstanceLinearScan::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  if (!can_hit(ray)) return false;
  bool found = false;
  uint32_t number = 0;
  for (const Instance& instance : instances_)
    if (closest_hit_of(instance, number++, ray, hit, counters)) found = true;
  return found;
}

bool InstanceLinearScan::any_hit(const Ray& ray, TraversalCounters& counters) const {
  if (!can_hit(ray)) return false;
  for (const Instance& instance : instances_)
    if (any_hit_of(instance, ray, counters)) return true;
  return false;
}

bool InstanceLinearScan::takes_batch(const RayBatch& rays) const {
  if (!takes_batches_ || !are_coherent(rays, bounded_extent_)) return false;
  for (size_t i = 0; i < rays.count; ++i)
    if (!can_hit(rays.ray(i))) return false;
  return true;
}

void InstanceLinearScan::closest_hits(const RayBatch& rays, std::span<Hit> hits,
                                      TraversalCounters& counters) const {
  if (!takes_batch(rays)) return Accelerator::closest_hits(rays, hits, counters);
  Uninitialized<Ray, RayBatch::kMost> room;
  const std::span<const Ray> all = rays_of(rays, room);
  std::ranges::fill(hits, Hit{});
  uint32_t number = 0;
  for (const Instance& instance : instances_)
    closest_hits_of(instance, number++, all, hits, counters);
}

uint64_t InstanceLinearScan::any_hits(const RayBatch& rays, TraversalCounters& counters) const {
  if (!takes_batch(rays)) return Accelerator::any_hits(rays, counters);
  Uninitialized<Ray, RayBatch::kMost> room;
  const std::span<const Ray> all = rays_of(rays, room);
  uint64_t hit = 0;
  for (const Instance& instance : instances_) hit |= any_hits_of(instance, all, counters);
  return hit;
}

void InstanceLinearScan::all_hits(const Ray& ray, std::vector<Hit>& hits,
                                  TraversalCounters& counters) const {
  if (!can_hit(ray)) return;
  for (uint32_t i = 0; i < instances_.size(); ++i)
    all_hits_of(instances_[i], i, ray, hits, counters);
}

AcceleratorStatistics InstanceLinearScan::statistics() const {
  return {.primitives = instances_.size(),
          .references = instances_.size(),
          .bytes = instances_.size() * sizeof(Instance)};
}

}  // namespace tessera
