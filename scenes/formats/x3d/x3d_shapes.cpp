#include <fmt/format.h>

#include "scenes/formats/x3d/x3d_proto.h"
#include "scenes/formats/x3d/x3d_translator.h"

namespace tessera {
namespace {

double positive(const X3dValues& values, const X3dNode& node, const char* name, double otherwise) {
  const double value = values.number(node, name, otherwise);
  if (value > 0) return value;
  throw values.document().error(node.field(name)->offset,
                                fmt::format("{} {} of {}", name, value, describe(node)),
                                "a length above 0");
}

void set_box(const X3dNode& node, const X3dValues& values, v1::Box& box) {
  const Vec3 size = values.vec3(node, "size", {2, 2, 2});
  if (!(size.x > 0 && size.y > 0 && size.z > 0))
    throw values.document().error(node.field("size")->offset,
                                  fmt::format("size of {}", describe(node)), "lengths above 0");
  put_vec3(size * -0.5, box.mutable_min());
  put_vec3(size * 0.5, box.mutable_max());
}

void set_cylinder(const X3dNode& node, const X3dValues& values, v1::Cylinder& cylinder) {
  cylinder.set_radius(positive(values, node, "radius", 1));
  cylinder.set_height(positive(values, node, "height", 2));
  cylinder.set_open_side(!values.boolean(node, "side", true));
  cylinder.set_open_top(!values.boolean(node, "top", true));
  cylinder.set_open_bottom(!values.boolean(node, "bottom", true));
}

void set_cone(const X3dNode& node, const X3dValues& values, v1::Cone& cone) {
  cone.set_radius(positive(values, node, "bottomRadius", 1));
  cone.set_height(positive(values, node, "height", 2));
  cone.set_open_side(!values.boolean(node, "side", true));
  cone.set_open_bottom(!values.boolean(node, "bottom", true));
}

void set_rectangle(const X3dNode& node, const X3dValues& values, v1::Rectangle& rectangle) {
  auto size = values.numbers(node, "size", 2);
  if (size.empty()) size = {2, 2};
  if (size.size() != 2 || !(size[0] > 0 && size[1] > 0))
    throw values.document().error(node.field("size")->offset,
                                  fmt::format("size of {}", describe(node)), "two lengths above 0");
  put_vec3({-size[0] / 2, -size[1] / 2, 0}, rectangle.mutable_corner());
  put_vec3({size[0], 0, 0}, rectangle.mutable_edge_u());
  put_vec3({0, size[1], 0}, rectangle.mutable_edge_v());
}

void set_disc(const X3dNode& node, const X3dValues& values, v1::Disc& disc) {
  disc.set_radius(positive(values, node, "outerRadius", 1));
  const double inner = values.number(node, "innerRadius", 0);
  if (inner < 0 || inner >= disc.radius())
    throw values.document().error(node.field("innerRadius")->offset,
                                  fmt::format("innerRadius {}", inner),
                                  "0 or more, and less than outerRadius");
  disc.set_inner_radius(inner);
}

}  // namespace

const X3dMesh& X3dTranslator::mesh(const X3dNode& geometry) {
  const auto known = meshes_.find(&geometry);
  if (known != meshes_.end()) return known->second;
  const bool linear = options_.x3d_color == ReadOptions::Color::linear;
  return meshes_.emplace(&geometry, build_x3d_mesh(geometry, values_, linear, out_.blobs))
      .first->second;
}

bool X3dTranslator::set_geometry(const X3dNode& geometry, v1::Shape& shape) {
  const std::string& type = geometry.type;
  if (is_x3d_polygons(type)) {
    const X3dMesh& made = mesh(geometry);
    if (made.empty) {
      warnings_.add(fmt::format("{} without a face is left out", type));
      return false;
    }
    *shape.mutable_mesh() = made.mesh;
  } else if (type == "Sphere") {
    shape.mutable_sphere()->set_radius(positive(values_, geometry, "radius", 1));
  } else if (type == "Box") {
    set_box(geometry, values_, *shape.mutable_box());
  } else if (type == "Cylinder") {
    set_cylinder(geometry, values_, *shape.mutable_cylinder());
  } else if (type == "Cone") {
    set_cone(geometry, values_, *shape.mutable_cone());
  } else if (type == "Rectangle2D") {
    set_rectangle(geometry, values_, *shape.mutable_rectangle());
  } else if (type == "Disk2D") {
    set_disc(geometry, values_, *shape.mutable_disc());
  } else {
    return false;  // listed among what is ignored, or as unknown
  }
  return true;
}

void X3dTranslator::add_shape(const X3dNode& node, v1::Node& out) {
  if (!values_.boolean(node, "castShadow", true)) out.set_casts_no_shadow(true);
  const X3dNode* geometry = node.child("geometry");
  if (!geometry) return;
  v1::Shape shape;
  if (!set_geometry(*geometry, shape)) return;
  shape.set_name(geometry->def);
  const bool flat = geometry->type == "Rectangle2D" || geometry->type == "Disk2D";
  const bool two_sided = !values_.boolean(*geometry, "solid", !flat);
  const bool colors = shape.has_mesh() && mesh(*geometry).has_colors;
  shape.add_materials(material(node.child("appearance"), two_sided, colors));
  *out.mutable_shape() = std::move(shape);
}

std::string X3dTranslator::material(const X3dNode* appearance, bool two_sided, bool vertex_colors) {
  const X3dNode* node = appearance ? appearance->child("material") : nullptr;
  const auto key = std::make_tuple(node, two_sided, vertex_colors);
  const auto known = materials_.find(key);
  if (known != materials_.end()) return known->second;
  v1::Material made = make_material(node, vertex_colors);
  made.set_sides(two_sided ? v1::Material::TWO_SIDED : v1::Material::FRONT_ONLY);
  const std::string wish = !node ? "unlit" : node->def.empty() ? node->type : node->def;
  made.set_name(unique(material_names_, wish));
  *out_.scene.add_materials() = made;
  return materials_.emplace(key, made.name()).first->second;
}

v1::Material X3dTranslator::make_material(const X3dNode* node, bool vertex_colors) {
  if (node && node->type == "UnlitMaterial") return make_unlit(*node);
  if (node && node->type == "PhysicalMaterial") return make_physical(*node);
  v1::Material material;
  if (!node) {
    put(kWhite, material.mutable_unlit()->mutable_color()->mutable_value());
    return material;
  }
  // A Material of a type that is not read yet has none of these fields, so it takes the defaults.
  const Color diffuse = values_.color(*node, "diffuseColor", {.8, .8, .8});
  const double ambient = values_.share(*node, "ambientIntensity", .2);
  const double transparency = values_.share(*node, "transparency", 0);
  const double mirror = values_.share(*node, "mirror", 0);
  v1::Classic& classic = *material.mutable_classic();
  put(diffuse, classic.mutable_diffuse()->mutable_value());
  // Of the colour of the point, which textures and vertex colours may give (clause 17.2.2.4).
  v1::Color& met = *classic.mutable_ambient()->mutable_value();
  met.set_r(ambient);
  met.set_g(ambient);
  met.set_b(ambient);
  classic.set_ambient_times_diffuse(true);
  put(values_.color(*node, "specularColor", kBlack), classic.mutable_specular()->mutable_value());
  put(values_.color(*node, "emissiveColor", kBlack), classic.mutable_emission()->mutable_value());
  classic.mutable_shininess()->set_value(128 * values_.share(*node, "shininess", .2));
  if (transparency > 0) {
    classic.mutable_transparency()->set_value(transparency);
    classic.set_transmission(v1::Classic::STRAIGHT);
  }
  if (mirror > 0) {
    v1::Color& share = *classic.mutable_reflectivity()->mutable_value();
    share.set_r(mirror);
    share.set_g(mirror);
    share.set_b(mirror);
  }
  classic.set_vertex_color_replaces_diffuse(vertex_colors);
  return material;
}

v1::Material X3dTranslator::make_unlit(const X3dNode& node) {
  v1::Material material;
  v1::Unlit& unlit = *material.mutable_unlit();
  put(values_.color(node, "emissiveColor", kWhite), unlit.mutable_color()->mutable_value());
  const double transparency = values_.share(node, "transparency", 0);
  if (transparency > 0) unlit.mutable_transparency()->set_value(transparency);
  return material;
}

v1::Material X3dTranslator::make_physical(const X3dNode& node) {
  v1::Material material;
  v1::Physical& physical = *material.mutable_physical();
  put(values_.color(node, "baseColor", kWhite), physical.mutable_base_color()->mutable_value());
  put(values_.color(node, "emissiveColor", kBlack), physical.mutable_emission()->mutable_value());
  physical.mutable_metallic()->set_value(values_.share(node, "metallic", 1));
  physical.mutable_roughness()->set_value(values_.share(node, "roughness", 1));
  const double transparency = values_.share(node, "transparency", 0);
  if (transparency > 0) physical.mutable_transparency()->set_value(transparency);
  return material;
}

}  // namespace tessera
