#pragma once

#include "renderer/math/color.h"
#include "renderer/shading/microfacet.h"

namespace tessera {

/// Fractions of light below this count as none.
inline constexpr double kLeastLost = 1e-9;

/// The alpha of facets of a roughness in [0, 1]; 0, a mirror, for the smoothest.
double facet_alpha(double roughness);

/// GGX facets that reflect once, and what they send on to each other.
struct Facets {
  double alpha = 0;  ///< in [0, 1]; 0: a mirror

  /// How much evenly arriving light they send towards `cosine`, in (0, 1].
  FacetAlbedo towards(double cosine) const;
  /// Its mean over the hemisphere, by the cosine.
  FacetAlbedo mean() const;
  /// What several reflections between them send on where one reflects `f0` at normal incidence, for
  /// a DiffuseLobe: over 1 - mean() (Kulla and Conty 2017, "Revisiting Physically Based Shading").
  Color between(const Color& f0) const;
};

/// What a dielectric's facets leave to what is under them.
struct UnderFacets {
  double f0 = 0;       ///< their reflectance at normal incidence
  double between = 0;  ///< of what they lose, the share that comes out between them

  /// The fraction left in the direction, or on the mean, that `facets` is the albedo of.
  double left(const FacetAlbedo& facets) const {
    return 1 - facets.scale * f0 - facets.bias - between * (1 - facets.of_white());
  }
};

}  // namespace tessera
