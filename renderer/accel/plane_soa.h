#pragma once

#include <cstddef>
#include <cstdint>

#include "renderer/shapes/plane.h"

namespace tessera {

/// Up to 16 planes in world space, which a ray is held against all at once, by the arithmetic of
/// Plane::intersect() and so to its bits.
struct PlaneSoA {
  static constexpr size_t kMost = 16;  ///< a multiple of the lanes of every instruction set
  /// Fewer take less one by one.
  static constexpr size_t kLeast = 4;

  /// One more, whose sides that `cull` names are not seen by rays: at most kMost.
  void add(const Plane& plane, Cull cull);

  // What fills a vector up has no normal and meets no ray.
  alignas(64) double normal[3][kMost] = {}, offset[kMost] = {};
  size_t count = 0;
  uint32_t from_front = 0, from_behind = 0;  ///< a bit for each that is seen from there
};

}  // namespace tessera
