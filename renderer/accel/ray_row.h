#pragma once

#include <cstddef>
#include <limits>

#include "renderer/shapes/ray.h"

namespace tessera {

/// Up to 64 rays part by part, for many at once: those that no side of a surface is hidden from and
/// that end at the same t. What is beyond `count` is not set.
/// Elsewhere such rays are a packet, and those of one bounce, followed so, a wavefront.
/// RectangleRow, PlaneRow, BoxRow and SphereRow are the other side of it: primitives, one ray held
/// against many.
struct RayRow {
  static constexpr size_t kMost = 64;
  /// So that a whole vector can be written behind the last.
  static constexpr size_t kRoom = kMost + 8;

  size_t count = 0;
  double t_min = 0, t_max = std::numeric_limits<double>::infinity();
  /// Empties it, for rays from `from` to `to`.
  void begin(double from = 0, double to = std::numeric_limits<double>::infinity()) {
    count = 0;
    t_min = from, t_max = to;
  }
  alignas(64) double origin[3][kRoom], direction[3][kRoom];

  Ray ray(size_t i) const {
    return {{origin[0][i], origin[1][i], origin[2][i]},
            {direction[0][i], direction[1][i], direction[2][i]},
            t_min,
            t_max};
  }
};

}  // namespace tessera
