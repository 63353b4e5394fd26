#include "renderer/accel/linear_scan.h"

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
    : instances_(std::move(instances)) {
  for (const Instance& instance : instances_) bounds_.extend(bounds_of(instance));
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
