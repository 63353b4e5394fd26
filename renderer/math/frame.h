#pragma once

#include <cmath>

#include "renderer/math/vec.h"

namespace tessera {

/// Three unit vectors square to each other, `z` given (Duff et al. 2017, "Building an Orthonormal
/// Basis, Revisited", JCGT 6(1)).
struct Frame {
  Vec3 x, y, z;

  explicit Frame(const Vec3& unit_z) : z(unit_z) {
    const double sign = std::copysign(1.0, z.z);
    const double a = -1 / (sign + z.z);
    const double b = z.x * z.y * a;
    x = {1 + sign * z.x * z.x * a, sign * b, -sign * z.x};
    y = {b, sign + z.y * z.y * a, -z.y};
  }
  Vec3 to_local(const Vec3& v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  /// Also a lane each in lane_lambert-inl.h, to the bit.
  Vec3 from_local(const Vec3& v) const { return x * v.x + y * v.y + z * v.z; }
};

}  // namespace tessera
