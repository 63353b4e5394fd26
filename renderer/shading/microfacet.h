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

/// Schlick's approximation (1994) from the share `f0` at normal incidence.
Color fresnel_schlick(const Color& f0, double cosine);

}  // namespace tessera
