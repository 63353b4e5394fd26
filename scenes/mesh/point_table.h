#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace tessera {

/// Numbers points in the order of their first appearance; equal ones get one number. For formats
/// whose triangles bring their corners along. Time is constant a point.
class PointTable {
 public:
  PointTable() : slots_(kFirstSlots, kEmpty) {}

  uint32_t add(const std::array<float, 3>& point);
  /// x y z of each point; empties the table.
  std::vector<float> take() { return std::move(points_); }

 private:
  static constexpr uint32_t kEmpty = 0xFFFFFFFF;
  static constexpr size_t kFirstSlots = 1024;

  size_t find_slot(const float* point) const;
  void grow();

  std::vector<float> points_;
  std::vector<uint32_t> slots_;  ///< open addressing; a power of two, at most half full
};

}  // namespace tessera
