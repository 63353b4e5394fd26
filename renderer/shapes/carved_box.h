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
  Bounds3 box;
  std::vector<Hole> holes;
};

}  // namespace tessera
