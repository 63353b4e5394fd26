#include "renderer/scene/read_shape.h"

#include <fmt/format.h>

#include <algorithm>

#include "renderer/accel/make_accelerator.h"
#include "renderer/scene/read_mesh.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"

namespace tessera {

namespace {

BuiltShape build_mesh(const Where& where, const v1::Shape& shape, const ShapeSource& source) {
  auto mesh = std::make_shared<TriangleMesh>(
      read_mesh(where, shape.mesh(), source.blobs, static_cast<size_t>(shape.materials_size())));
  BuiltShape built;
  built.triangles_dropped = drop_degenerate(*mesh).total();
  built.triangles = mesh->triangles.size();
  built.has_clear_vertices = std::any_of(mesh->colors.begin(), mesh->colors.end(),
                                         [](const Float4& c) { return c.w < 1; });
  if (mesh->triangles.empty()) return built;
  built.shape = make_mesh_shape(std::move(mesh), source.accelerator, source.threads);
  return built;
}

std::shared_ptr<const Shape> build_sphere(const Where& where, const v1::Sphere& in) {
  const Point3 center = checked_point(where, "sphere.center", in.center());
  const double radius =
      in.has_radius() ? checked(where, "sphere.radius", in.radius(), kPositive) : 1;
  return std::make_shared<Sphere>(center, radius);
}

std::shared_ptr<const Shape> build_plane(const Where& where, const v1::Plane& in) {
  const Vec3 normal =
      in.has_normal() ? checked_direction(where, "plane.normal", in.normal()) : Vec3{0, 1, 0};
  return std::make_shared<Plane>(normal, checked(where, "plane.offset", in.offset()));
}

std::shared_ptr<const Shape> build_box(const Where& where, const v1::Box& in) {
  const Point3 min = in.has_min() ? checked_point(where, "box.min", in.min()) : Point3{-1, -1, -1};
  const Point3 max = in.has_max() ? checked_point(where, "box.max", in.max()) : Point3{1, 1, 1};
  for (int axis = 0; axis < 3; ++axis) {
    if (min[axis] > max[axis]) {
      fail_value(where, "box.min", fmt::format("{} on axis {}", min[axis], axis),
                 fmt::format("at most box.max, {}", max[axis]));
    }
  }
  return std::make_shared<Box>(Bounds3{min, max});
}

}  // namespace

BuiltShape read_shape(const Where& where, const v1::Shape& shape, const ShapeSource& source) {
  switch (shape.kind_case()) {
    case v1::Shape::kMesh:
      return build_mesh(where, shape, source);
    case v1::Shape::kSphere:
      return {build_sphere(where, shape.sphere())};
    case v1::Shape::kPlane:
      return {build_plane(where, shape.plane())};
    case v1::Shape::kBox:
      return {build_box(where, shape.box())};
    case v1::Shape::kHalfPlane:
      fail_unsupported(where, "a half_plane");
    case v1::Shape::kDisc:
      fail_unsupported(where, "a disc");
    case v1::Shape::kRectangle:
      fail_unsupported(where, "a rectangle");
    case v1::Shape::kPolygon:
      fail_unsupported(where, "a polygon");
    case v1::Shape::kCylinder:
      fail_unsupported(where, "a cylinder");
    case v1::Shape::kCone:
      fail_unsupported(where, "a cone");
    case v1::Shape::kTorus:
      fail_unsupported(where, "a torus");
    case v1::Shape::kCsg:
      fail_unsupported(where, "csg");
    case v1::Shape::KIND_NOT_SET:
      break;
  }
  fail_value(where, "its kind", "missing", "mesh, sphere, plane, box ...");
}

}  // namespace tessera
