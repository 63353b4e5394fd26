#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "renderer/math/bounds.h"
#include "renderer/math/vec.h"

namespace tessera {

// What trees of lights and of parts of a light have in common: each node has two halves, one of
// which a number chooses by what they are worth.

/// Puts the half of `order` that lies lower along the longest side first; of an odd count that is
/// the smaller one. `center_of(i)` is where the light `i` lies; a coordinate that is not a number,
/// as of a light of infinite bounds, counts as 0.
template <typename CenterOf>
void halve(std::span<uint32_t> order, const CenterOf& center_of) {
  Bounds3 centers;
  for (const uint32_t light : order) centers.extend(center_of(light));
  const Vec3 size = centers.diagonal();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto key = [&](uint32_t light) {
    const double at = center_of(light)[axis];
    return std::pair(std::isnan(at) ? 0 : at, light);
  };
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(order.size() / 2),
                   order.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
}

/// The share of the first of two that are worth so much. None is given up for good.
inline double first_share(double first, double second) {
  const double share = first / (first + second);
  // Extremes of distance may leave no number: then halves.
  return share >= 0 ? std::clamp(share, 1e-4, 1 - 1e-4) : 0.5;
}

/// Whether `u`, uniform in [0, 1), chooses the first, of that share; what is left of the number
/// goes back into it.
inline bool chooses_first(double share, double& u) {
  const bool is_first = u < share;
  u = is_first ? u / share : (u - share) / (1 - share);
  u = std::min(u, 0x1.fffffffffffffp-1);
  return is_first;
}

}  // namespace tessera
