// Tracing a combination allocates nothing once the thread's scratch space has grown.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>

#include "renderer/shapes/box.h"
#include "renderer/shapes/csg_shape.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/torus.h"

namespace {
std::atomic<size_t> allocations = 0;
}

void* operator new(size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, size_t) noexcept { std::free(p); }

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
  const size_t before = allocations;
  trace();
  EXPECT_EQ(allocations, before);
}

}  // namespace
}  // namespace tessera
