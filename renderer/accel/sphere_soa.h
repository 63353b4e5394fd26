#pragma once

#include <cstddef>
#include <cstdint>

#include "renderer/accel/box_soa.h"
#include "renderer/shapes/sphere.h"

namespace tessera {

/// The spheres that boxes hold, in world space, by the places of those boxes: so that many
/// rays can be held against each by the arithmetic of Sphere::intersect(), to its bits.
struct SphereSoA {
  void set(size_t box, const Sphere& sphere, uint32_t number, Cull unseen, bool casts_shadow) {
    boxes |= 1u << box;
    if (casts_shadow) shading |= 1u << box;
    for (int a = 0; a < 3; ++a) center[a][box] = sphere.center()[a];
    radius[box] = sphere.radius();
    cull[box] = unseen;
    instance[box] = number;
  }

  uint32_t boxes = 0;    ///< a bit for each that holds a sphere
  uint32_t shading = 0;  ///< one that casts a shadow
  double center[3][BoxSoA::kMost], radius[BoxSoA::kMost];
  Cull cull[BoxSoA::kMost];  ///< the sides that no ray sees
  uint32_t instance[BoxSoA::kMost];
};

}  // namespace tessera
