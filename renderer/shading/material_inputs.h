#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/shading/material.h"
#include "renderer/shading/texture.h"

namespace tessera {

enum class AlphaMode : uint8_t { blend, opaque, mask };

/// What of a material depends on the point. Immutable once built.
struct MaterialInputs {
  enum class Target : uint8_t {
    ambient,
    diffuse,
    specular,
    emission,
    reflectivity,
    last_color = reflectivity,
    shininess,
    transparency,
    alpha,
    metallic,
    roughness,
    clearcoat,
    clearcoat_roughness,
    occlusion
  };
  /// A texture that multiplies a field of the material.
  struct Slot {
    Target target = Target::diffuse;
    uint32_t texture = 0;  ///< into the scene's textures
    uint8_t channel = 0;   ///< 0 to 3: red, green, blue, alpha; of numbers
  };

  std::vector<Slot> slots;
  Target surface_color = Target::diffuse;  ///< the colour that vertex colours and alpha go with
  bool texture_replaces = false;           ///< the surface colour's texture is no factor
  AlphaMode alpha_mode = AlphaMode::blend;
  double alpha_cutoff = 0.5;
  uint32_t normal_map = kNoTexture;
  double normal_scale = 1;
  uint32_t bump = kNoTexture;
  uint8_t bump_channel = 0;
  double bump_height = 1;  ///< metres

  bool needs_point() const {
    return !slots.empty() || normal_map != kNoTexture || bump != kNoTexture;
  }
};

/// The colour that vertices give a point.
struct VertexColor {
  Color color = kWhite;
  double alpha = 1;
  bool exists = false;
};

/// What `material` is at `point`. A vertex colour that went into the result is taken off `vertex`.
void resolve_material(const MaterialInputs& inputs, const TexturePoint& point,
                      std::span<const Texture> textures, VertexColor& vertex, Material& material);

/// A frame of a surface: unit normal, and the point's derivatives by uv and by the second uv (zero
/// where there is none).
struct SurfaceFrame {
  Vec3 normal, dpdu, dpdv;
  Vec3 tangent{}, bitangent{};  ///< along which a normal map lies; zero: as its texture's u and v
  Vec3 second_dpdu{}, second_dpdv{};

  /// By the coordinates that the texture takes.
  std::pair<const Vec3&, const Vec3&> derivatives(const Texture& texture) const {
    if (texture.mapping == TextureMapping::second_uv) return {second_dpdu, second_dpdv};
    return {dpdu, dpdv};
  }
};

/// The unit normal that normal map and bump map make of frame.normal. `to_object` takes world
/// vectors to the shape's frame; `step` is the distance in metres over which a bump is felt.
Vec3 perturbed_normal(const MaterialInputs& inputs, const TexturePoint& point,
                      std::span<const Texture> textures, const SurfaceFrame& frame,
                      const Affine& to_object, double step);

/// The change of uv along world vector `v` of the surface; false where the surface has no uv there.
bool uv_along(const Vec3& dpdu, const Vec3& dpdv, const Vec3& v, Vec3& uv);

}  // namespace tessera
