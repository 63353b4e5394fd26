#pragma once

#include <cstdint>

#include "renderer/math/color.h"
#include "renderer/math/vec.h"

namespace tessera {

enum class DiffuseModel : uint8_t { lambert, half_lambert, signed_lambert };
enum class SpecularModel : uint8_t { blinn_phong, phong };
enum class Transmission : uint8_t { refract, straight };
enum class Sides : uint8_t { two_sided, front_only, back_material };

/// A surface's constants, for the local illumination model of scene.proto's Classic. A value.
struct Material {
  Color ambient = kBlack;
  Color diffuse{0.8, 0.8, 0.8};
  Color specular = kBlack;
  Color emission = kBlack;
  Color reflectivity = kBlack;
  Color absorption = kBlack;  ///< per metre inside
  double shininess = 25.6;
  double transparency = 0;
  double refractive_index = 1;  ///< inside over outside
  double diffuse_exponent = 3;
  double grain = 0;
  uint32_t back = 0;  ///< the material of back faces, where sides say so
  DiffuseModel diffuse_model = DiffuseModel::lambert;
  SpecularModel specular_model = SpecularModel::blinn_phong;
  Transmission transmission = Transmission::refract;
  Sides sides = Sides::two_sided;
  bool flat = false;
  bool unlit = false;  ///< emission alone, which vertex colours multiply
  bool vertex_color_replaces_diffuse = false;

  bool is_opaque() const { return transparency <= 0; }
  bool is_mirror() const { return !is_black(reflectivity); }
};

/// The share of a light's radiant intensity that leaves towards `wo`: diffuse and specular term.
/// `diffuse` is the material's, after vertex colours; `n`, `wi` (to the light) and `wo` (to the
/// viewer) are of unit length. The specular term is zero where the light is behind the surface.
Color reflected_share(const Material& material, const Color& diffuse, const Vec3& n, const Vec3& wi,
                      const Vec3& wo);

/// Whether reflected_share is zero for every light behind the surface, so that it needs no shadow
/// ray.
inline bool is_dark_behind(const Material& material) {
  return material.diffuse_model == DiffuseModel::lambert;
}

/// The share of unpolarised light that a smooth dielectric reflects; `cos_i` in [0, 1] on the side
/// that light comes from, `eta` the refractive index beyond over that on this side. 1 at total
/// internal reflection. (Born and Wolf, 1.5.2.)
double fresnel_dielectric(double cos_i, double eta);

/// Snell's law: the direction beyond the surface of a ray of unit direction `d` that meets it with
/// unit normal `n` against it; `eta` as above. False, and `out` untouched, at total reflection.
bool refract(const Vec3& d, const Vec3& n, double eta, Vec3& out);

/// exp(-absorption * distance) per channel (Beer-Lambert).
Color transmittance(const Color& absorption, double distance);

}  // namespace tessera
