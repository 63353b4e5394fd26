#include "renderer/scene/outline.h"

#include <numbers>

#include "renderer/math/elementary.h"
#include "renderer/shapes/disc.h"

namespace tessera {

namespace {

constexpr int kSteps = 24;  // of half a turn: what is between two of them sticks out by .9 %
constexpr double kStep = std::numbers::pi / kSteps;

/// Adds points of a circle with two radii for axes.
void add_rim(const Point3& center, const Vec3& u, const Vec3& v, std::vector<Point3>& points) {
  for (int i = 0; i < 2 * kSteps; ++i)
    points.push_back(center + u * portable::cos(i * kStep) + v * portable::sin(i * kStep));
}

/// The same about the y axis.
void add_rim(double radius, double y, std::vector<Point3>& points) {
  add_rim({0, y, 0}, {radius, 0, 0}, {0, 0, radius}, points);
}

void add_vertices(const TriangleMesh& mesh, std::vector<Point3>& points) {
  std::vector<bool> is_used(mesh.positions.size());
  for (const TriangleIndices& triangle : mesh.triangles)
    for (const uint32_t vertex : triangle) is_used[vertex] = true;
  for (uint32_t v = 0; v < is_used.size(); ++v)
    if (is_used[v]) points.push_back(mesh.vertex(v));
}

}  // namespace

std::vector<Point3> box_corners(const Bounds3& box) {
  std::vector<Point3> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back({i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                       i & 4 ? box.max.z : box.min.z});
  return corners;
}

size_t outline_limit(const BuiltShape& built) {
  constexpr size_t kOfTorus = size_t{2 * kSteps + 1} * 2 * kSteps;
  return built.mesh ? built.mesh->positions.size() : kOfTorus;
}

std::vector<Point3> outline(const v1::Shape& description, const BuiltShape& built, bool closely) {
  if (!built.shape) return {};
  const Bounds3 box = built.shape->bounds();
  if (box.empty() || !is_finite(box.diagonal())) return {};
  if (!closely) return box_corners(box);
  const Vec3 half = box.diagonal() * .5;
  std::vector<Point3> points;
  switch (description.kind_case()) {
    case v1::Shape::kMesh:
      if (built.mesh) add_vertices(*built.mesh, points);
      return points;
    case v1::Shape::kSphere:
      for (int i = 0; i <= kSteps; ++i) {
        const double out = half.x * portable::sin(i * kStep);
        add_rim(box.center() + Vec3{0, half.y * portable::cos(i * kStep), 0}, {out, 0, 0},
                {0, 0, out}, points);
      }
      return points;
    case v1::Shape::kCylinder:
      for (const double y : {box.min.y, box.max.y}) add_rim(half.x, y, points);
      return points;
    case v1::Shape::kCone:
      add_rim(description.cone().has_radius() ? description.cone().radius() : 1, box.min.y, points);
      add_rim(description.cone().top_radius(), box.max.y, points);
      return points;
    case v1::Shape::kTorus:
      for (int i = 0; i <= 2 * kSteps; ++i)
        add_rim(half.x - half.y + half.y * portable::cos(i * kStep),
                half.y * portable::sin(i * kStep), points);
      return points;
    case v1::Shape::kDisc:
      if (const auto* disc = dynamic_cast<const Disc*>(built.shape.get()))
        add_rim(disc->center(), disc->tangent() * disc->radius(),
                cross(disc->normal(), disc->tangent()) * disc->radius(), points);
      return points;
    default:
      return box_corners(box);
  }
}

}  // namespace tessera
