#pragma once

#include "renderer/math/color.h"
#include "renderer/math/vec.h"

namespace tessera {

// A lobe is one way in which a surface sends light on, seen from one side at one point: a value
// with these members. Directions are of unit length, in the frame whose z is the normal of facets,
// and lead away from the point; wo, to the viewer, has wo.z > 0 unless the surface scatters evenly
// alone. `is_transmitted` says that wi leaves on the surface's other side.
//
//   double sampling_weight() const
//     About the share of light that it sends to the viewer, >= 0: how often it is chosen.
//   bool is_specular() const
//     Whether it sends light in single directions: then evaluate() is not asked.
//   BsdfValue evaluate(const Vec3& wi, bool is_transmitted) const
//     BSDF * |cosine|, and the density with which sample() chooses wi, per steradian.
//   bool sample(double choice, const Vec2& u, LobeSample& sample) const
//     `choice` and `u` are uniform in [0, 1). False where the path ends.
//
// What it gives back, over all directions and together with the other lobes of its material, is no
// more than it gets, and the same from either end (Helmholtz). A new lobe is a file, a line in
// lobes.h, and where lobes.cpp makes it of a material.

/// A direction that a lobe chose.
struct LobeSample {
  Vec3 wi;
  bool is_transmitted = false;
  /// Of a mirror, and of a lobe that its density cancels from: BSDF * |cosine| / density.
  Color weight = kBlack;
  double radiance_scale = 1;  ///< what of BSDF * |cosine| only says that radiance is denser there
};

}  // namespace tessera
