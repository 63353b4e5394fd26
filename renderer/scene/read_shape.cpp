#include "renderer/scene/read_shape.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/scene/read_mesh.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/closed_mesh.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/csg_shape.h"
#include "renderer/shapes/disc.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/half_plane.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/torus.h"

namespace tessera {

namespace {

/// Puts the place before the message of an error that has none yet.
[[noreturn]] void rethrow_with(const std::string& path, const Error& error) {
  const std::string message = error.what();
  throw Error(error.code(), message.starts_with(path) ? message : path + ": " + message);
}

/// Of all that its triangles come from: blobs are named in it by their digests.
Digest key_of(const v1::TriangleMesh& mesh, AcceleratorKind kind) {
  return Digest::of(mesh.SerializeAsString() + static_cast<char>(kind));
}

/// A mesh with what the picture depends on, and what was found when it was read.
struct TakenMesh {
  TriangleMesh mesh;
  BuiltShape found;  ///< without the shape and the mesh
};

/// Of all that take_mesh() reads of a shape.
Digest key_of_taken(const v1::Shape& shape, const KeptAttributes& keep) {
  std::string key = "taken mesh " + shape.mesh().SerializeAsString();
  for (const bool kept : {keep.normals, keep.uvs, keep.second_uvs, keep.tangents, keep.colors})
    key += kept ? '1' : '0';
  return Digest::of(key + std::to_string(shape.materials_size()));
}

TakenMesh read_taken(const Where& where, const v1::Shape& shape, const ShapeSource& source) {
  TakenMesh taken{read_mesh(where, shape.mesh(), source.blobs,
                            static_cast<size_t>(shape.materials_size()), source.threads),
                  {}};
  TriangleMesh* const mesh = &taken.mesh;
  BuiltShape& built = taken.found;
  built.has_clear_vertices = std::any_of(mesh->colors.begin(), mesh->colors.end(),
                                         [](const Float4& c) { return c.w < 1; });
  const bool all_opaque = std::all_of(mesh->colors.begin(), mesh->colors.end(),
                                      [](const Float4& c) { return c.w == 1; });
  const auto drop = [&](auto& values) {
    if (values.empty()) return;
    built.bytes_dropped += values.size() * sizeof(values[0]);
    ++built.attributes_dropped;
    values = {};
  };
  if (!source.keep.normals) drop(mesh->normals);
  if (!source.keep.uvs) drop(mesh->uvs);
  if (!source.keep.second_uvs) drop(mesh->second_uvs);
  if (!source.keep.tangents) drop(mesh->tangents);
  if (!source.keep.colors && all_opaque) drop(mesh->colors);
  built.bytes = mesh->bytes();
  built.triangles_dropped = drop_degenerate(*mesh, source.threads).total();
  built.triangles = mesh->triangles.size();
  return taken;
}

/// The mesh; what became of it is noted in `built`. One of blobs is read and checked once for all
/// frames that live at a time: that of an animation's next frame takes no time.
std::shared_ptr<const TriangleMesh> take_mesh(const Where& where, const v1::Shape& shape,
                                              const ShapeSource& source, BuiltShape& built) {
  const v1::BlobRef& triangles = shape.mesh().triangles();
  WeakCache* const live = triangles.size() >= kTrianglesWorthSharing * sizeof(TriangleIndices)
                              ? source.sharing.live
                              : nullptr;
  const Digest key = live ? key_of_taken(shape, source.keep) : Digest{};
  std::shared_ptr<const TakenMesh> taken = live ? live->find<TakenMesh>(key) : nullptr;
  if (!taken) {
    taken = std::make_shared<const TakenMesh>(read_taken(where, shape, source));
    if (live) live->note(key, taken);
  }
  built = taken->found;
  return {taken, &taken->mesh};
}

BuiltShape build_mesh(const Where& where, const v1::Shape& shape, const ShapeSource& source) {
  BuiltShape built;
  auto mesh = take_mesh(where, shape, source, built);
  if (mesh->triangles.empty()) return built;
  built.mesh = mesh;
  built.is_deferred = source.deferred && source.accelerator != AcceleratorKind::embree;
  const bool shares = source.sharing.arena != nullptr || source.sharing.live != nullptr;
  const SharedTree shared{source.sharing,
                          shares ? key_of(shape.mesh(), source.accelerator) : Digest{}};
  built.shape = built.is_deferred
                    ? make_deferred_mesh_shape(std::move(mesh), source.accelerator, source.threads,
                                               source.deferred, shared)
                    : make_mesh_shape(std::move(mesh), source.accelerator, source.threads, shared,
                                      *source.code);
  return built;
}

std::shared_ptr<const Shape> build_sphere(const Where& where, const v1::Sphere& in, bool keep_uvs) {
  const Point3 center = checked_point(where, "sphere.center", in.center());
  const double radius = in.has_radius() ? checked(where, "sphere.radius", in.radius(), kLength) : 1;
  return std::make_shared<Sphere>(center, radius, keep_uvs);
}

std::shared_ptr<const Shape> build_plane(const Where& where, const v1::Plane& in, bool keep_uvs) {
  const Vec3 normal =
      in.has_normal() ? checked_direction(where, "plane.normal", in.normal()) : Vec3{0, 1, 0};
  return std::make_shared<Plane>(normal, checked(where, "plane.offset", in.offset()), keep_uvs);
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

std::shared_ptr<const Shape> build_half_plane(const Where& where, const v1::HalfPlane& in) {
  return std::make_shared<HalfPlane>(
      checked_point(where, "half_plane.point", in.point()),
      checked_direction(where, "half_plane.normal", in.normal()),
      checked_direction(where, "half_plane.edge_normal", in.edge_normal()));
}

std::shared_ptr<const Shape> build_disc(const Where& where, const v1::Disc& in) {
  const Vec3 normal =
      in.has_normal() ? checked_direction(where, "disc.normal", in.normal()) : Vec3{0, 0, 1};
  const double radius = in.has_radius() ? checked(where, "disc.radius", in.radius(), kLength) : 1;
  const double inner = checked(where, "disc.inner_radius", in.inner_radius(),
                               {.min = 0, .max = radius, .below_max = true});
  return std::make_shared<Disc>(checked_point(where, "disc.center", in.center()), normal, radius,
                                inner);
}

std::shared_ptr<const Shape> build_rectangle(const Where& where, const v1::Rectangle& in) {
  return std::make_shared<Rectangle>(checked_point(where, "rectangle.corner", in.corner()),
                                     checked(where, "rectangle.edge_u", in.edge_u()),
                                     checked(where, "rectangle.edge_v", in.edge_v()));
}

std::shared_ptr<const Shape> build_polygon(const Where& where, const v1::Polygon& in) {
  std::vector<Point3> points;
  for (const v1::Vec3& point : in.points()) {
    points.push_back(checked_point(where, "polygon.points", point));
  }
  return std::make_shared<ConvexPolygon>(std::move(points));
}

std::shared_ptr<const Shape> build_cylinder(const Where& where, const v1::Cylinder& in) {
  const double radius =
      in.has_radius() ? checked(where, "cylinder.radius", in.radius(), kLength) : 1;
  const double height =
      in.has_height() ? checked(where, "cylinder.height", in.height(), kLength) : 2;
  return std::make_shared<Cylinder>(radius, height,
                                    OpenParts{in.open_side(), in.open_top(), in.open_bottom()});
}

std::shared_ptr<const Shape> build_cone(const Where& where, const v1::Cone& in) {
  const double radius = in.has_radius() ? checked(where, "cone.radius", in.radius(), kLength) : 1;
  const double height = in.has_height() ? checked(where, "cone.height", in.height(), kLength) : 2;
  const double top = checked(where, "cone.top_radius", in.top_radius(), kNotNegative);
  return std::make_shared<Cone>(radius, height, top,
                                OpenParts{in.open_side(), false, in.open_bottom()});
}

std::shared_ptr<const Shape> build_torus(const Where& where, const v1::Torus& in) {
  const double major =
      in.has_major_radius() ? checked(where, "torus.major_radius", in.major_radius(), kLength) : 1;
  const double minor = in.has_minor_radius()
                           ? checked(where, "torus.minor_radius", in.minor_radius(), kLength)
                           : 0.25;
  return std::make_shared<Torus>(major, minor);
}

/// A shape of one primitive; what its constructor refuses is told with its place.
std::shared_ptr<const Shape> build_simple(const Where& where, const v1::Shape& shape,
                                          bool keep_uvs) {
  try {
    switch (shape.kind_case()) {
      case v1::Shape::kSphere:
        return build_sphere(where, shape.sphere(), keep_uvs);
      case v1::Shape::kPlane:
        return build_plane(where, shape.plane(), keep_uvs);
      case v1::Shape::kBox:
        return build_box(where, shape.box());
      case v1::Shape::kHalfPlane:
        return build_half_plane(where, shape.half_plane());
      case v1::Shape::kDisc:
        return build_disc(where, shape.disc());
      case v1::Shape::kRectangle:
        return build_rectangle(where, shape.rectangle());
      case v1::Shape::kPolygon:
        return build_polygon(where, shape.polygon());
      case v1::Shape::kCylinder:
        return build_cylinder(where, shape.cylinder());
      case v1::Shape::kCone:
        return build_cone(where, shape.cone());
      case v1::Shape::kTorus:
        return build_torus(where, shape.torus());
      default:
        break;
    }
  } catch (const Error& error) {
    rethrow_with(where.str(), error);
  }
  fail_value(where, "its kind", "missing", "mesh, sphere, plane, box ...");
}

/// A mesh as a solid: CSG asks for crossings, which the accelerators do not know.
BuiltShape build_solid(const Where& where, const v1::Shape& shape, const ShapeSource& source) {
  if (!shape.has_mesh()) return {build_simple(where, shape, source.keep.uvs)};
  BuiltShape built;
  built.shape = std::make_shared<ClosedMesh>(take_mesh(where, shape, source, built));
  return built;
}

}  // namespace

BuiltShape read_csg(const CsgPlan& plan, const ShapeSource& source) {
  BuiltShape whole;
  if (plan.steps.empty()) return whole;
  CsgTree tree;
  std::vector<CsgTree::Node> nodes;
  uint32_t first_material = 0;
  for (const CsgPlan::Step& step : plan.steps) {
    try {
      if (step.solid) {
        const Where where{.kind = step.path.c_str()};
        const BuiltShape built = build_solid(where, *step.solid, source);
        whole.triangles += built.triangles;
        whole.triangles_dropped += built.triangles_dropped;
        whole.bytes += built.bytes;
        whole.bytes_dropped += built.bytes_dropped;
        whole.attributes_dropped += built.attributes_dropped;
        whole.has_clear_vertices |= built.has_clear_vertices;
        nodes.push_back(tree.add(built.shape, Transform(step.csg_from_solid), first_material));
        first_material += static_cast<uint32_t>(material_count(*step.solid));
      } else {
        std::vector<CsgTree::Node> operands;
        for (const uint32_t operand : step.operands) operands.push_back(nodes[operand]);
        nodes.push_back(tree.combine(step.operation, operands));
      }
    } catch (const Error& error) {
      rethrow_with(step.path, error);
    }
  }
  whole.shape = std::make_shared<CsgShape>(tree, nodes.back());
  return whole;
}

BuiltShape read_shape(const Where& where, const v1::Shape& shape, const ShapeSource& source) {
  if (shape.has_mesh()) return build_mesh(where, shape, source);
  return {build_simple(where, shape, source.keep.uvs)};
}

}  // namespace tessera
