#include <algorithm>
#include <cmath>

#include "renderer/shading/lobes.h"

namespace tessera {
namespace {

Color operator/(const Color& a, double b) { return a * (1 / b); }

bool bends(double eta) { return std::abs(eta - 1) > 1e-4; }

template <class OneLobe, class... Parts>
void add(Lobes& lobes, const Parts&... parts) {
  lobes.emplace_back(std::in_place_type<OneLobe>, parts...);
}

GlassSide glass_of(const BsdfPoint& point, const Vec3& wo, double share) {
  GlassSide glass;
  glass.wo = wo;
  glass.from_inside = point.from_inside;
  glass.is_thin = point.material.thin;
  const double index = point.material.refractive_index;
  glass.eta = point.from_inside && !glass.is_thin ? 1 / index : index;
  glass.share = share;
  return glass;
}

/// What bends nothing has no facets to be seen.
void add_glass(const GlassSide& glass, double alpha, const GlassAlbedo* albedo, Lobes& lobes) {
  if (alpha > 0 && bends(glass.eta)) {
    add<RoughGlassLobe>(lobes, glass, alpha, albedo);
  } else {
    add<SmoothGlassLobe>(lobes, glass);
  }
}

/// A mirror, if `share` of light is not nothing after what is above it has dimmed it by `below`.
void add_mirror(const Vec3& wo, const Color& share, double below, Lobes& lobes) {
  if (!is_black(share)) add<MirrorLobe>(lobes, wo, share * below, max_component(share) * below);
}

/// How often facets that reflect `share` of their light are chosen.
double facet_weight(const Color& share, const FacetAlbedo& towards_viewer) {
  return std::max(max_component(share) * towards_viewer.of_white(), 1e-3);
}

Lobes classic_lobes(const BsdfPoint& point, const Vec3& wo, const Vec3& normal) {
  const Material& material = point.material;
  const double through = material.refracted();
  const Color kept_diffuse = point.diffuse * (1 - through);
  const double all =
      max_component(kept_diffuse + material.specular + material.reflectivity) + through;
  const double scale = all > 1 ? 1 / all : 1;
  const Color base = kept_diffuse * scale;
  Lobes lobes;
  if (is_black(material.specular)) {
    if (!is_black(base)) add<DiffuseLobe>(lobes, base, normal);
  } else {
    // Facets that reflect the same at every angle, and as much of what goes on between them.
    const Facets facets{std::min(std::sqrt(2 / (material.shininess + 2)), 1.0)};
    const FacetReflectance reflectance{FacetReflectance::Kind::even, material.specular * scale};
    const double lost = 1 - facets.mean().of_white();
    const Color between = lost > kLeastLost ? reflectance.f0 / lost : kBlack;
    const FacetAlbedo facets_o = facets.towards(wo.z);
    if (!is_black(base) || !is_black(between))
      add<DiffuseLobe>(lobes, base, between, normal,
                       DiffuseLobe::Above{.facets = facets, .facets_o = facets_o});
    add<MicrofacetLobe>(lobes, wo, facets.alpha, reflectance, 1.,
                        facet_weight(reflectance.f0, facets_o));
  }
  add_mirror(wo, material.reflectivity * scale, 1, lobes);
  if (through > 0) add_glass(glass_of(point, wo, through * scale), 0, nullptr, lobes);
  return lobes;
}

/// What of a physical material is no glass: `metal` of the surface, and the dielectric `share` that
/// has the base colour under it.
void add_metal_and_plastic(const Material& material, const Color& color, double metal,
                           double dielectric, Facets facets, const Coating& coat, const Vec3& wo,
                           const Vec3& normal, Lobes& lobes) {
  const double kept = metal + dielectric;
  const double r = (material.refractive_index - 1) / (material.refractive_index + 1), f0 = r * r;
  const Color dielectric_between = facets.between(kWhite * f0);
  const FacetAlbedo facets_o = facets.towards(wo.z), mean = facets.mean();
  DiffuseLobe::Above above{.facets = facets,
                           .facets_o = facets_o,
                           .leaves_less = true,
                           .under = {f0, dielectric_between.r * (1 - mean.of_white())},
                           .coat = coat};
  above.coat_over_base = coat.mean_passed(above.under);
  above.coat_over_between = coat.mean_passed({1, 0});
  const double left = above.under.left(mean);
  const Color base = left > kLeastLost ? color * (dielectric / left) : kBlack;
  const Color between = facets.between(color) * metal + dielectric_between * dielectric;
  if (!is_black(base) || !is_black(between)) add<DiffuseLobe>(lobes, base, between, normal, above);
  const FacetReflectance reflectance{FacetReflectance::Kind::schlick,
                                     (kWhite * (f0 * dielectric) + color * metal) / kept};
  const Color towards_viewer = reflectance.at(wo.z) * kept;
  if (facets.alpha > 0) {
    const double weight = facet_weight(towards_viewer * coat.below(), facets_o);
    add<MicrofacetLobe>(lobes, wo, facets.alpha, reflectance, kept, weight,
                        CoatOverFacets{coat, dielectric, f0});
  } else {
    add_mirror(wo, towards_viewer, coat.below(), lobes);
  }
}

Lobes physical_lobes(const BsdfPoint& point, const Vec3& wo, const Vec3& normal) {
  const Material& material = point.material;
  const Color color = bounded(point.diffuse);
  const double metal = material.metallic, through = material.transparency * (1 - metal);
  GlassSide glass = glass_of(point, wo, through);
  glass.tint = color;
  const Facets facets{facet_alpha(material.roughness)};
  if (material.clearcoat > 0) {
    const bool has_facets = through < 1 || bends(glass.eta);
    glass.coat = Coating(material.clearcoat, facet_alpha(material.clearcoat_roughness),
                         point.from_inside && through > 0 && !glass.is_thin,
                         has_facets ? facets : Facets{}, wo);
  }
  const Coating& coat = glass.coat;
  Lobes lobes;
  if (through < 1)
    add_metal_and_plastic(material, color, metal, 1 - through - metal, facets, coat, wo, normal,
                          lobes);
  if (coat.is_there() && !coat.viewer_is_under()) {
    const FacetReflectance reflectance{FacetReflectance::Kind::schlick, kWhite * kCoatReflectance};
    const double weight = 1 - coat.below();
    if (coat.alpha() > 0) {
      add<MicrofacetLobe>(lobes, wo, coat.alpha(), reflectance, coat.share(), weight);
    } else {
      add<MirrorLobe>(lobes, wo, reflectance.at(wo.z) * coat.share(), weight);
    }
  }
  if (through > 0) add_glass(glass, facets.alpha, material.glass_albedo, lobes);
  return lobes;
}

Lobes conductor_lobes(const Material& material, const Vec3& wo, const Vec3& normal) {
  const Facets facets{facet_alpha(material.roughness)};
  const FacetReflectance reflectance{FacetReflectance::Kind::conductor, kBlack, material.eta,
                                     material.k};
  Lobes lobes;
  if (facets.alpha == 0) {
    add_mirror(wo, reflectance.at(wo.z), 1, lobes);
    return lobes;
  }
  const FacetAlbedo facets_o = facets.towards(wo.z);
  const Color between = facets.between(reflectance.at(1));
  if (!is_black(between))
    add<DiffuseLobe>(lobes, kBlack, between, normal,
                     DiffuseLobe::Above{.facets = facets, .facets_o = facets_o});
  add<MicrofacetLobe>(lobes, wo, facets.alpha, reflectance, 1.,
                      facet_weight(reflectance.at(wo.z), facets_o));
  return lobes;
}

}  // namespace

bool is_view_dependent(const Material& material) {
  return material.model != MaterialModel::classic || !is_black(material.specular) ||
         !is_black(material.reflectivity) || material.refracted() > 0;
}

Lobes lobes_of(const BsdfPoint& point, const Vec3& wo, const Vec3& normal) {
  Lobes lobes;
  if (!(wo.z > 0) && is_view_dependent(point.material)) return lobes;
  switch (point.material.model) {
    case MaterialModel::unlit:
      break;
    case MaterialModel::classic:
      return classic_lobes(point, wo, normal);
    case MaterialModel::physical:
      return physical_lobes(point, wo, normal);
    case MaterialModel::conductor:
      return conductor_lobes(point.material, wo, normal);
    case MaterialModel::dielectric:
      add_glass(glass_of(point, wo, 1), facet_alpha(point.material.roughness),
                point.material.glass_albedo, lobes);
      break;
  }
  return lobes;
}

}  // namespace tessera
