#pragma once

#include <algorithm>
#include <cmath>

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
  /// The share seen from both `wi` and `wo`, which are on one side.
  double shadowing(const Vec3& wi, const Vec3& wo) const {
    return 1 / (1 + lambda(wi) + lambda(wo));
  }
  /// The same where they are on either side: what stands high is deep for the other (Heitz et al.
  /// 2016, "Multiple-Scattering Microfacet BSDFs with the Smith Model").
  double shadowing_through(const Vec3& wi, const Vec3& wo) const;
  /// A facet's normal as seen from `wo`, wo.z > 0 (Dupuy and Benyoub 2023, "Sampling Visible GGX
  /// Normals with Spherical Caps").
  Vec3 sample_visible(const Vec3& wo, const Vec2& u) const;
  /// The same without most of those that would reflect `wo` into the surface (Eto and Tokuyoshi
  /// 2023, "Bounded VNDF Sampling for Smith-GGX Reflections").
  Vec3 sample_reflecting(const Vec3& wo, const Vec2& u) const;
  /// Its density, per steradian, of the direction that `h` reflects `wo` to; wo.z > 0.
  double reflecting_density(const Vec3& wo, const Vec3& h) const;

 private:
  double lambda(const Vec3& w) const;
  /// Of the stretched `wo.z`, how far down the cap goes.
  double bound(const Vec3& wo) const;
  Vec3 sample_cap(const Vec3& wo, const Vec2& u, double bound) const;

  double alpha_;
};

/// Calls `visit(ggx, wo, h, weight)` for facets of normal `h` as seen along `cosine`, by the share
/// of each in what is seen: kAround * kOut that lie well for integrals. Of alpha its root, in
/// [0, 1]; in a frame whose z is the normal.
template <int kAround, int kOut, typename Visit>
void for_each_visible_facet(double root_alpha, double cosine, const Visit& visit) {
  // Of 6 v (1 - v) over the middles of kOut steps.
  constexpr double kSum = kAround * (kOut + 0.5 / kOut);
  const Ggx ggx(std::max(root_alpha * root_alpha, 1e-4));
  const double c = std::max(cosine, 1e-3);
  const Vec3 wo{std::sqrt(1 - c * c), 0, c};
  for (int i = 0; i < kAround * kOut; ++i) {
    const int step = i / kAround, around = i % kAround;
    // Both sides of the plane of wo are alike. Few facets stand steep, and these lose the most:
    // the steps grow finer towards both ends.
    const double v = (step + 0.5) / kOut;
    const Vec3 h = ggx.sample_visible(wo, {(around + 0.5) / (2 * kAround), v * v * (3 - 2 * v)});
    visit(ggx, wo, h, 6 * v * (1 - v) / kSum);
  }
}

/// How much of evenly arriving light rough facets send towards cosine `cosine` by one reflection,
/// with Schlick's Fresnel factor of f0: scale * f0 + bias. From a table worked out once, to about
/// a thousandth; the rest of what they receive is reflected several times.
struct FacetAlbedo {
  double scale = 1, bias = 0;
  friend FacetAlbedo operator+(const FacetAlbedo& a, const FacetAlbedo& b) {
    return {a.scale + b.scale, a.bias + b.bias};
  }
  friend FacetAlbedo operator*(const FacetAlbedo& a, double s) { return {a.scale * s, a.bias * s}; }
  double of_white() const { return scale + bias; }
  Color of(const Color& f0) const { return f0 * scale + kWhite * bias; }
};
FacetAlbedo facet_albedo(double alpha, double cosine);
/// Its mean over the hemisphere, by the cosine.
FacetAlbedo mean_facet_albedo(double alpha);

/// Schlick's approximation (1994) from the share `f0` at normal incidence.
Color fresnel_schlick(const Color& f0, double cosine);

}  // namespace tessera
