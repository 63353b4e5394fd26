#pragma once

#include <cstdint>
#include <limits>

#include "renderer/math/vec.h"

namespace tessera {

/// Which sides of a surface a ray can hit.
enum class Cull : uint8_t { none, back, front };

/// Points origin + t * direction for t_min < t < t_max. The direction need not be of unit length,
/// so that a transformed ray keeps its t.
struct Ray {
  Point3 origin;
  Vec3 direction;
  double t_min = 0;
  double t_max = std::numeric_limits<double>::infinity();
  Cull cull = Cull::none;

  Point3 at(double t) const { return origin + direction * t; }
};

/// Where a ray met a surface, and no more: 40 bytes. Of hits at equal t the one with the smaller
/// (instance, primitive) counts, whatever the accelerator.
struct Hit {
  double t = std::numeric_limits<double>::infinity();
  double u = 0;  ///< surface parameters; barycentric weights of vertices 1 and 2 of a
  double v = 0;  ///< triangle
  uint32_t instance = 0;
  uint32_t primitive = 0;  ///< within the shape: a triangle's number, a box's face

  friend bool operator==(const Hit&, const Hit&) = default;
};

}  // namespace tessera
