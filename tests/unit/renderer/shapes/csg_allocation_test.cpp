// Tracing a combination allocates nothing once the thread's scratch space has grown.
#include <gtest/gtest.h>

#include <cmath>

#include "renderer/shapes/box.h"
#include "renderer/shapes/csg_shape.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/torus.h"
#include "tests/unit/allocation_count.h"

namespace tessera {
namespace {

TEST(CsgShape, AllocatesNothingPerRay) {
  CsgTree tree;
  const auto ring = tree.add(std::make_shared<Torus>(1, 0.4));
  const auto rod =
      tree.add(std::make_shared<Cylinder>(0.3, 4), Transform(rotation({1, 0, 0}, 1.2)));
  const auto box = tree.add(std::make_shared<Box>(Bounds3{{0, -2, -2}, {2, 2, 2}}));
  const auto solid = tree.combine(CsgOperation::join, std::vector{ring, rod});
  const CsgShape shape(tree, tree.combine(CsgOperation::subtract, std::vector{solid, box}));
  size_t hits = 0;
  const auto trace = [&] {
    for (int i = 0; i < 1000; ++i) {
      const Ray ray{{std::sin(i) * 4, std::cos(1.7 * i) * 4, 3},
                    {-std::sin(i + 0.1) * 4, -std::cos(1.7 * i) * 4, -3}};
      Hit hit;
      TraversalCounters counters;
      if (!shape.closest_hit(ray, hit, counters)) continue;
      ++hits;
      shape.surface(ray, hit);
    }
  };
  trace();
  EXPECT_GT(hits, 100u);
  const size_t before = allocation_count();
  trace();
  EXPECT_EQ(allocation_count(), before);
}

}  // namespace
}  // namespace tessera
