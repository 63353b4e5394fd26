#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "renderer/accel/box_row.h"
#include "renderer/shapes/ray.h"

namespace tessera {

/// Up to 64 rays part by part, for many at once: those that no side of a surface is hidden from and
/// that end at the same t. What is beyond `count` is not set.
struct RayRow {
  static constexpr size_t kMost = 64;
  /// So that a whole vector can be written behind the last.
  static constexpr size_t kRoom = kMost + 8;

  size_t count = 0;
  double t_min = 0, t_max = std::numeric_limits<double>::infinity();
  alignas(64) double origin[3][kRoom], direction[3][kRoom];

  Ray ray(size_t i) const {
    return {{origin[0][i], origin[1][i], origin[2][i]},
            {direction[0][i], direction[1][i], direction[2][i]},
            t_min,
            t_max};
  }
};

/// What each ray of a row may hit of a few planes and boxes, by BvhKernels::row_met.
struct RayRowMet {
  static constexpr double kNone = -1;  ///< no plane is met

  alignas(64) double plane_t[RayRow::kMost];  ///< infinite where none is met
  /// The place in the row of planes of the nearest, of equal ones the first.
  alignas(64) double plane[RayRow::kMost];
  /// A bit for each box that is entered before that, or BoxRow::kUnusual too: there the rest says
  /// nothing.
  alignas(64) int64_t boxes[RayRow::kMost];
  alignas(64) double entered[BoxRow::kMost][RayRow::kMost];  ///< lower bounds of t in those boxes
};

}  // namespace tessera
