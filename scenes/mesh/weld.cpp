#include "scenes/mesh/weld.h"

#include <array>
#include <cmath>
#include <map>

#include "renderer/math/vec.h"

namespace tessera {

std::vector<uint32_t> weld(std::span<const float> points, double distance) {
  // Cells as wide as the distance: what is near lies in one of 27.
  using Cell = std::array<double, 3>;
  std::multimap<Cell, uint32_t> kept;
  const auto point = [&](uint32_t i) {
    return Point3{points[3 * size_t{i}], points[3 * size_t{i} + 1], points[3 * size_t{i} + 2]};
  };
  const auto first_near = [&](uint32_t i, const Cell& cell) {
    uint32_t first = i;
    for (int n = 0; n < 27; ++n) {
      const int x = n % 3 - 1, y = n / 3 % 3 - 1, z = n / 9 - 1;
      const Cell near{cell[0] + x, cell[1] + y, cell[2] + z};
      const auto [begin, end] = kept.equal_range(near);
      for (auto at = begin; at != end; ++at) {
        if (at->second < first && length(point(at->second) - point(i)) <= distance)
          first = at->second;
      }
    }
    return first;
  };
  std::vector<uint32_t> stands_for;
  stands_for.reserve(points.size() / 3);
  for (uint32_t i = 0; i < points.size() / 3; ++i) {
    const Point3 p = point(i);
    const Cell cell{std::floor(p.x / distance), std::floor(p.y / distance),
                    std::floor(p.z / distance)};
    const uint32_t first = first_near(i, cell);
    if (first == i) kept.emplace(cell, i);
    stands_for.push_back(first);
  }
  return stands_for;
}

}  // namespace tessera
