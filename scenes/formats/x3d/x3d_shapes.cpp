#include <fmt/format.h>

#include <algorithm>

#include "scenes/formats/x3d/x3d_steps.h"
#include "scenes/formats/x3d/x3d_translator.h"
#include "scenes/import/to_affine.h"

namespace tessera {
namespace {

constexpr const char* kLeftOut = "the shape is left out";

/// A length above 0; where the file's is none, 0.
double positive(const X3dValues& values, const X3dNode& node, const char* name, double otherwise) {
  const double value = values.number(node, name, otherwise);
  if (value > 0) return value;
  values.repair(node, name, "a length above 0", kLeftOut);
  return 0;
}

// Each false where a length is none, so that nothing is left of the shape.

bool set_sphere(const X3dNode& node, const X3dValues& values, v1::Sphere& sphere) {
  sphere.set_radius(positive(values, node, "radius", 1));
  return sphere.radius() > 0;
}

bool set_box(const X3dNode& node, const X3dValues& values, v1::Box& box) {
  const Vec3 size = values.vec3(node, "size", {2, 2, 2});
  put_vec3(size * -0.5, box.mutable_min());
  put_vec3(size * 0.5, box.mutable_max());
  if (size.x > 0 && size.y > 0 && size.z > 0) return true;
  values.repair(node, "size", "lengths above 0", kLeftOut);
  return false;
}

bool set_cylinder(const X3dNode& node, const X3dValues& values, v1::Cylinder& cylinder) {
  cylinder.set_radius(positive(values, node, "radius", 1));
  cylinder.set_height(positive(values, node, "height", 2));
  cylinder.set_open_side(!values.boolean(node, "side", true));
  cylinder.set_open_top(!values.boolean(node, "top", true));
  cylinder.set_open_bottom(!values.boolean(node, "bottom", true));
  return cylinder.radius() > 0 && cylinder.height() > 0;
}

bool set_cone(const X3dNode& node, const X3dValues& values, v1::Cone& cone) {
  cone.set_radius(positive(values, node, "bottomRadius", 1));
  cone.set_height(positive(values, node, "height", 2));
  cone.set_open_side(!values.boolean(node, "side", true));
  cone.set_open_bottom(!values.boolean(node, "bottom", true));
  return cone.radius() > 0 && cone.height() > 0;
}

bool set_rectangle(const X3dNode& node, const X3dValues& values, v1::Rectangle& rectangle) {
  auto size = values.exactly(node, "size", 2);
  if (size.empty()) size = {2, 2};
  if (!(size[0] > 0 && size[1] > 0)) {
    values.repair(node, "size", "lengths above 0", kLeftOut);
    return false;
  }
  put_vec3({-size[0] / 2, -size[1] / 2, 0}, rectangle.mutable_corner());
  put_vec3({size[0], 0, 0}, rectangle.mutable_edge_u());
  put_vec3({0, size[1], 0}, rectangle.mutable_edge_v());
  return true;
}

bool set_disc(const X3dNode& node, const X3dValues& values, v1::Disc& disc) {
  disc.set_radius(positive(values, node, "outerRadius", 1));
  if (disc.radius() == 0) return false;
  const double inner = values.number(node, "innerRadius", 0);
  const bool is_empty = inner >= disc.radius();
  if (is_empty || inner < 0)
    values.repair(node, "innerRadius", "0 or more, and less than outerRadius",
                  is_empty ? kLeftOut : "0 is taken");
  disc.set_inner_radius(std::max(0., inner));
  return !is_empty;
}

bool is_textured(const X3dNode* appearance) {
  if (!appearance) return false;
  if (appearance->child("texture")) return true;
  for (const char* side : {"material", "backMaterial"})
    if (const X3dNode* material = appearance->child(side))
      for (const X3dNode::Child& child : material->children)
        if (child.container.ends_with("Texture")) return true;
  return false;
}

}  // namespace

/// What LineProperties multiply its width by is 1 at least, the narrowest line (12.4.3).
Pen X3dTranslator::pen(const X3dNode* line_properties, const v1::Transform& path) {
  double scale = 1;
  if (line_properties && values_.boolean(*line_properties, "applied", true)) {
    scale = std::max(1., values_.number(*line_properties, "linewidthScaleFactor", 0));
    if (values_.integer(*line_properties, "linetype", 1) != 1)
      values_.warn(line_properties->field("linetype")->offset,
                   "lines of any linetype are drawn solid");
  }
  return Pen::for_view(build_.view, to_affine(path), build_.framed_extent, scale);
}

const X3dMesh& X3dTranslator::mesh(const X3dNode& geometry, const MeshLook& look,
                                   const v1::Transform& path) {
  const auto key = std::make_pair(&geometry, look);
  const auto known = meshes_.find(key);
  if (known != meshes_.end()) return known->second;
  X3dMeshOptions options{.linear = build_.options.x3d_color == ReadOptions::Color::linear,
                         .weld = build_.options.x3d_weld,
                         .textured = look.textured};
  if (is_x3d_lines(geometry.type)) options.pen = pen(look.line_properties, path);
  return meshes_.emplace(key, build_x3d_mesh(geometry, values_, options, out_.blobs)).first->second;
}

bool X3dTranslator::set_geometry(const X3dNode& geometry, const MeshLook& look,
                                 const v1::Transform& path, v1::Shape& shape) {
  const std::string& type = geometry.type;
  if (is_x3d_mesh(type)) {
    const X3dMesh& made = mesh(geometry, look, path);
    if (made.empty) {
      values_.warn(geometry.offset, fmt::format("{} without a face is left out", type));
      return false;
    }
    *shape.mutable_mesh() = made.mesh;
    return true;
  }
  if (type == "Sphere") return set_sphere(geometry, values_, *shape.mutable_sphere());
  if (type == "Box") return set_box(geometry, values_, *shape.mutable_box());
  if (type == "Cylinder") return set_cylinder(geometry, values_, *shape.mutable_cylinder());
  if (type == "Cone") return set_cone(geometry, values_, *shape.mutable_cone());
  if (type == "Rectangle2D") return set_rectangle(geometry, values_, *shape.mutable_rectangle());
  if (type == "Disk2D") return set_disc(geometry, values_, *shape.mutable_disc());
  return false;  // listed among what is ignored, or as unknown
}

void X3dTranslator::add_shape(const X3dNode& node, const v1::Transform& path, v1::Node& out) {
  const X3dNode* geometry = node.child("geometry");
  if (!geometry) return;
  Look look{.appearance = node.child("appearance")};
  const std::string& type = geometry->type;
  look.lines = is_x3d_lines(type);
  MeshLook mesh_look{.textured = is_textured(look.appearance)};
  if (look.lines && look.appearance && type != "PointSet")
    mesh_look.line_properties = look.appearance->child("lineProperties");
  v1::Shape shape;
  if (!set_geometry(*geometry, mesh_look, path, shape)) return;
  shape.set_name(geometry->def);
  const bool flat = type == "Rectangle2D" || type == "Disk2D" || type == "Text";
  // What has no breadth hides no light. shadowCaster is an extension of older files.
  const bool casts = !look.lines && values_.boolean(node, "castShadow", true) &&
                     (!look.appearance || values_.boolean(*look.appearance, "shadowCaster", true));
  if (!casts) out.set_casts_no_shadow(true);
  look.two_sided =
      look.lines || build_.options.two_sided || !values_.boolean(*geometry, "solid", !flat);
  if (shape.has_mesh()) {
    const X3dMesh& made = mesh(*geometry, mesh_look, path);
    look.colors = made.has_colors;
    look.color_alpha = made.has_color_alpha;
  }
  if (mesh_look.textured) look.coordinates = coordinates_of(*geometry, values_);
  shape.add_materials(material(look));
  *out.mutable_shape() = std::move(shape);
}

}  // namespace tessera
