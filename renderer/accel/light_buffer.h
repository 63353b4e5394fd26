#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "renderer/accel/box_soa.h"
#include "renderer/accel/traversal_tree.h"
#include "renderer/shapes/surface_interaction.h"

namespace tessera {

/// Which of some boxes are in the way of a light: of those seen from it towards a point, found by
/// a look-up in place of a test of each (Haines and Greenberg, The Light Buffer, 1986). Immutable;
/// thread-safe.
class LightBuffer {
 public:
  /// Of a light at `place`.
  static LightBuffer of_place(const BoxSoA& boxes, const Point3& place);
  /// Of a light that comes along `direction`, which is of unit length.
  static LightBuffer of_direction(const BoxSoA& boxes, const Vec3& direction);

  /// Whether boxes_met() can answer for all rays that leave the surface there: they start no
  /// farther off than half of what boxes are grown by.
  /// Also a lane each in whitted_wavefront-inl.h, bit for bit.
  static bool has_answers(const BoxSoA& boxes, const SurfaceInteraction& from) {
    const double error = l1_norm(from.point_error + abs(from.smooth_shift));
    return l1_norm(from.point - Point3{}) + kErrorShare * error <= boxes.farthest;
  }
  /// Whether the light is at a place, so that a direction tells the boxes; else a point does.
  bool is_of_place() const { return is_place_; }
  /// A bit for each box that rays may hit something in which leave the surface at `point` for the
  /// light, in direction `wi` of unit length and so far away.
  /// light_lanes-inl.h has the same for lanes, with the same bits.
  uint32_t boxes_met(const Point3& point, const Vec3& wi, double distance) const {
    if (!is_place_) return met_along(point - Point3{});
    if (!(distance > kLeastDistance)) [[unlikely]]
      return all_;
    return met_towards(wi);
  }

  // The parts of has_answers(), and of boxes_met() by direction, for many at once.
  /// A point is off by its error, and rays that are lifted off it by as much again: that is to be
  /// half of what boxes are grown by at most.
  static constexpr double kErrorShare = 4 / BoxMargin::kUsual;
  /// So near a light, far above where the square of the distance underflows, its direction is still
  /// one; nearer it tells nothing.
  static constexpr double kLeastDistance = 1e-100;
  /// Cells along each edge of a face.
  static constexpr int kSide = 32;
  /// The most that the smaller parts of a direction can be, and a little.
  static constexpr double kEdge = 0.70711;

  /// A place on a face as `part` of a direction, its smaller ones, in cells.
  static constexpr double kCellsPerPart = kSide / (2 * kEdge);
  /// That of a cell (face * kSide + row) * kSide + column; the face is the axis of the largest part
  /// twice, and one more where that is negative.
  uint32_t boxes_of_cell(size_t cell) const { return cells_[cell]; }
  uint32_t all_boxes() const { return all_; }

 private:
  /// A range of places on a face.
  struct Range {
    double low, high;
  };

  explicit LightBuffer(const BoxSoA& boxes) : all_(boxes.all) {}

  uint32_t met_towards(const Vec3& d) const {
    const double x = std::abs(d.x), y = std::abs(d.y), z = std::abs(d.z);
    if (x > y && x > z) return at(d.x < 0, cell(d.y), cell(d.z));
    if (y > z) return at(2 + (d.y < 0), cell(d.z), cell(d.x));
    return at(4 + (d.z < 0), cell(d.x), cell(d.y));
  }
  uint32_t met_along(const Vec3& p) const {
    const double column = (dot(p, right_) - least_.x) * scale_.x;
    const double row = (dot(p, down_) - least_.y) * scale_.y;
    if (!(column >= 0 && column < kSide && row >= 0 && row < kSide)) return 0;
    return at(0, static_cast<int>(column), static_cast<int>(row));
  }
  static double place_of(double part) { return (part + kEdge) * kCellsPerPart; }
  static int cell(double part) { return static_cast<int>(place_of(part)); }
  static size_t index_of(int face, int column, int row) {
    const int index = (face * kSide + row) * kSide + column;
    return static_cast<size_t>(index);
  }
  uint32_t at(int face, int column, int row) const { return cells_[index_of(face, column, row)]; }
  void add(uint32_t box, int face, const Range& columns, const Range& rows);

  bool is_place_ = true;
  uint32_t all_;
  Vec3 right_, down_;            ///< of a direction: what a point's cell is measured along
  Vec2 least_, scale_;           ///< of a direction: from there to cells
  std::vector<uint16_t> cells_;  ///< a bit a box; by face (+x, -x, +y, ...), row and column
};

}  // namespace tessera
