#pragma once

#include <cstdint>

namespace tessera {

/// A clear coat over a base: facets of its own that reflect 4 % at normal incidence (glTF 2.0,
/// KHR_materials_clearcoat), and what of the light under it gets out again. Light that the base
/// sends up against the coat comes down once more, so that a base which loses nothing loses nothing
/// under a coat either, and all factors are the same from either end. Of tables worked out once, in
/// some 50 ms, to a few thousandths; any thread. `alpha` in [0, 1], 0 being smooth; cosines in
/// [0, 1].
///
/// What a base scatters evenly is multiplied by
/// (1 - E(wi)) (1 - E(wo)) / (1 - mean of E), E being coat_albedo(); what it mirrors by 1 - E; what
/// its facets reflect by coated_facets(wi) coated_facets(wo), which lies between these two.

/// At normal incidence.
inline constexpr double kCoatReflectance = 0.04;

/// The share of evenly arriving light that the coat sends towards `cosine`.
double coat_albedo(double alpha, double cosine);

/// Facets under a coat: white, or such as reflect kCoatReflectance at normal incidence, which send
/// more of their light along the surface.
enum class CoatedFacets : uint8_t { white, dielectric };

/// Of facets of `base_alpha`: such that they reflect their share of what the coat lets in.
double coated_facets(CoatedFacets kind, double alpha, double base_alpha, double cosine);

/// Means of E over the hemisphere, by the cosine: of itself, and times what facets of `base_alpha`
/// under the coat reflect, as FacetAlbedo has it.
struct CoatMeans {
  double all = 0, scale = 0, bias = 0;
  friend CoatMeans operator+(const CoatMeans& a, const CoatMeans& b) {
    return {a.all + b.all, a.scale + b.scale, a.bias + b.bias};
  }
  friend CoatMeans operator*(const CoatMeans& a, double s) {
    return {a.all * s, a.scale * s, a.bias * s};
  }
};
CoatMeans coat_means(double alpha, double base_alpha);

}  // namespace tessera
