#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "base/uninitialized.h"
#include "renderer/shapes/ray.h"

namespace tessera {

/// Up to 64 rays part by part, for many at once, which no side of a surface is hidden from. What is
/// beyond `count` is not set, but t_max.
struct RayBatch {
  static constexpr size_t kMost = 64;
  /// So that a whole vector can be written behind the last.
  static constexpr size_t kPadded = kMost + 8;

  size_t count = 0;
  double t_min = 0;
  alignas(64) double origin[3][kPadded], direction[3][kPadded], t_max[kPadded];

  /// Empties it, for rays from `from` to `to`, if t_max does not tell otherwise later.
  void begin(double from = 0, double to = std::numeric_limits<double>::infinity()) {
    count = 0;
    t_min = from;
    std::fill_n(t_max, kPadded, to);
  }
  Ray ray(size_t i) const {
    return {{origin[0][i], origin[1][i], origin[2][i]},
            {direction[0][i], direction[1][i], direction[2][i]},
            t_min,
            t_max[i]};
  }
};

/// Whether the rays are coherent: so much the same that boxes of a tree about `extent` large are
/// entered by most of them or by few, and a packet of them is faster than one ray after the other.
/// Where it is wrong, time is lost and no hit.
inline bool are_coherent(const RayBatch& rays, double extent) {
  constexpr size_t kLeast = 4;
  constexpr double kMostOfDirection = 1.0 / 16, kMostOfExtent = 1.0 / 16;
  if (rays.count < kLeast) return false;
  double longest = 0;
  for (const auto& part : rays.direction) longest = std::max(longest, std::abs(part[0]));
  const auto differ = [&](const double* part, double most) {
    bool any = false;
    for (size_t i = 1; i < rays.count; ++i) any |= !(std::abs(part[i] - part[0]) <= most);
    return any;
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (differ(rays.direction[axis], kMostOfDirection * longest) ||
        differ(rays.origin[axis], kMostOfExtent * extent))
      return false;
  }
  return true;
}

/// The rays one by one, in `room`.
inline std::span<const Ray> rays_of(const RayBatch& rays,
                                    Uninitialized<Ray, RayBatch::kMost>& room) {
  for (size_t i = 0; i < rays.count; ++i) room[i] = rays.ray(i);
  return {room.data(), rays.count};
}

}  // namespace tessera
