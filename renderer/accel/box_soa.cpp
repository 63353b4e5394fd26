#include "renderer/accel/box_soa.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "renderer/accel/traversal_tree.h"

namespace tessera {

BoxSoA::BoxSoA(std::span<const Bounds3> boxes) {
  TESSERA_CHECK(boxes.size() <= kMost, "more boxes than fit");
  constexpr size_t kLanes = 4, kFar = 6;
  double extent = 0;
  for (const Bounds3& box : boxes)
    for (int a = 0; a < 3; ++a)
      extent = std::max({extent, std::abs(box.min[a]), std::abs(box.max[a])});
  count = (boxes.size() + kLanes - 1) / kLanes * kLanes;
  all = (1u << boxes.size()) - 1;
  farthest = kFar * extent;
  const double margin = farthest * BoxMargin{}.space;
  for (size_t i = 0; i < count; ++i) {
    const bool is_box = i < boxes.size();
    for (int a = 0; a < 3; ++a) {
      min[a][i] = is_box ? boxes[i].min[a] - margin : Bounds3::kInfinity;
      max[a][i] = is_box ? boxes[i].max[a] + margin : Bounds3::kInfinity;
    }
  }
}

}  // namespace tessera
