#include "renderer/shading/material.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"

namespace tessera {

namespace {

double diffuse_factor(const Material& material, double n_dot_l) {
  switch (material.diffuse_model) {
    case DiffuseModel::lambert:
      return std::max(n_dot_l, 0.0);
    case DiffuseModel::signed_lambert:
      return n_dot_l;
    case DiffuseModel::half_lambert:
      break;
  }
  return portable::pow(std::clamp((n_dot_l + 1) / 2, 0.0, 1.0), material.diffuse_exponent);
}

double specular_factor(const Material& material, const Vec3& n, const Vec3& wi, const Vec3& wo) {
  double cosine;
  if (material.specular_model == SpecularModel::blinn_phong) {
    const Vec3 half = wi + wo;
    if (length_squared(half) == 0) return 0;
    cosine = dot(n, normalize(half));
  } else {
    cosine = dot(reflect(-wi, n), wo);
  }
  cosine = std::clamp(cosine, 0.0, 1.0);
  // cosine^s <= exp(-s (1 - cosine)): far from the highlight that is nothing, and needs no power.
  constexpr double kNothing = 50;  // exp(-50) < 2e-22
  if (material.shininess * (1 - cosine) > kNothing) return 0;
  return portable::pow(cosine, material.shininess);
}

}  // namespace

Color reflected_share(const Material& material, const Color& diffuse, const Vec3& n, const Vec3& wi,
                      const Vec3& wo) {
  const double n_dot_l = dot(n, wi);
  Color share = diffuse * diffuse_factor(material, n_dot_l);
  if (n_dot_l > 0 && !is_black(material.specular)) {
    share += material.specular * specular_factor(material, n, wi, wo);
  }
  return share;
}

double fresnel_dielectric(double cos_i, double eta) {
  const double sin2_t = (1 - cos_i * cos_i) / (eta * eta);
  if (sin2_t >= 1) return 1;
  const double cos_t = std::sqrt(1 - sin2_t);
  const double parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const double perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return (parallel * parallel + perpendicular * perpendicular) / 2;
}

bool refract(const Vec3& d, const Vec3& n, double eta, Vec3& out) {
  const double cos_i = -dot(d, n);
  const double sin2_t = (1 - cos_i * cos_i) / (eta * eta);
  if (sin2_t >= 1) return false;
  out = normalize(d / eta + n * (cos_i / eta - std::sqrt(1 - sin2_t)));
  return true;
}

Color transmittance(const Color& absorption, double distance) {
  return {portable::exp(-absorption.r * distance), portable::exp(-absorption.g * distance),
          portable::exp(-absorption.b * distance)};
}

}  // namespace tessera
