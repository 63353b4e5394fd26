#include "renderer/shading/material_inputs.h"

#include <algorithm>
#include <cmath>

namespace tessera {

namespace {

using Target = MaterialInputs::Target;

Color& color_of(Material& material, Target target) {
  switch (target) {
    case Target::ambient:
      return material.ambient;
    case Target::specular:
      return material.specular;
    case Target::emission:
      return material.emission;
    case Target::reflectivity:
      return material.reflectivity;
    default:
      return material.diffuse;
  }
}

double& number_of(Material& material, Target target) {
  switch (target) {
    case Target::shininess:
      return material.shininess;
    case Target::transparency:
      return material.transparency;
    case Target::metallic:
      return material.metallic;
    case Target::roughness:
      return material.roughness;
    case Target::clearcoat:
      return material.clearcoat;
    case Target::clearcoat_roughness:
      return material.clearcoat_roughness;
    case Target::occlusion:
      return material.occlusion;
    default:
      return material.alpha;
  }
}

double channel_of(const Texel& texel, uint8_t channel) {
  switch (channel) {
    case 0:
      return texel.color.r;
    case 1:
      return texel.color.g;
    case 2:
      return texel.color.b;
    default:
      return texel.alpha;
  }
}

void apply_surface_color(const MaterialInputs& inputs, const Texture& texture, const Texel& texel,
                         VertexColor& vertex, Material& material) {
  Color& color = color_of(material, inputs.surface_color);
  if (inputs.texture_replaces && texture.has_color()) {
    color = without_negative(texel.color);
  } else {
    if (vertex.exists) {
      color = material.vertex_color_replaces_diffuse ? vertex.color : color * vertex.color;
    }
    color = color * without_negative(texel.color);
  }
  vertex.exists = false;
  if (!texture.has_alpha()) return;
  if (inputs.texture_replaces) {
    material.transparency = 0;
    material.alpha = 1;
    vertex.alpha = 1;
  }
  material.alpha *= texel.alpha;
}

void apply_alpha_mode(const MaterialInputs& inputs, VertexColor& vertex, Material& material) {
  if (inputs.alpha_mode == AlphaMode::blend) return;
  const double passed = material.passed_straight();
  const double covered = material.alpha * vertex.alpha * (1 - passed);
  const bool is_there = inputs.alpha_mode == AlphaMode::opaque || covered >= inputs.alpha_cutoff;
  material.alpha = is_there ? 1 : 0;
  vertex.alpha = 1;
  if (passed > 0) material.transparency = 0;
}

/// The height of the surface at `point` moved by `step` along a world vector of unit length.
double height_at(const MaterialInputs& inputs, TexturePoint point,
                 std::span<const Texture> textures, const Vec3& uv_step, const Vec3& object_step,
                 const Vec3& world_step) {
  point.uv.at = point.uv.at + uv_step;
  point.second_uv.at = point.second_uv.at + uv_step;
  point.object.at = point.object.at + object_step;
  point.world.at = point.world.at + world_step;
  return inputs.bump_height *
         channel_of(look_up(textures[inputs.bump], point, textures), inputs.bump_channel);
}

Vec3 mapped_normal(const MaterialInputs& inputs, const TexturePoint& point,
                   std::span<const Texture> textures, const SurfaceFrame& frame) {
  const Vec3& n = frame.normal;
  const bool is_given = length_squared(frame.tangent) > 0;
  const auto [dpdu, dpdv] = frame.derivatives(textures[inputs.normal_map]);
  const Vec3& given = is_given ? frame.tangent : dpdu;
  const Vec3 along_u = given - n * dot(n, given);
  if (!(length_squared(along_u) > 0)) return n;
  const Vec3 tangent = normalize(along_u);
  Vec3 bitangent = cross(n, tangent);
  if (dot(bitangent, is_given ? frame.bitangent : dpdv) < 0) bitangent = -bitangent;
  const Color c = look_up(textures[inputs.normal_map], point, textures).color;
  const double scale = inputs.normal_scale;
  const Vec3 mapped =
      tangent * (scale * (2 * c.r - 1)) + bitangent * (scale * (2 * c.g - 1)) + n * (2 * c.b - 1);
  return length_squared(mapped) > 0 && is_finite(mapped) ? normalize(mapped) : n;
}

/// Blinn 1978, by finite differences along two tangents.
Vec3 bumped_normal(const MaterialInputs& inputs, const TexturePoint& point,
                   std::span<const Texture> textures, const SurfaceFrame& frame, const Vec3& normal,
                   const Affine& to_object, double step) {
  const Vec3& n = frame.normal;
  const Vec3 first = normalize(cross(n, std::abs(n.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const Vec3 tangents[] = {first, cross(n, first)};
  const Texture& bump = textures[inputs.bump];
  const bool by_uv =
      bump.mapping == TextureMapping::uv || bump.mapping == TextureMapping::second_uv;
  const auto [dpdu, dpdv] = frame.derivatives(bump);
  Vec3 slope{};
  for (const Vec3& tangent : tangents) {
    const Vec3 world = tangent * (step / 2);
    Vec3 uv;
    if (!uv_along(dpdu, dpdv, world, uv) && by_uv) return normal;
    const Vec3 object = to_object(world);
    const double ahead = height_at(inputs, point, textures, uv, object, world);
    const double behind = height_at(inputs, point, textures, -uv, -object, -world);
    slope = slope + tangent * ((ahead - behind) / step);
  }
  const Vec3 bumped = normal - slope;
  return is_finite(bumped) && length_squared(bumped) > 0 ? normalize(bumped) : normal;
}

}  // namespace

void resolve_material(const MaterialInputs& inputs, const TexturePoint& point,
                      std::span<const Texture> textures, VertexColor& vertex, Material& material) {
  uint32_t last = kNoTexture;  // materials often name one texture for two fields
  Texel texel;
  for (const MaterialInputs::Slot& slot : inputs.slots) {
    const Texture& texture = textures[slot.texture];
    if (slot.texture != last) texel = look_up(texture, point, textures);
    last = slot.texture;
    if (slot.target == inputs.surface_color) {
      apply_surface_color(inputs, texture, texel, vertex, material);
    } else if (slot.target <= Target::last_color) {
      Color& color = color_of(material, slot.target);
      color = color * without_negative(texel.color);
    } else {
      double& number = number_of(material, slot.target);
      number = number * channel_of(texel, slot.channel);
      const bool is_share = slot.target != Target::shininess;
      number = std::clamp(number, 0.0, is_share ? 1.0 : 1e9);
    }
  }
  apply_alpha_mode(inputs, vertex, material);
}

Vec3 perturbed_normal(const MaterialInputs& inputs, const TexturePoint& point,
                      std::span<const Texture> textures, const SurfaceFrame& frame,
                      const Affine& to_object, double step) {
  Vec3 normal = frame.normal;
  if (inputs.normal_map != kNoTexture) normal = mapped_normal(inputs, point, textures, frame);
  if (inputs.bump == kNoTexture) return normal;
  return bumped_normal(inputs, point, textures, frame, normal, to_object, step);
}

bool uv_along(const Vec3& dpdu, const Vec3& dpdv, const Vec3& v, Vec3& uv) {
  const double uu = dot(dpdu, dpdu), uv_ = dot(dpdu, dpdv), vv = dot(dpdv, dpdv);
  const double det = uu * vv - uv_ * uv_;
  uv = {};
  if (!(det > 1e-12 * uu * vv)) return false;
  const double pu = dot(dpdu, v), pv = dot(dpdv, v);
  uv = {(vv * pu - uv_ * pv) / det, (uu * pv - uv_ * pu) / det, 0};
  return true;
}

}  // namespace tessera
