#pragma once

#include <cstddef>
#include <cstdint>

#include "renderer/shapes/convex_polygon.h"

namespace tessera {

/// Up to 16 rectangles in world space, which a ray is held against all at once: nearly always that
/// tells which of them it meets inside of their edges. The exact test of `Rectangle` is left for
/// those that it meets close to an edge. What is told has the exact test's answer: the margins are
/// far above the rounding of both.
struct RectangleSoA {
  static constexpr size_t kMost = 16;
  /// Beside the bits of rectangles: the ray is such that any may be hit, and may be none at all.
  static constexpr uint32_t kUnusual = 1u << 31;
  /// Of the extent of all: what is nearer to an edge than this is not told for sure.
  static constexpr double kMargin = 1e-7;
  /// Cosine below which nothing is.
  static constexpr double kGrazing = 1e-6;

  /// A ray's direction, the parts added up, within which answers count.
  static constexpr double kLeastSteep = 1e-100, kMostSteep = 1e100;

  /// Whether its numbers are far from the ends of the range of double.
  static bool can_hold(const Rectangle& rectangle);
  /// One more that it can hold: at most kMost. Call finish() after the last.
  void add(const Rectangle& rectangle);
  void finish();

  // An axis each. A point is inside where its shares of the edges are: its dot products with
  // `share_u` and `share_v`, from the corner.
  alignas(32) double corner[3][kMost] = {}, normal[3][kMost] = {};
  alignas(32) double share_u[3][kMost] = {}, share_v[3][kMost] = {};
  alignas(32) double grazing[kMost] = {};  ///< by the normal's length
  /// From the middle, as shares: inside for sure below the first, outside above the other.
  alignas(32) double in_u[kMost] = {}, in_v[kMost] = {}, out_u[kMost] = {}, out_v[kMost] = {};
  int axis[kMost] = {};  ///< along which the normal is; -1: along none
  size_t count = 0;      ///< rounded up to a whole number of vectors
  uint32_t all = 0;      ///< a bit for each rectangle
  double extent = 0;     ///< greatest coordinate
  double farthest = 0;   ///< of an origin, the parts added up: beyond it all are tested
};

/// Which rectangles a ray may hit, a bit each.
struct RectanglesMet {
  uint32_t maybe = 0;   ///< all that the exact test could find
  uint32_t inside = 0;  ///< those that it finds if the ray crosses their plane within its stretch
};

}  // namespace tessera
