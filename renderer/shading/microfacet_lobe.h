#pragma once

#include <algorithm>
#include <cstdint>

#include "renderer/shading/coating.h"
#include "renderer/shading/facets.h"
#include "renderer/shading/lambert.h"
#include "renderer/shading/lobe.h"
#include "renderer/shading/material.h"

namespace tessera {

/// What facets reflect at the cosine to their normal, in [0, 1].
struct FacetReflectance {
  enum class Kind : uint8_t {
    even,      ///< f0 at every angle
    schlick,   ///< f0 at normal incidence, more at others by Schlick's factor
    conductor  ///< by the refractive index eta + i k
  };
  Kind kind = Kind::even;
  Color f0 = kBlack;
  Color eta = kWhite, k = kBlack;

  Color at(double cosine) const {
    if (kind == Kind::conductor) return fresnel_conductor(std::min(cosine, 1.0), eta, k);
    return kind == Kind::schlick ? fresnel_schlick(f0, cosine) : f0;
  }
};

/// A coat over facets dims metal otherwise than those of dielectrics: `dielectric` of the surface,
/// which reflect `dielectric_f0` at normal incidence.
struct CoatOverFacets {
  Coating coat{};
  double dielectric = 0, dielectric_f0 = 0;
};

/// Rough facets on a share of the surface, each of which reflects once: of a material, or of a coat
/// over it.
class MicrofacetLobe {
 public:
  /// `alpha` > 0; `weight` as below.
  MicrofacetLobe(const Vec3& wo, double alpha, const FacetReflectance& reflectance, double share,
                 double weight, const CoatOverFacets& over = {})
      : wo_(wo),
        alpha_(alpha),
        reflectance_(reflectance),
        share_(share),
        weight_(weight),
        over_(over) {}

  double sampling_weight() const { return weight_; }
  static constexpr bool is_specular() { return false; }
  BsdfValue evaluate(const Vec3& wi, bool is_transmitted) const {
    if (is_transmitted || !(wi.z > 0)) return {};
    const Vec3 half = normalize(wi + wo_);
    const Ggx ggx(alpha_);
    const double seen = ggx.distribution(half) * ggx.shadowing(wi, wo_) / (4 * wo_.z);
    return {fresnel(dot(wo_, half), wi.z) * seen, ggx.reflecting_density(wo_, half)};
  }
  bool sample(double, const Vec2& u, LobeSample& sample) const {
    const Vec3 half = Ggx(alpha_).sample_reflecting(wo_, u);
    sample.wi = half * (2 * dot(wo_, half)) - wo_;
    return sample.wi.z > 0;
  }

 private:
  /// What reaches the viewer of what a facet gets at `cosine` from light along `cos_i`.
  Color fresnel(double cosine, double cos_i) const {
    const Color all = reflectance_.at(cosine) * share_;
    if (!over_.coat.is_there() || over_.coat.viewer_is_under()) return all;
    const Color dielectric =
        fresnel_schlick(kWhite * over_.dielectric_f0, cosine) * over_.dielectric;
    return (all - dielectric) * over_.coat.over_facets(CoatedFacets::white, cos_i) +
           dielectric * over_.coat.over_facets(CoatedFacets::dielectric, cos_i);
  }

  Vec3 wo_;
  double alpha_;
  FacetReflectance reflectance_;
  double share_, weight_;
  CoatOverFacets over_;
};

}  // namespace tessera
