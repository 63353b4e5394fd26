#include "renderer/shading/material.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"
#include "renderer/shading/microfacet.h"

namespace tessera {

namespace {

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

/// The reflectance at normal incidence of a physical material.
Color normal_reflectance(const Material& material, const Color& base) {
  const double r = (material.refractive_index - 1) / (material.refractive_index + 1);
  return kWhite * (r * r * (1 - material.metallic)) + base * material.metallic;
}

double highlight_alpha(double roughness) {
  const double r = std::max(roughness, kSmoothestHighlight);
  return r * r;
}

/// (1 - roughness)^2: see scene.proto, Physical.
double mirror_weight(double roughness) { return (1 - roughness) * (1 - roughness); }

/// What facets about `n` send from `wi` to `wo`, times the cosine of `wi`.
double facets_share(double alpha, const Vec3& n, const Vec3& wi, const Vec3& wo, const Vec3& half) {
  const double cosine = dot(n, wi);
  if (!(cosine > 0) || !(dot(n, wo) > 0)) return 0;
  return cosine * microfacet_share(alpha, n, wi, wo, half);
}

Color clearcoat_fresnel(const Material& material, double cosine) {
  return fresnel_schlick(kWhite * 0.04, cosine) * material.clearcoat;
}

Color physical_share(const Material& material, const Color& base, double n_dot_l,
                     const Vec3& facets, const Vec3& wi, const Vec3& wo, const Vec3& half) {
  const double h_dot_v = dot(half, wo);
  const Color fresnel = fresnel_schlick(normal_reflectance(material, base), h_dot_v);
  const double kept = (1 - material.metallic) * (1 - material.transparency);
  const auto off_facets = [&](double roughness) {
    return facets_share(highlight_alpha(roughness), facets, wi, wo, half);
  };
  Color share =
      (kWhite - fresnel) * base * (kept * n_dot_l) + fresnel * off_facets(material.roughness);
  if (material.clearcoat > 0) {
    const Color coat = clearcoat_fresnel(material, h_dot_v);
    share = share * (kWhite - coat) + coat * off_facets(material.clearcoat_roughness);
  }
  return share;
}

}  // namespace

Color any_reflected_share(const Material& material, const Color& diffuse, const Vec3& n,
                          const Vec3& facets, const Vec3& wi, const Vec3& wo) {
  const double n_dot_l = std::max(dot(n, wi), 0.0);
  if (n_dot_l == 0 && dot(facets, wi) <= 0) return kBlack;
  const Vec3 half = normalize(wi + wo);
  if (material.model == MaterialModel::physical) {
    return physical_share(material, diffuse, n_dot_l, facets, wi, wo, half);
  }
  if (material.roughness == 0) return kBlack;  // a mirror shows no light without extent
  const double h_dot_v = std::clamp(dot(half, wo), 0.0, 1.0);
  const Color fresnel = material.model == MaterialModel::conductor
                            ? fresnel_conductor(h_dot_v, material.eta, material.k)
                            : kWhite * fresnel_dielectric(h_dot_v, material.refractive_index);
  return fresnel * facets_share(highlight_alpha(material.roughness), facets, wi, wo, half);
}

Color mirrored_share(const Material& material, double cosine) {
  switch (material.model) {
    case MaterialModel::physical: {
      const Color under = fresnel_schlick(normal_reflectance(material, material.diffuse), cosine) *
                          ((1 - material.transparency) * mirror_weight(material.roughness));
      if (material.clearcoat == 0) return under;
      const Color coat = clearcoat_fresnel(material, cosine);
      return under * (kWhite - coat) + coat * mirror_weight(material.clearcoat_roughness);
    }
    case MaterialModel::conductor:
      return fresnel_conductor(cosine, material.eta, material.k);
    default:
      break;
  }
  return material.reflectivity;
}

Color albedo(const Material& material, const Color& diffuse) {
  switch (material.model) {
    case MaterialModel::unlit:
      return material.emission;
    case MaterialModel::classic: {
      const Color all = diffuse * (1 - material.transparency) + material.reflectivity +
                        kWhite * material.transparency;
      return {std::min(all.r, 1.0), std::min(all.g, 1.0), std::min(all.b, 1.0)};
    }
    case MaterialModel::physical:
      return diffuse;
    case MaterialModel::conductor:
      return fresnel_conductor(1, material.eta, material.k);
    case MaterialModel::dielectric:
      break;
  }
  return kWhite;
}

Color ambient_share(const Material& material, const Color& diffuse) {
  if (material.model != MaterialModel::physical) {
    return material.ambient_times_diffuse ? material.ambient * diffuse : material.ambient;
  }
  // What a smooth metal sends back is followed along its mirror direction.
  return diffuse *
         (material.occlusion * (1 - material.metallic * mirror_weight(material.roughness)));
}

double half_lambert(double n_dot_l, double exponent) {
  return portable::pow(std::clamp((n_dot_l + 1) / 2, 0.0, 1.0), exponent);
}

Color highlight(const Material& material, const Vec3& n, const Vec3& wi, const Vec3& wo) {
  return material.specular * specular_factor(material, n, wi, wo);
}

double fresnel_dielectric(double cos_i, double eta) {
  const double sin2_t = (1 - cos_i * cos_i) / (eta * eta);
  if (sin2_t >= 1) return 1;
  const double cos_t = std::sqrt(1 - sin2_t);
  const double parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const double perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return (parallel * parallel + perpendicular * perpendicular) / 2;
}

Color fresnel_conductor(double cos_i, const Color& eta, const Color& k) {
  const double cos2 = cos_i * cos_i, sin2 = 1 - cos2;
  const auto channel = [&](double n, double kappa) {
    const double t0 = n * n - kappa * kappa - sin2;
    const double a2_b2 = std::sqrt(t0 * t0 + 4 * n * n * kappa * kappa);
    const double a = std::sqrt(std::max(0.0, (a2_b2 + t0) / 2));
    const double sum = a2_b2 + cos2, cross = 2 * cos_i * a;
    const double perpendicular = (sum - cross) / (sum + cross);
    const double s = cos2 * a2_b2 + sin2 * sin2, t = cross * sin2;
    // Straight on both polarisations are alike.
    const double ratio = s + t > 0 ? (s - t) / (s + t) : 1;
    // Where the medium is as the one before it, rounding may say a little less than nothing.
    return std::max(0.0, (perpendicular + perpendicular * ratio) / 2);
  };
  return {channel(eta.r, k.r), channel(eta.g, k.g), channel(eta.b, k.b)};
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
