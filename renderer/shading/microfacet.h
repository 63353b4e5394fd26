#pragma once

#include "renderer/math/color.h"
#include "renderer/math/vec.h"

namespace tessera {

// The GGX distribution of microfacets (Walter et al. 2007) with Smith's height-correlated shadowing
// (Heitz 2014). `alpha` is roughness squared.

/// Rougher than this a highlight has a size that a light without extent can be seen in.
inline constexpr double kSmoothestHighlight = 0.045;

/// pi * D * G / (4 (n.l) (n.v)): what the Fresnel factor and n.l make the specular share. All
/// vectors of unit length, n.l and n.v > 0.
double microfacet_share(double alpha, const Vec3& n, const Vec3& wi, const Vec3& wo,
                        const Vec3& half);

/// The same distribution in a frame whose z is the normal, for sampling it.
class Ggx {
 public:
  /// `alpha` in (0, 1].
  explicit Ggx(double alpha) : alpha_(alpha) {}

  /// Facets of normal `h` per unit of the surface and of solid angle.
  double distribution(const Vec3& h) const;
  /// The share of facets seen from `w` that nothing hides.
  double masking(const Vec3& w) const { return 1 / (1 + lambda(w)); }
  /// The share seen from both sides at once: `wi` and `wo` before the surface, or one beyond it.
  double shadowing(const Vec3& wi, const Vec3& wo) const {
    return 1 / (1 + lambda(wi) + lambda(wo));
  }
  /// A facet's normal as seen from `wo`, wo.z > 0 (Dupuy and Benyoub 2023, "Sampling Visible GGX
  /// Normals with Spherical Caps").
  Vec3 sample_visible(const Vec3& wo, const Vec2& u) const;

 private:
  double lambda(const Vec3& w) const;

  double alpha_;
};

/// How much of evenly arriving light rough facets send towards cosine `cosine` by one reflection,
/// with Schlick's Fresnel factor of f0: scale * f0 + bias. From a table worked out once, to about
/// a thousandth; the rest of what they receive is reflected several times.
struct FacetAlbedo {
  double scale = 1, bias = 0;
  double of_white() const { return scale + bias; }
  Color of(const Color& f0) const { return f0 * scale + kWhite * bias; }
};
FacetAlbedo facet_albedo(double alpha, double cosine);
/// Its mean over the hemisphere, by the cosine.
FacetAlbedo mean_facet_albedo(double alpha);

/// Schlick's approximation (1994) from the share `f0` at normal incidence.
Color fresnel_schlick(const Color& f0, double cosine);

}  // namespace tessera
