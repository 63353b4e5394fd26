#include "renderer/shapes/closed_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>

namespace tessera {
namespace {

/// Boxes inside each other.
TriangleMesh shells(int count) {
  TriangleMesh mesh;
  for (int i = 1; i <= count; ++i) {
    const float r = 1e36f * static_cast<float>(i);
    const auto base = static_cast<uint32_t>(mesh.positions.size());
    for (int c = 0; c < 8; ++c)
      mesh.positions.push_back({c & 1 ? r : -r, c & 2 ? r : -r, c & 4 ? r : -r});
    for (const std::array<uint32_t, 4>& q : {std::array<uint32_t, 4>{0, 2, 3, 1},
                                             {4, 5, 7, 6},
                                             {0, 1, 5, 4},
                                             {2, 6, 7, 3},
                                             {0, 4, 6, 2},
                                             {1, 3, 7, 5}}) {
      mesh.triangles.push_back({base + q[0], base + q[1], base + q[2]});
      mesh.triangles.push_back({base + q[0], base + q[2], base + q[3]});
    }
  }
  return mesh;
}

TEST(ClosedMesh, CrossingsThatAreNotNumbersHaveAPlaceInTheOrder) {
  const ClosedMesh mesh(std::make_shared<const TriangleMesh>(shells(100)));
  // It leaves the shells by faces along its own direction, whose corners are ahead and behind.
  const Vec3 direction{1, 0.1, 1.01};
  for (const double slow : {1.0, 1e-100, 1e-290}) {
    std::vector<SolidEvent> events;
    mesh.crossings({{2e36, 0, 0}, direction * slow}, {}, events);
    EXPECT_GE(events.size(), 190u);
    const auto has_no_number = [](const SolidEvent& e) { return std::isnan(e.t); };
    // In units of the slowest, distances are out of range.
    EXPECT_EQ(std::ranges::any_of(events, has_no_number), slow < 1e-200);
    const auto is_before = [](const SolidEvent& a, const SolidEvent& b) {
      const std::weak_ordering order = std::weak_order(a.t, b.t);
      return order != 0 ? order < 0 : a.primitive < b.primitive;
    };
    EXPECT_TRUE(std::ranges::is_sorted(events, is_before)) << slow;
  }
}

}  // namespace
}  // namespace tessera
