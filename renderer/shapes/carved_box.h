#pragma once

#include <vector>

#include "renderer/math/bounds.h"

namespace tessera {

/// A box from which spheres are taken away.
struct CarvedBox {
  struct Hole {
    Point3 center;
    double radius;
  };
  /// What is so near to where a line touches a sphere is in doubt, in the origin's and the way's
  /// sizes: far more than its rounding, which is half of the digits.
  static constexpr double kDoubt = 0x1p-20;

  Bounds3 box;
  std::vector<Hole> holes;
};

}  // namespace tessera
