#pragma once

#include <algorithm>

#include "renderer/math/vec.h"

namespace tessera {

// What becomes of a view that a smooth normal or a relief sends into the surface that it stands
// for. All vectors are of unit length; `facet` is the surface's own normal, turned towards the
// viewer at `wo`, and `shading` may point anywhere.

/// A mirrored view leaves the surface at least at this height, or at half of its own.
inline constexpr double kLeastMirrored = 0.01;

/// The normal of facets, mirrors and glass: `shading`, unless that faces away from the viewer or
/// mirrors the view into the surface. Then it is tilted towards the viewer until the mirrored view
/// all but grazes the surface (Keller et al. 2017, "The Iray Light Transport Simulation and
/// Rendering System", appendix A).
inline Vec3 clamped_normal(const Vec3& shading, const Vec3& facet, const Vec3& wo) {
  constexpr double kLeastCosine = 1e-3;
  const Vec3 mirrored = reflect(-wo, shading);
  const double below = std::min(dot(wo, facet) / 2, kLeastMirrored) - dot(mirrored, facet);
  if (!(below > 0)) return dot(shading, wo) < 0 ? -shading : shading;
  const Vec3 grazing = mirrored + shading * (below / std::max(dot(shading, facet), kLeastCosine));
  const Vec3 half = wo + normalize(grazing);
  return length_squared(half) > 0 ? normalize(half) : facet;
}

/// A direction that leaves the surface on the wrong side, mirrored at it; others as they are.
inline Vec3 reflected_to_side(const Vec3& direction, const Vec3& facet, bool is_transmitted) {
  const double side = dot(direction, facet);
  return (is_transmitted ? side > 0 : side < 0) ? reflect(direction, facet) : direction;
}

/// The way on, of unit length, of a view that an ideal mirror of that clamped_normal() reflects.
inline Vec3 mirror_direction(const Vec3& normal, const Vec3& facet, const Vec3& wo) {
  return normalize(reflected_to_side(reflect(-wo, normal), facet, false));
}

}  // namespace tessera
