#include "scenes/formats/gltf/gltf_material.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "renderer/math/elementary.h"

namespace tessera {
namespace {

using Image = v1::Texture::Image;

double share(const GltfValue& value, double without) { return value.number_within(without, 0, 1); }

std::vector<double> base_color(const GltfValue& factor) {
  return factor.numbers({1, 1, 1, 1}, 0, 1);
}

constexpr const char* kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";

/// The base colour of a material, or the diffuse colour of one that is written in the older model,
/// which counts where both are there.
struct BaseColor {
  GltfValue factor, texture;
};

BaseColor base_of(const GltfValue& in) {
  if (const GltfValue older = in["extensions"][kSpecularGlossiness])
    return {older["diffuseFactor"], older["diffuseTexture"]};
  const GltfValue pbr = in["pbrMetallicRoughness"];
  return {pbr["baseColorFactor"], pbr["baseColorTexture"]};
}

/// What a dielectric reflects head on, in both models of materials.
constexpr double kDielectric = 0.04;

struct MetallicColor {
  double metallic;
  std::vector<double> base;
};

/// The metallic share and base colour that come nearest to a diffuse and a specular colour: as in
/// the examples of KHR_materials_pbrSpecularGlossiness, convert-between-workflows, which solve for
/// the share at which both models reflect as brightly.
MetallicColor metallic_color_of(const std::vector<double>& diffuse,
                                const std::vector<double>& specular) {
  constexpr double kLeast = 1e-6;
  const auto brightness = [](const std::vector<double>& c) {
    return std::sqrt(.299 * c[0] * c[0] + .587 * c[1] * c[1] + .114 * c[2] * c[2]);
  };
  const double left = 1 - *std::max_element(specular.begin(), specular.end());
  const double bright = brightness(specular);
  double metallic = 0;
  if (bright >= kDielectric) {
    const double b = brightness(diffuse) * left / (1 - kDielectric) + bright - 2 * kDielectric;
    const double root = std::sqrt(b * b + 4 * kDielectric * (bright - kDielectric));
    metallic = std::clamp((root - b) / (2 * kDielectric), 0., 1.);
  }
  MetallicColor out{metallic, {}};
  for (size_t c = 0; c < 3; ++c) {
    const double of_diffuse =
        diffuse[c] * left / (1 - kDielectric) / std::max(1 - metallic, kLeast);
    const double of_specular =
        (specular[c] - kDielectric * (1 - metallic)) / std::max(metallic, kLeast);
    const double weight = metallic * metallic;
    out.base.push_back(std::clamp(of_diffuse * (1 - weight) + of_specular * weight, 0., 1.));
  }
  return out;
}

/// Without its texture.
std::vector<double> emission(const GltfValue& in) {
  // Above 1 it can only mean what emissiveStrength says since.
  std::vector<double> glow = in["emissiveFactor"].numbers({0, 0, 0}, 0, GltfValue::kMost);
  const GltfValue strength =
      in["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"];
  for (double& part : glow) part *= strength.amount(1);
  return glow;
}

}  // namespace

const std::string& GltfMaterials::use(const GltfMaterialUse& which) { return find(which).name; }

const GltfMaterials::Known& GltfMaterials::find(const GltfMaterialUse& which) {
  const auto [known, is_new] = known_.try_emplace(which);
  if (!is_new) return known->second;
  v1::Material& made = *out_.scene.add_materials();
  if (which.index) {
    const GltfValue in = file_.element("materials", *which.index);
    made = convert(in, which.is_unlit);
    const std::string name = in["name"].text("");
    known->second.name = unique_(name.empty() ? fmt::format("material {}", *which.index) : name);
    known->second.uv_sets = std::exchange(uv_sets_, {});
  } else {
    if (which.is_unlit)
      made.mutable_unlit();
    else
      made.mutable_physical();
    made.set_sides(v1::Material::FRONT_ONLY);
    known->second.name = unique_("default");
  }
  made.set_name(known->second.name);
  return known->second;
}

void GltfMaterials::color(const std::vector<double>& factor, const GltfValue& info,
                          v1::ColorInput* out) {
  out->mutable_value()->set_r(factor[0]);
  out->mutable_value()->set_g(factor[1]);
  out->mutable_value()->set_b(factor[2]);
  out->set_texture(textures_.use(info, Image::ENCODING_SRGB, uv_sets_));
}

void GltfMaterials::number(const GltfValue& factor, double without, const GltfValue& info,
                           v1::FloatInput::Channel channel, v1::FloatInput* out) {
  out->set_value(share(factor, without));
  out->set_texture(textures_.use(info, Image::ENCODING_LINEAR, uv_sets_));
  if (!out->texture().empty()) out->set_channel(channel);
}

v1::Material GltfMaterials::convert(const GltfValue& in, bool is_unlit) {
  v1::Material out;
  const BaseColor base = base_of(in);
  const bool is_base_alone(in["extensions"]["KHR_materials_unlit"]);
  if (is_base_alone || is_unlit) {
    std::vector<double> shown = base_color(base.factor);
    if (!is_base_alone && !base.texture) {
      const std::vector<double> glow = emission(in);
      for (size_t c = 0; c < glow.size(); ++c) shown[c] += glow[c];
    }
    color(shown, base.texture, out.mutable_unlit()->mutable_color());
  } else {
    physical(in, out);
  }
  coverage(in, base.factor, out);
  // Light inside a body has to find its back faces.
  const bool clear = out.physical().has_transmission() && !out.physical().thin();
  if (!in["doubleSided"].flag(false) && !clear) out.set_sides(v1::Material::FRONT_ONLY);
  if (const GltfValue normals = in["normalTexture"]) {
    out.set_normal_map(textures_.use(normals, Image::ENCODING_LINEAR, uv_sets_));
    if (const GltfValue scale = normals["scale"]) out.set_normal_scale(scale.number(1));
  }
  return out;
}

void GltfMaterials::physical(const GltfValue& in, v1::Material& out) {
  const GltfValue extensions = in["extensions"];
  v1::Physical& made = *out.mutable_physical();
  if (const GltfValue older = extensions[kSpecularGlossiness])
    specular_glossiness(older, made);
  else
    metallic_roughness(in["pbrMetallicRoughness"], made);
  if (const GltfValue occlusion = in["occlusionTexture"]) {
    number({nullptr, nullptr, ""}, 1, occlusion, v1::FloatInput::RED, made.mutable_occlusion());
    if (share(occlusion["strength"], 1) < 1 - 1e-6)
      warnings_.add("an occlusionTexture's strength is taken as 1");
  }
  if (in["emissiveFactor"]) color(emission(in), in["emissiveTexture"], made.mutable_emission());
  layers(extensions, made);
}

void GltfMaterials::metallic_roughness(const GltfValue& in, v1::Physical& out) {
  color(base_color(in["baseColorFactor"]), in["baseColorTexture"], out.mutable_base_color());
  const GltfValue packed = in["metallicRoughnessTexture"];
  number(in["metallicFactor"], 1, packed, v1::FloatInput::BLUE, out.mutable_metallic());
  number(in["roughnessFactor"], 1, packed, v1::FloatInput::GREEN, out.mutable_roughness());
}

void GltfMaterials::specular_glossiness(const GltfValue& in, v1::Physical& out) {
  std::vector<double> specular = in["specularFactor"].numbers({1, 1, 1}, 0, 1);
  double glossiness = share(in["glossinessFactor"], 1);
  if (const GltfValue packed = in["specularGlossinessTexture"]) {
    // Its factors are but multipliers, mostly 1.
    for (double& part : specular) part *= kDielectric;
    glossiness /= 2;
    warnings_.add(
        "specularGlossinessTexture is not read; the material is taken for no metal, and half as "
        "glossy as its factor says",
        [&] { return packed.place(); });
  }
  const MetallicColor made = metallic_color_of(base_color(in["diffuseFactor"]), specular);
  color(made.base, in["diffuseTexture"], out.mutable_base_color());
  out.mutable_metallic()->set_value(made.metallic);
  out.mutable_roughness()->set_value(1 - glossiness);
}

void GltfMaterials::layers(const GltfValue& extensions, v1::Physical& out) {
  if (const GltfValue index = extensions["KHR_materials_ior"]["ior"]) {
    // 0 asks for full reflection at every angle; the largest index there is comes nearest.
    constexpr double kEndless = 1e6;
    out.set_refractive_index(
        index.number(1.5) == 0 ? kEndless : index.number_within(1.5, 1, GltfValue::kMost));
  }
  const GltfValue clear = extensions["KHR_materials_transmission"];
  const GltfValue volume = extensions["KHR_materials_volume"];
  if (clear) {
    number(clear["transmissionFactor"], 0, clear["transmissionTexture"], v1::FloatInput::RED,
           out.mutable_transmission());
    out.set_thin(volume["thicknessFactor"].amount(0) == 0);
  }
  const GltfValue tint = volume["attenuationColor"], reach = volume["attenuationDistance"];
  const auto distance = reach.above_zero();
  if (tint && distance) {
    constexpr double kDarkest = 1e-6;
    const auto rgb = tint.numbers({1, 1, 1}, 0, 1);
    const auto absorption = [&](double c) {
      return -portable::log(std::max(c, kDarkest)) / *distance;
    };
    out.mutable_absorption()->set_r(absorption(rgb[0]));
    out.mutable_absorption()->set_g(absorption(rgb[1]));
    out.mutable_absorption()->set_b(absorption(rgb[2]));
  }
  if (const GltfValue coat = extensions["KHR_materials_clearcoat"]) {
    number(coat["clearcoatFactor"], 0, coat["clearcoatTexture"], v1::FloatInput::RED,
           out.mutable_clearcoat());
    number(coat["clearcoatRoughnessFactor"], 0, coat["clearcoatRoughnessTexture"],
           v1::FloatInput::GREEN, out.mutable_clearcoat_roughness());
    if (coat["clearcoatNormalTexture"]) warnings_.add("clearcoatNormalTexture is not read");
  }
  if (volume["thicknessTexture"]) {
    warnings_.add("thicknessTexture is not read");
  }
}

void GltfMaterials::coverage(const GltfValue& in, const GltfValue& base_factor, v1::Material& out) {
  const GltfValue mode = in["alphaMode"];
  const std::string name = mode.text("OPAQUE");
  if (name == "OPAQUE") {
    out.set_alpha(v1::Material::ALPHA_OPAQUE);
    return;
  }
  if (name == "MASK") {
    out.set_alpha(v1::Material::ALPHA_MASK);
    const double cutoff = in["alphaCutoff"].amount(.5);
    out.set_alpha_cutoff(std::min(cutoff, 1.));
    // No alpha reaches it: nothing is seen.
    if (cutoff > 1) {
      out.mutable_opacity()->set_value(0);
      return;
    }
  } else if (name == "BLEND") {
    out.set_alpha(v1::Material::ALPHA_BLEND);
  } else {
    mode.repair(mode.shown(), "OPAQUE, MASK or BLEND", "OPAQUE is taken");
    out.set_alpha(v1::Material::ALPHA_OPAQUE);
    return;
  }
  if (base_factor) out.mutable_opacity()->set_value(base_color(base_factor)[3]);
}

}  // namespace tessera
