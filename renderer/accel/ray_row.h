#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "renderer/accel/box_row.h"
#include "renderer/accel/plane_row.h"
#include "renderer/accel/sphere_row.h"
#include "renderer/shapes/carved_box.h"
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

/// A few instances, in rows.
struct FewRows {
  PlaneRow planes;
  std::array<uint32_t, PlaneRow::kMost> plane_instances{};  ///< ascending
  BoxRow boxes;
  SphereRow spheres;          ///< in some of the boxes
  uint32_t carved_boxes = 0;  ///< a bit for each of the boxes that holds one, seen from both sides
  std::array<CarvedBox, BoxRow::kMost> carved;  ///< by box
};

/// What each ray of a row meets first of a few planes and spheres, and what else it may, by
/// BvhKernels::row_met.
struct RayRowMet {
  alignas(64) double t[RayRow::kMost];         ///< infinite where nothing is met
  alignas(64) double instance[RayRow::kMost];  ///< of equal ones the smallest
  /// A bit for each box of other things that is entered before that, or BoxRow::kUnusual too: there
  /// the rest says nothing.
  alignas(64) int64_t boxes[RayRow::kMost];
  alignas(64) double entered[BoxRow::kMost][RayRow::kMost];  ///< lower bounds of t in those boxes
  uint64_t tests = 0;                                        ///< of planes and spheres
};

}  // namespace tessera
