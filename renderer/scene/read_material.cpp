#include <fmt/format.h>

#include <algorithm>

#include "renderer/scene/read_shading.h"

namespace tessera {

namespace {

Color read_color(const Where& where, std::string_view field, const v1::ColorInput& input,
                 const Color& fallback, const Range& range = kNotNegative) {
  if (!input.texture().empty()) {
    fail_unsupported(where, fmt::format("texture '{}' for {}", input.texture(), field));
  }
  return input.has_value() ? checked(where, field, input.value(), range) : fallback;
}

double read_number(const Where& where, std::string_view field, const v1::FloatInput& input,
                   double fallback, const Range& range) {
  if (!input.texture().empty()) {
    fail_unsupported(where, fmt::format("texture '{}' for {}", input.texture(), field));
  }
  return input.has_value() ? checked(where, field, input.value(), range) : fallback;
}

DiffuseModel read_diffuse_model(const Where& where, v1::Classic::DiffuseModel model) {
  switch (model) {
    case v1::Classic::LAMBERT:
      return DiffuseModel::lambert;
    case v1::Classic::HALF_LAMBERT:
      return DiffuseModel::half_lambert;
    case v1::Classic::SIGNED:
      return DiffuseModel::signed_lambert;
    default:
      break;
  }
  fail_value(where, "diffuse_model", std::to_string(model), "LAMBERT, HALF_LAMBERT or SIGNED");
}

void read_classic(const Where& where, const v1::Classic& in, Material& out) {
  out.ambient = read_color(where, "ambient", in.ambient(), out.ambient);
  out.diffuse = read_color(where, "diffuse", in.diffuse(), out.diffuse);
  out.specular = read_color(where, "specular", in.specular(), out.specular);
  out.emission = read_color(where, "emission", in.emission(), out.emission);
  out.reflectivity = read_color(where, "reflectivity", in.reflectivity(), out.reflectivity);
  out.shininess = read_number(where, "shininess", in.shininess(), out.shininess, kNotNegative);
  out.transparency =
      read_number(where, "transparency", in.transparency(), out.transparency, kUnitRange);
  if (in.has_refractive_index()) {
    out.refractive_index = checked(where, "refractive_index", in.refractive_index(), kPositive);
  }
  out.absorption = checked(where, "absorption", in.absorption());
  if (in.has_diffuse_exponent()) {
    out.diffuse_exponent = checked(where, "diffuse_exponent", in.diffuse_exponent(), kNotNegative);
  }
  out.grain = checked(where, "grain", in.grain(), kNotNegative);
  out.diffuse_model = read_diffuse_model(where, in.diffuse_model());
  out.specular_model =
      in.specular_model() == v1::Classic::PHONG ? SpecularModel::phong : SpecularModel::blinn_phong;
  out.transmission =
      in.transmission() == v1::Classic::STRAIGHT ? Transmission::straight : Transmission::refract;
  out.flat = in.flat();
  out.vertex_color_replaces_diffuse = in.vertex_color_replaces_diffuse();
}

void read_unlit(const Where& where, const v1::Unlit& in, Material& out) {
  out.unlit = true;
  out.diffuse = kBlack;
  out.emission = read_color(where, "color", in.color(), kWhite);
  out.transparency = read_number(where, "transparency", in.transparency(), 0, kUnitRange);
  out.transmission = Transmission::straight;
}

void apply_alpha(const Where& where, const v1::Material& in, Material& out) {
  if (in.alpha() == v1::Material::ALPHA_OPAQUE) out.transparency = 0;
  if (in.alpha() != v1::Material::ALPHA_MASK) return;
  const double cutoff =
      in.has_alpha_cutoff() ? checked(where, "alpha_cutoff", in.alpha_cutoff(), kUnitRange) : 0.5;
  out.transparency = 1 - out.transparency < cutoff ? 1 : 0;
  out.transmission = Transmission::straight;
}

}  // namespace

Material read_material(const Where& where, const v1::Material& in) {
  Material out;
  switch (in.kind_case()) {
    case v1::Material::kClassic:
      read_classic(where, in.classic(), out);
      break;
    case v1::Material::kUnlit:
      read_unlit(where, in.unlit(), out);
      break;
    case v1::Material::kPhysical:
      fail_unsupported(where, "a physical material");
      break;
    case v1::Material::kConductor:
      fail_unsupported(where, "a conductor material");
      break;
    case v1::Material::kDielectric:
      fail_unsupported(where, "a dielectric material");
      break;
    case v1::Material::KIND_NOT_SET:
      break;
  }
  if (!in.normal_map().empty()) fail_unsupported(where, "a normal map");
  if (in.has_bump()) fail_unsupported(where, "a bump map");
  switch (in.sides()) {
    case v1::Material::FRONT_ONLY:
      out.sides = Sides::front_only;
      break;
    case v1::Material::BACK_MATERIAL:
      out.sides = Sides::back_material;
      break;
    default:
      out.sides = Sides::two_sided;
      break;
  }
  apply_alpha(where, in, out);
  return out;
}

}  // namespace tessera
