#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/formats/crt/crt_objects.h"

namespace tessera {
namespace {

/// Carries the y axis to `axis` (unit) and the origin to `center`.
void place(const Vec3& center, const Vec3& axis, v1::Transform& out) {
  const bool along_x = std::abs(axis.x) > 0.9;
  const Vec3 z = normalize(cross(along_x ? Vec3{0, 1, 0} : Vec3{1, 0, 0}, axis));
  const Vec3 x = cross(axis, z);
  v1::Matrix& matrix = *out.add_steps()->mutable_matrix();
  for (int row = 0; row < 3; ++row)
    for (const double entry : {x[row], axis[row], z[row], center[row]}) matrix.add_rows(entry);
}

void make_sphere(CrtAttributes& in, CrtEntity& out) {
  put(in.vector("center"), out.shape.mutable_sphere()->mutable_center());
  const double radius = in.number("radius", kCrtNotNegative);
  out.shape.mutable_sphere()->set_radius(radius);
  if (radius == 0) out.kind = CrtEntity::Kind::empty;
}

void make_box(CrtAttributes& in, CrtEntity& out) {
  const Vec3 a = in.vector("cornerA"), b = in.vector("cornerB");
  Vec3 low, high;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(a[axis], b[axis]);
    high[axis] = std::max(a[axis], b[axis]);
  }
  put(low, out.shape.mutable_box()->mutable_min());
  put(high, out.shape.mutable_box()->mutable_max());
}

void make_plane(CrtAttributes& in, CrtEntity& out) {
  const Vec3 normal = in.direction("normal");
  put(normal, out.shape.mutable_plane()->mutable_normal());
  out.shape.mutable_plane()->set_offset(dot(normal, in.vector("position")));
  out.one_sided = true;
}

void make_half_plane(CrtAttributes& in, CrtEntity& out) {
  v1::HalfPlane& half = *out.shape.mutable_half_plane();
  put(in.direction("normal"), half.mutable_normal());
  put(in.vector("position"), half.mutable_point());
  put(in.direction("edge"), half.mutable_edge_normal());
}

void make_disc(CrtAttributes& in, CrtEntity& out) {
  v1::Disc& disc = *out.shape.mutable_disc();
  put(in.vector("center"), disc.mutable_center());
  put(in.direction("normal", Vec3{0, 1, 0}), disc.mutable_normal());
  const double radius = in.number("radius", kCrtPositive);
  disc.set_radius(radius);
  disc.set_inner_radius(in.number("hole", {.min = 0, .max = radius, .below_max = true}, 0));
}

void make_triangle(CrtAttributes& in, CrtEntity& out) {
  v1::TriangleMesh& mesh = *out.shape.mutable_mesh();
  for (const char* corner : {"a", "b", "c"}) {
    const Vec3 p = in.vector(corner);
    for (const double coordinate : {p.x, p.y, p.z}) {
      const auto value = static_cast<float>(coordinate);
      if (!std::isfinite(value))
        in.fail(in.where(), "a corner that is too far off", "a nearer one");
      mesh.add_inline_positions(value);
    }
  }
  for (const uint32_t index : {0u, 1u, 2u}) mesh.add_inline_triangles(index);
}

/// From the middle of the base to the tip or the middle of the lid.
double place_along(CrtAttributes& in, CrtEntity& out) {
  const Vec3 base = in.vector("base"), top = in.vector("top");
  const double height = length(top - base);
  if (in.has("base") && in.has("top") && !(height > 0 && std::isfinite(height)))
    in.fail(in.where(), "base and top are one point", "two different points");
  if (height > 0) place((base + top) * 0.5, (top - base) / height, out.placement);
  return height;
}

void make_cylinder(CrtAttributes& in, CrtEntity& out) {
  v1::Cylinder& cylinder = *out.shape.mutable_cylinder();
  cylinder.set_height(place_along(in, out));
  cylinder.set_radius(in.number("radius", kCrtPositive));
  const bool open = in.boolean("open");
  cylinder.set_open_top(open);
  cylinder.set_open_bottom(open);
}

void make_cone(CrtAttributes& in, CrtEntity& out) {
  v1::Cone& cone = *out.shape.mutable_cone();
  cone.set_height(place_along(in, out));
  cone.set_radius(in.number("radius", kCrtPositive));
  cone.set_top_radius(in.number("topradius", kCrtNotNegative, 0));
  cone.set_open_bottom(in.boolean("open"));
}

void make_torus(CrtAttributes& in, CrtEntity& out) {
  v1::Torus& torus = *out.shape.mutable_torus();
  place(in.vector("center"), in.direction("normal", Vec3{0, 1, 0}), out.placement);
  torus.set_major_radius(in.number("radius", kCrtPositive));
  torus.set_minor_radius(in.number("thickness", kCrtPositive));
}

void make_mesh(CrtAttributes& in, CrtEntity& out) {
  out.kind = CrtEntity::Kind::include;
  const std::string file = in.text("file", "");
  if (file.empty()) in.fail(in.where(), "Mesh without 'file'", "file -> \"model.obj\"");
  out.include.set_file(file);
  out.include.set_geometry_only(true);
}

using Maker = void (*)(CrtAttributes&, CrtEntity&);

Maker maker_of(std::string_view name) {
  if (name == "Sphere") return make_sphere;
  if (name == "Box") return make_box;
  if (name == "Plane") return make_plane;
  if (name == "HalfPlane") return make_half_plane;
  if (name == "Disc") return make_disc;
  if (name == "Triangle") return make_triangle;
  if (name == "Cylinder") return make_cylinder;
  if (name == "Cone") return make_cone;
  if (name == "Torus") return make_torus;
  return make_mesh;
}

}  // namespace

CrtValue make_crt_shape(std::string_view name, CrtAttributes& in, CrtHeap& heap) {
  CrtEntity made;
  made.span = in.where();
  maker_of(name)(in, made);
  // A model from a file may bring its own.
  const bool needs_material = made.kind != CrtEntity::Kind::include;
  made.material = in.thing<CrtMaterial>("material", "Material { ... }", needs_material);
  if (!in.finish()) return CrtFailed{};
  return heap.add(std::move(made), in.where());
}

}  // namespace tessera
