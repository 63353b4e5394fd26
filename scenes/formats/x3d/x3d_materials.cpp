#include <fmt/format.h>

#include <array>

#include "scenes/formats/x3d/x3d_translator.h"

namespace tessera {
namespace {

void put_grey(double level, v1::Color* out) {
  out->set_r(level);
  out->set_g(level);
  out->set_b(level);
}

void scale(double by, v1::Color* color) {
  color->set_r(color->r() * by);
  color->set_g(color->g() * by);
  color->set_b(color->b() * by);
}

/// An extension of castle-engine's: the share of what is seen that is mirrored.
void set_mirror(double share, v1::Classic& classic) {
  put_grey(share, classic.mutable_reflectivity()->mutable_value());
  scale(1 - share, classic.mutable_diffuse()->mutable_value());
  scale(1 - share, classic.mutable_specular()->mutable_value());
  scale(1 - share, classic.mutable_emission()->mutable_value());
}

const X3dNode* child(const X3dNode* node, const char* field) {
  return node ? node->child(field) : nullptr;
}

}  // namespace

/// Up to 3.3 a coloured texture takes the place of the material's colour, from 4.0 on it
/// multiplies.
bool X3dTranslator::texture_replaces() const {
  using Rule = ReadOptions::X3dTexture;
  const Rule rule = build_.options.x3d_texture;
  return rule == Rule::replace || (rule == Rule::by_version && document_.version() < 40);
}

double X3dTranslator::transparency(const Look& look, const X3dNode& node, const char* name) const {
  return look.color_alpha ? 0 : values_.share(node, name, 0);
}

std::string X3dTranslator::material(const Look& look) {
  const auto known = materials_.find(look);
  if (known != materials_.end()) return known->second;
  const X3dNode* node = child(look.appearance, "material");
  const X3dNode* back_node = child(look.appearance, "backMaterial");
  const bool own_back = node && node->type == "TwoSidedMaterial" &&
                        values_.boolean(*node, "separateBackColor", false);
  v1::Material made = make_material(look, node, false);
  const auto add = [&](v1::Material& material, const X3dNode* of) {
    const std::string wish = !of ? "unlit" : of->def.empty() ? of->type : of->def;
    material.set_name(build_.unique(build_.material_names, wish));
    *out_.scene.add_materials() = material;
  };
  made.set_sides(look.two_sided ? v1::Material::TWO_SIDED : v1::Material::FRONT_ONLY);
  if (look.two_sided && !look.lines && (own_back || back_node)) {
    v1::Material back = make_material(look, own_back ? node : back_node, own_back);
    add(back, own_back ? node : back_node);
    made.set_sides(v1::Material::BACK_MATERIAL);
    made.set_back(back.name());
  }
  add(made, node);
  return materials_.emplace(look, made.name()).first->second;
}

v1::Material X3dTranslator::make_material(const Look& look, const X3dNode* node, bool back) {
  const bool unlit = !node || look.lines || node->type == "UnlitMaterial";
  v1::Material made = unlit                              ? make_unlit(look, node)
                      : node->type == "PhysicalMaterial" ? make_physical(look, *node)
                                                         : make_classic(look, *node, back);
  if (!look.lines) set_alpha(look, made);
  if (node && !unlit) set_normal_map(look, *node, made);
  return made;
}

void X3dTranslator::set_alpha(const Look& look, v1::Material& material) {
  if (!look.appearance) return;
  constexpr std::array<std::string_view, 4> kModes{"AUTO", "OPAQUE", "MASK", "BLEND"};
  constexpr std::array kAlphas{v1::Material::ALPHA_AUTO, v1::Material::ALPHA_OPAQUE,
                               v1::Material::ALPHA_MASK, v1::Material::ALPHA_BLEND};
  material.set_alpha(kAlphas[values_.choice(*look.appearance, "alphaMode", kModes)]);
  if (material.alpha() == v1::Material::ALPHA_MASK)
    material.set_alpha_cutoff(values_.share(*look.appearance, "alphaCutoff", .5));
}

void X3dTranslator::set_normal_map(const Look& look, const X3dNode& node, v1::Material& material) {
  const std::string map = texture(node.child("normalTexture"), look, false);
  if (map.empty()) return;
  material.set_normal_map(map);
  material.set_normal_scale(values_.amount(node, "normalScale", 1));
}

/// Clause 17.2.2.4; `back` takes the back fields of a TwoSidedMaterial.
v1::Material X3dTranslator::make_classic(const Look& look, const X3dNode& node, bool back) {
  // A Material of a type that is not read has none of these fields, so it takes the defaults.
  const auto name = [back](const char* front, const char* behind) { return back ? behind : front; };
  const auto color = [&](const char* field, const Color& otherwise, v1::ColorInput* out,
                         const char* texture_field) {
    put(values_.color(node, field, otherwise), out->mutable_value());
    if (texture_field) out->set_texture(texture(node.child(texture_field), look, true));
  };
  v1::Material material;
  v1::Classic& classic = *material.mutable_classic();
  color(name("diffuseColor", "backDiffuseColor"), {.8, .8, .8}, classic.mutable_diffuse(), nullptr);
  classic.mutable_diffuse()->set_texture(main_texture(look, &node, "diffuseTexture"));
  color(name("specularColor", "backSpecularColor"), kBlack, classic.mutable_specular(),
        "specularTexture");
  color(name("emissiveColor", "backEmissiveColor"), kBlack, classic.mutable_emission(),
        "emissiveTexture");
  // Of the colour of the point, which textures and vertex colours may give.
  put_grey(values_.share(node, name("ambientIntensity", "backAmbientIntensity"), .2),
           classic.mutable_ambient()->mutable_value());
  classic.set_ambient_times_diffuse(true);
  classic.mutable_shininess()->set_value(
      128 * values_.share(node, name("shininess", "backShininess"), .2));
  const std::string shininess = texture(node.child("shininessTexture"), look, false);
  if (!shininess.empty()) {
    classic.mutable_shininess()->set_texture(shininess);
    classic.mutable_shininess()->set_channel(v1::FloatInput::ALPHA);
  }
  for (const char* field : {"ambientTexture", "occlusionTexture"})
    if (const X3dNode* map = node.child(field))
      values_.warn(map->offset, fmt::format("{} of Material is left out", field));
  const double clear = transparency(look, node, name("transparency", "backTransparency"));
  if (clear > 0) {
    classic.mutable_transparency()->set_value(clear);
    classic.set_transmission(v1::Classic::STRAIGHT);
  }
  const double mirror = values_.share(node, "mirror", 0);
  if (mirror > 0) set_mirror(mirror, classic);
  classic.set_vertex_color_replaces_diffuse(look.colors);
  classic.set_texture_replaces_diffuse(!classic.diffuse().texture().empty() && texture_replaces());
  return material;
}

/// Without a material everything is white; lines take only what a material emits.
v1::Material X3dTranslator::make_unlit(const Look& look, const X3dNode* node) {
  v1::Material material;
  v1::Unlit& unlit = *material.mutable_unlit();
  const bool emits = node && (node->type == "UnlitMaterial" || look.lines);
  const Color otherwise = node && node->type == "UnlitMaterial" ? kWhite : kBlack;
  // A Color node takes its place.
  const Color color =
      emits && !look.colors ? values_.color(*node, "emissiveColor", otherwise) : kWhite;
  put(color, unlit.mutable_color()->mutable_value());
  if (!look.lines) unlit.mutable_color()->set_texture(main_texture(look, node, "emissiveTexture"));
  unlit.set_texture_replaces_color(!unlit.color().texture().empty() && texture_replaces());
  const double clear = node ? transparency(look, *node, "transparency") : 0;
  if (clear > 0) unlit.mutable_transparency()->set_value(clear);
  return material;
}

v1::Material X3dTranslator::make_physical(const Look& look, const X3dNode& node) {
  v1::Material material;
  v1::Physical& physical = *material.mutable_physical();
  const Color base = look.colors ? kWhite : values_.color(node, "baseColor", kWhite);
  put(base, physical.mutable_base_color()->mutable_value());
  physical.mutable_base_color()->set_texture(main_texture(look, &node, "baseTexture"));
  put(values_.color(node, "emissiveColor", kBlack), physical.mutable_emission()->mutable_value());
  physical.mutable_emission()->set_texture(texture(node.child("emissiveTexture"), look, true));
  physical.mutable_metallic()->set_value(values_.share(node, "metallic", 1));
  physical.mutable_roughness()->set_value(values_.share(node, "roughness", 1));
  const std::string both = texture(node.child("metallicRoughnessTexture"), look, false);
  if (!both.empty()) {
    physical.mutable_metallic()->set_texture(both);
    physical.mutable_metallic()->set_channel(v1::FloatInput::BLUE);
    physical.mutable_roughness()->set_texture(both);
    physical.mutable_roughness()->set_channel(v1::FloatInput::GREEN);
  }
  const std::string occlusion = texture(node.child("occlusionTexture"), look, false);
  if (!occlusion.empty()) physical.mutable_occlusion()->set_texture(occlusion);
  const double clear = transparency(look, node, "transparency");
  if (clear > 0) physical.mutable_transparency()->set_value(clear);
  return material;
}

}  // namespace tessera
