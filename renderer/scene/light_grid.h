#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/math/bounds.h"
#include "renderer/shading/light.h"

namespace tessera {

/// The lights that may reach a point: of many whose light ends somewhere, most are far away. What
/// it leaves out gives exactly nothing there, since sample_light() says so: point and spot lights
/// of a radius, with no ambient part that goes farther. Immutable once built; thread-safe.
class LightGrid {
 public:
  LightGrid() = default;
  /// `indices` into `lights`, ascending. Where few lights end, all are taken to reach everywhere.
  LightGrid(std::span<const Light> lights, std::vector<uint32_t> indices);

  /// All of them, ascending.
  std::span<const uint32_t> all() const { return all_; }
  /// Whether at() tells of all, whatever the point.
  bool is_everywhere() const { return first_.empty(); }
  /// Those that may reach `p`, ascending.
  std::span<const uint32_t> at(const Point3& p) const {
    if (first_.empty()) return all_;
    return at_cell(p);
  }

 private:
  std::span<const uint32_t> at_cell(const Point3& p) const;
  void fill(std::span<const Light> lights);
  /// Calls `visit` with the number of each cell that the light may reach.
  template <typename Visit>
  void for_each_cell(const Light& light, const Visit& visit) const;

  std::vector<uint32_t> all_;
  std::vector<uint32_t> endless_;  ///< of all, those that reach everywhere
  Bounds3 box_;                    ///< outside of it only they do
  int side_ = 0;                   ///< cells of the box along each axis
  std::vector<uint32_t> first_;    ///< into lists_, one a cell and the end; empty: no cells
  std::vector<uint32_t> lists_;
};

}  // namespace tessera
