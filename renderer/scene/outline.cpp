#include "renderer/scene/outline.h"

#include "renderer/shapes/outline_points.h"

namespace tessera {

namespace {

std::vector<Point3> used_vertices(const TriangleMesh& mesh) {
  std::vector<bool> is_used(mesh.positions.size());
  for (const TriangleIndices& triangle : mesh.triangles)
    for (const uint32_t vertex : triangle) is_used[vertex] = true;
  std::vector<Point3> points;
  for (uint32_t v = 0; v < is_used.size(); ++v)
    if (is_used[v]) points.push_back(mesh.vertex(v));
  return points;
}

}  // namespace

size_t outline_limit(const BuiltShape& built) {
  return built.mesh ? built.mesh->positions.size() : kMostOutlinePoints;
}

std::vector<Point3> outline(const BuiltShape& built, bool closely) {
  if (!built.shape) return {};
  const Bounds3 box = built.shape->bounds();
  if (box.empty() || !is_finite(box.diagonal())) return {};
  if (!closely) return box_corners(box);
  return built.mesh ? used_vertices(*built.mesh) : built.shape->outline();
}

}  // namespace tessera
