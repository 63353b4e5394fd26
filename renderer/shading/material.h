#pragma once

#include <algorithm>
#include <cstdint>

#include "renderer/math/color.h"
#include "renderer/math/vec.h"

namespace tessera {

enum class MaterialModel : uint8_t { classic, unlit, physical, conductor, dielectric };
enum class DiffuseModel : uint8_t { lambert, half_lambert, signed_lambert };
enum class SpecularModel : uint8_t { blinn_phong, phong };
enum class Transmission : uint8_t { refract, straight };
enum class Sides : uint8_t { two_sided, front_only, back_material };

class GlassAlbedo;

inline constexpr uint32_t kNoMaterialInputs = 0xffffffffu;

/// A surface's constants, or what a surface is at one point: the local illumination models of
/// scene.proto. A value.
struct Material {
  Color ambient = kBlack;
  Color diffuse{0.8, 0.8, 0.8};  ///< the base colour of a physical one
  Color specular = kBlack;
  Color emission = kBlack;
  Color reflectivity = kBlack;
  Color absorption = kBlack;  ///< per metre inside
  double shininess = 25.6;
  double transparency = 0;
  double refractive_index = 1;         ///< inside over outside
  double alpha = 1;                    ///< the surface is there by this share
  double metallic = 1, roughness = 1;  ///< roughness of all models but classic and unlit
  double clearcoat = 0, clearcoat_roughness = 0;
  double occlusion = 1;            ///< of ambient light, on a physical one
  Color eta = kWhite, k = kBlack;  ///< the refractive index of a conductor
  double diffuse_exponent = 3;
  double grain = 0;
  uint32_t back = 0;  ///< the material of back faces, where sides say so
  /// Of rough glass that paths meet, by its refractive index; null: what its facets lose is lost.
  const GlassAlbedo* glass_albedo = nullptr;
  uint32_t inputs = kNoMaterialInputs;  ///< what of it depends on the point, in Scene::inputs
  MaterialModel model = MaterialModel::classic;
  DiffuseModel diffuse_model = DiffuseModel::lambert;
  SpecularModel specular_model = SpecularModel::blinn_phong;
  Transmission transmission = Transmission::refract;
  Sides sides = Sides::two_sided;
  bool flat = false;
  bool vertex_color_replaces_diffuse = false;
  bool ambient_times_diffuse = false;  ///< ambient is a factor on the diffuse colour
  bool thin = false;                   ///< a sheet: what goes through is not bent
  bool has_clear_input = false;        ///< somewhere it may let light through

  /// Whether light matters to it: what is unlit shows its colour, is not lit and lights nothing.
  bool is_lit() const { return model != MaterialModel::unlit; }
  /// What others get of its light, textures and vertex colours apart.
  Color emitted() const { return is_lit() && is_opaque() ? emission : kBlack; }
  /// The share of light that goes through it bent, and the share that goes straight on.
  double refracted() const { return transmission == Transmission::refract ? transparency : 0; }
  double passed_straight() const {
    return transmission == Transmission::straight ? transparency : 0;
  }
  bool hides_back() const { return sides == Sides::front_only; }
  /// Whether its back faces are of the material `back`.
  bool has_other_back() const { return sides == Sides::back_material; }
  bool is_opaque() const { return transparency <= 0 && alpha >= 1 && !has_clear_input; }
  /// Whether some of what is behind it may come straight through.
  bool has_alpha() const { return alpha < 1 || has_clear_input || passed_straight() > 0; }
  /// Whether it may mirror anything.
  bool is_mirror() const {
    return !is_black(reflectivity) || model == MaterialModel::conductor ||
           (model == MaterialModel::physical &&
            (inputs != kNoMaterialInputs || roughness < 1 || clearcoat > 0));
  }
  /// Whether what it shows depends on normals that differ from the true ones.
  bool uses_shading_normal() const {
    return is_lit() || inputs != kNoMaterialInputs || is_mirror() || refracted() > 0;
  }
  /// Whether what it shows depends on vertex colours, their alpha apart.
  bool uses_vertex_color() const {
    if (model != MaterialModel::classic && model != MaterialModel::unlit) return true;
    return inputs != kNoMaterialInputs || vertex_color_replaces_diffuse ||
           !is_black(model == MaterialModel::unlit ? emission : diffuse);
  }
  /// Whether it may be rough glass somewhere, with facets that bend light.
  bool is_rough_glass() const {
    if (thin || refractive_index == 1 || (inputs == kNoMaterialInputs && roughness == 0)) {
      return false;
    }
    return model == MaterialModel::dielectric || (model == MaterialModel::physical && !is_opaque());
  }
  /// Whether it has a specular lobe that turns light: sampling of lights finds none through it.
  bool throws_light() const {
    switch (model) {
      case MaterialModel::classic:
        return !is_black(reflectivity) || (refracted() > 0 && refractive_index != 1);
      case MaterialModel::unlit:
        return false;
      case MaterialModel::physical:
        return roughness == 0 || (clearcoat > 0 && clearcoat_roughness == 0);
      case MaterialModel::conductor:
      case MaterialModel::dielectric:
        break;
    }
    return roughness == 0;
  }
  /// Whether it sends light on in more than single directions.
  bool scatters() const {
    if (model == MaterialModel::classic) {
      return inputs != kNoMaterialInputs || !is_black(diffuse) || !is_black(specular);
    }
    return model == MaterialModel::physical || roughness > 0;
  }
  /// Whether all it does is to scatter evenly, and to emit.
  bool is_lambert() const {
    return model <= MaterialModel::unlit && !is_rich() && is_opaque() && !is_mirror() &&
           is_black(specular) && sides != Sides::front_only;
  }
  /// Whether it is classic, lets no light through, and shows nothing else from behind.
  bool is_simple() const {
    return model == MaterialModel::classic && !is_rich() && is_opaque() && is_black(absorption) &&
           sides != Sides::back_material && !flat && grain == 0;
  }
  /// Whether more than the classic formulas is needed to shade it.
  bool is_rich() const {
    return inputs != kNoMaterialInputs || alpha < 1 || model >= MaterialModel::physical;
  }
};

/// ((n . l + 1) / 2)^exponent.
double half_lambert(double n_dot_l, double exponent);
/// The specular term, for light before the surface.
Color highlight(const Material& material, const Vec3& n, const Vec3& wi, const Vec3& wo);

/// The share of a light's radiant intensity that leaves towards `wo`: diffuse and specular term.
/// `diffuse` is the material's, after vertex colours; `n`, `wi` (to the light) and `wo` (to the
/// viewer) are of unit length. The specular term is zero where the light is behind the surface.
[[gnu::always_inline]] inline Color reflected_share(const Material& material, const Color& diffuse,
                                                    const Vec3& n, const Vec3& wi, const Vec3& wo) {
  const double n_dot_l = dot(n, wi);
  double factor = n_dot_l;
  if (material.diffuse_model == DiffuseModel::lambert) {
    factor = std::max(n_dot_l, 0.0);
  } else if (material.diffuse_model == DiffuseModel::half_lambert) {
    factor = half_lambert(n_dot_l, material.diffuse_exponent);
  }
  Color share = diffuse * factor;
  if (n_dot_l > 0 && !is_black(material.specular)) share += highlight(material, n, wi, wo);
  return share;
}

/// The same of a material of another model than classic: light behind the surface gives nothing,
/// and facets stand about the clamped_normal() `facets`.
Color any_reflected_share(const Material& material, const Color& diffuse, const Vec3& n,
                          const Vec3& facets, const Vec3& wi, const Vec3& wo);

/// The share of light that comes back along the ideal mirror direction, refraction apart; `cosine`
/// in [0, 1] is that of the angle of incidence.
Color mirrored_share(const Material& material, double cosine);

/// What the share of light that goes through is multiplied by.
inline Color transmission_tint(const Material& material) {
  return material.model == MaterialModel::physical ? material.diffuse : kWhite;
}

/// About the share of light from everywhere that leaves again, as other tools write it: the colour
/// of what scatters evenly, of a metal, white for clear glass.
Color albedo(const Material& material, const Color& diffuse);

/// The share of light from everywhere that leaves again in every direction.
Color ambient_share(const Material& material, const Color& diffuse);

/// The share of unpolarised light that a smooth dielectric reflects; `cos_i` in [0, 1] on the side
/// that light comes from, `eta` the refractive index beyond over that on this side. 1 at total
/// internal reflection. (Born and Wolf, 1.5.2.)
double fresnel_dielectric(double cos_i, double eta);

/// The same of a conductor of refractive index eta + i k per channel. (Born and Wolf, 14.2.)
Color fresnel_conductor(double cos_i, const Color& eta, const Color& k);

/// Snell's law: the direction beyond the surface of a ray of unit direction `d` that meets it with
/// unit normal `n` against it; `eta` as above. False, and `out` untouched, at total reflection.
bool refract(const Vec3& d, const Vec3& n, double eta, Vec3& out);

/// exp(-absorption * distance) per channel (Beer-Lambert).
Color transmittance(const Color& absorption, double distance);

}  // namespace tessera
