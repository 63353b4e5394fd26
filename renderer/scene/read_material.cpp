#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "renderer/scene/read_shading.h"

namespace tessera {

namespace {

using Target = MaterialInputs::Target;

/// Reads the fields of one material; those with a texture go into its inputs too.
class Fields {
 public:
  Fields(const Where& where, TextureTable& textures, MaterialInputs& inputs)
      : where_(where), textures_(textures), inputs_(inputs) {}

  void read(std::string_view name, const v1::ColorInput& in, const Color& fallback, Target target,
            Color& out) {
    const TexturedColor color = textures_.read(where_, name, in, fallback);
    out = color.value;
    // What multiplies black is not looked up, but the surface's colour may be replaced.
    if (color.texture != kNoTexture && (!is_black(out) || target == inputs_.surface_color)) {
      inputs_.slots.push_back({target, color.texture, 0});
    }
  }

  void read(std::string_view name, const v1::FloatInput& in, double fallback, const Range& range,
            Target target, double& out) {
    uint32_t texture = kNoTexture;
    out = read_value(name, in, fallback, range, texture);
    if (texture != kNoTexture && out != 0) {
      inputs_.slots.push_back({target, texture, static_cast<uint8_t>(in.channel())});
    }
  }

  /// The number, and the index of the texture that it is multiplied by.
  double read_value(std::string_view name, const v1::FloatInput& in, double fallback,
                    const Range& range, uint32_t& texture) {
    if (in.channel() < 0 || in.channel() > 3) {
      fail_value(where_, fmt::format("{}.channel", name), std::to_string(in.channel()),
                 "RED, GREEN, BLUE or ALPHA");
    }
    if (!in.texture().empty()) {
      texture = textures_.use(where_, fmt::format("{}.texture", name), in.texture());
      fallback = 1;
    }
    return in.has_value() ? checked(where_, name, in.value(), range) : fallback;
  }

  const Where& where() const { return where_; }
  MaterialInputs& inputs() { return inputs_; }
  const Texture& texture(uint32_t index) const { return textures_[index]; }
  uint32_t use(std::string_view name, const std::string& texture) {
    return textures_.use(where_, name, texture);
  }

 private:
  const Where& where_;
  TextureTable& textures_;
  MaterialInputs& inputs_;
};

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

void read_classic(Fields& fields, const v1::Classic& in, Material& out) {
  const Where& where = fields.where();
  // First, for a replaced colour has no value of its own.
  fields.read("diffuse", in.diffuse(), out.diffuse, Target::diffuse, out.diffuse);
  fields.read("ambient", in.ambient(), out.ambient, Target::ambient, out.ambient);
  fields.read("specular", in.specular(), out.specular, Target::specular, out.specular);
  fields.read("emission", in.emission(), out.emission, Target::emission, out.emission);
  fields.read("reflectivity", in.reflectivity(), out.reflectivity, Target::reflectivity,
              out.reflectivity);
  fields.read("shininess", in.shininess(), out.shininess, kNotNegative, Target::shininess,
              out.shininess);
  fields.read("transparency", in.transparency(), out.transparency, kUnitRange, Target::transparency,
              out.transparency);
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
  out.ambient_times_diffuse = in.ambient_times_diffuse();
  fields.inputs().texture_replaces = in.texture_replaces_diffuse();
}

void read_unlit(Fields& fields, const v1::Unlit& in, Material& out) {
  out.model = MaterialModel::unlit;
  out.diffuse = kBlack;
  fields.inputs().surface_color = Target::emission;
  fields.inputs().texture_replaces = in.texture_replaces_color();
  fields.read("color", in.color(), kWhite, Target::emission, out.emission);
  fields.read("transparency", in.transparency(), 0, kUnitRange, Target::transparency,
              out.transparency);
  out.transmission = Transmission::straight;
}

void read_physical(Fields& fields, const v1::Physical& in, Material& out) {
  const Where& where = fields.where();
  out.model = MaterialModel::physical;
  fields.read("base_color", in.base_color(), kWhite, Target::diffuse, out.diffuse);
  fields.read("metallic", in.metallic(), 1, kUnitRange, Target::metallic, out.metallic);
  fields.read("roughness", in.roughness(), 1, kUnitRange, Target::roughness, out.roughness);
  fields.read("emission", in.emission(), kBlack, Target::emission, out.emission);
  fields.read("transmission", in.transmission(), 0, kUnitRange, Target::transparency,
              out.transparency);
  fields.read("clearcoat", in.clearcoat(), 0, kUnitRange, Target::clearcoat, out.clearcoat);
  fields.read("clearcoat_roughness", in.clearcoat_roughness(), 0, kUnitRange,
              Target::clearcoat_roughness, out.clearcoat_roughness);
  fields.read("occlusion", in.occlusion(), 1, kUnitRange, Target::occlusion, out.occlusion);
  if (!in.transparency().texture().empty()) {
    fail_value(where, "transparency", "a texture", "a number; opacity takes a texture");
  }
  if (in.transparency().has_value()) {
    out.alpha = 1 - checked(where, "transparency", in.transparency().value(), kUnitRange);
  }
  out.refractive_index = in.has_refractive_index()
                             ? checked(where, "refractive_index", in.refractive_index(), kPositive)
                             : 1.5;
  out.absorption = checked(where, "absorption", in.absorption());
  out.thin = in.thin();
}

void read_conductor(Fields& fields, const v1::Conductor& in, Material& out) {
  const Where& where = fields.where();
  out.model = MaterialModel::conductor;
  out.diffuse = kBlack;
  out.eta = checked(where, "eta", in.eta());
  out.k = checked(where, "k", in.k());
  // Beyond, it is a mirror whose Fresnel factor leaves the range of numbers.
  constexpr double kMost = 1e6;
  for (const auto& [name, color] : {std::pair("eta", out.eta), std::pair("k", out.k)}) {
    if (max_component(color) > kMost) {
      fail_value(where, name, fmt::format("{}", max_component(color)),
                 fmt::format("at most {}", kMost));
    }
  }
  fields.read("roughness", in.roughness(), 0, kUnitRange, Target::roughness, out.roughness);
}

void read_dielectric(Fields& fields, const v1::Dielectric& in, Material& out) {
  const Where& where = fields.where();
  out.model = MaterialModel::dielectric;
  out.diffuse = kBlack;
  out.transparency = 1;
  out.refractive_index = in.has_refractive_index()
                             ? checked(where, "refractive_index", in.refractive_index(), kPositive)
                             : 1.5;
  fields.read("roughness", in.roughness(), 0, kUnitRange, Target::roughness, out.roughness);
  out.absorption = checked(where, "absorption", in.absorption());
  out.thin = in.thin();
}

void read_kind(Fields& fields, const v1::Material& in, Material& out) {
  switch (in.kind_case()) {
    case v1::Material::kClassic:
      return read_classic(fields, in.classic(), out);
    case v1::Material::kUnlit:
      return read_unlit(fields, in.unlit(), out);
    case v1::Material::kPhysical:
      return read_physical(fields, in.physical(), out);
    case v1::Material::kConductor:
      return read_conductor(fields, in.conductor(), out);
    case v1::Material::kDielectric:
      return read_dielectric(fields, in.dielectric(), out);
    case v1::Material::KIND_NOT_SET:
      return;
  }
}

void read_relief(Fields& fields, const v1::Material& in) {
  MaterialInputs& inputs = fields.inputs();
  if (!in.normal_map().empty()) inputs.normal_map = fields.use("normal_map", in.normal_map());
  if (in.has_normal_scale()) {
    inputs.normal_scale = checked(fields.where(), "normal_scale", in.normal_scale());
  }
  inputs.bump_height = fields.read_value("bump", in.bump(), 0, kAnyNumber, inputs.bump);
  inputs.bump_channel = static_cast<uint8_t>(in.bump().channel());
  if (inputs.bump_height == 0) inputs.bump = kNoTexture;
}

Sides read_sides(v1::Material::Sides sides) {
  switch (sides) {
    case v1::Material::FRONT_ONLY:
      return Sides::front_only;
    case v1::Material::BACK_MATERIAL:
      return Sides::back_material;
    default:
      return Sides::two_sided;
  }
}

void read_alpha(Fields& fields, const v1::Material& in, Material& out) {
  MaterialInputs& inputs = fields.inputs();
  double opacity = 1;
  fields.read("opacity", in.opacity(), 1, kUnitRange, Target::alpha, opacity);
  out.alpha *= opacity;
  if (in.has_alpha_cutoff()) {
    inputs.alpha_cutoff = checked(fields.where(), "alpha_cutoff", in.alpha_cutoff(), kUnitRange);
  }
  if (in.alpha() == v1::Material::ALPHA_MASK) inputs.alpha_mode = AlphaMode::mask;
  if (in.alpha() == v1::Material::ALPHA_OPAQUE) {
    inputs.alpha_mode = AlphaMode::opaque;
    out.alpha = 1;
    if (out.passed_straight() > 0) out.transparency = 0;
    std::erase_if(inputs.slots, [](const auto& slot) { return slot.target == Target::alpha; });
    return;
  }
  for (const MaterialInputs::Slot& slot : inputs.slots) {
    out.has_clear_input |=
        slot.target == Target::alpha ||
        (slot.target == inputs.surface_color && fields.texture(slot.texture).has_alpha());
  }
}

}  // namespace

Material read_material(const Where& where, const v1::Material& in, TextureTable& textures,
                       MaterialInputs& inputs) {
  Material out;
  Fields fields(where, textures, inputs);
  read_kind(fields, in, out);
  read_relief(fields, in);
  out.sides = read_sides(in.sides());
  read_alpha(fields, in, out);
  if (out.thin) out.absorption = kBlack;
  return out;
}

}  // namespace tessera
