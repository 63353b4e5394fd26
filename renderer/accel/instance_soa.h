#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "renderer/accel/box_soa.h"
#include "renderer/accel/plane_soa.h"
#include "renderer/accel/ray_batch.h"
#include "renderer/accel/rectangle_soa.h"
#include "renderer/accel/sphere_soa.h"
#include "renderer/shapes/carved_box.h"

namespace tessera {

/// A few instances, by kind, as structures of arrays.
struct InstanceSoA {
  RectangleSoA rectangles;
  std::array<uint32_t, RectangleSoA::kMost> rectangle_instances{};  ///< ascending
  /// Rectangles that rays see from there, a bit each.
  uint32_t seen_from_front = 0, seen_from_behind = 0;
  uint32_t shading_rectangles = 0, shading_planes = 0;  ///< those that cast shadows, a bit each
  PlaneSoA planes;
  std::array<uint32_t, PlaneSoA::kMost> plane_instances{};  ///< ascending
  BoxSoA boxes;
  SphereSoA spheres;          ///< in some of the boxes
  uint32_t carved_boxes = 0;  ///< a bit for each of the boxes that holds one, seen from both sides
  std::array<CarvedBox, BoxSoA::kMost> carved;  ///< by box

  /// Of every ray, whatever boxes it enters.
  size_t tests_of_each() const {
    return planes.count + static_cast<size_t>(std::popcount(rectangles.all));
  }
};

/// What each ray of a batch meets first of a few planes, rectangles and spheres, or of those that
/// cast shadows, and what else it may, by BvhKernels::intersect_batch.
struct BatchHits {
  alignas(64) double t[RayBatch::kMost];         ///< infinite where nothing is met
  alignas(64) double instance[RayBatch::kMost];  ///< of equal ones the smallest
  /// A bit for each box of other things that is entered before that, or BoxSoA::kUnusual too: there
  /// the rest says nothing.
  alignas(64) int64_t boxes[RayBatch::kMost];
  alignas(64) double entered[BoxSoA::kMost][RayBatch::kMost];  ///< lower bounds of t in those boxes
  uint64_t tests = 0;  ///< of planes, rectangles and spheres
};

}  // namespace tessera
