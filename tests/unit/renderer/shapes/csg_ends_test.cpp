// Hits of carved solids, found by the ends of a line inside of what is carved, are the crossings
// that the sweep over all operands finds.
#include <gtest/gtest.h>

#include "renderer/math/rounding.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/csg_event.h"
#include "renderer/shapes/csg_shape.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/surface_interaction.h"
#include "tests/uniform_numbers.h"

namespace tessera {
namespace {

Point3 point(UniformNumbers& numbers, double reach) {
  const auto part = [&] { return numbers.between(-reach, reach); };
  return {part(), part(), part()};
}

CsgShape carved(UniformNumbers& numbers) {
  CsgTree tree;
  const double size = numbers.between(0.3, 1);
  std::shared_ptr<const Shape> first =
      std::make_shared<Box>(Bounds3{{-size, -1, -size}, {size, 0.7, size}});
  if (numbers.below(3) == 0) first = std::make_shared<Sphere>(Point3{}, size);
  std::vector<CsgTree::Node> nodes{tree.add(first)};
  for (size_t i = numbers.below(3) + 1; i > 0; --i) {
    const Point3 center = point(numbers, 1);
    const double radius = numbers.between(0.2, 1.4);
    if (numbers.below(4) == 0)
      nodes.push_back(tree.add(std::make_shared<Plane>(Vec3{0, 1, 0.2}, -0.4)));
    else
      nodes.push_back(tree.add(std::make_shared<Sphere>(center, radius)));
  }
  const bool subtracts = numbers.below(4) != 0;
  const auto operation = subtracts ? CsgOperation::subtract : CsgOperation::intersect;
  return CsgShape(tree, tree.combine(operation, nodes));
}

/// The first crossing that counts, by the sweep; infinite where there is none.
double first_hit(const CsgShape& shape, const Ray& ray) {
  std::vector<SolidEvent> events;
  shape.crossings(ray, {}, events);
  for (const SolidEvent& e : events)
    if (is_hit(ray, e.t, e.error, e.entering)) return e.t;
  return Bounds3::kInfinity;
}

void expect_hit(const CsgShape& shape, const Ray& ray, int64_t (&counts)[2]) {
  TraversalCounters counters;
  Hit hit;
  const bool found = shape.closest_hit(ray, hit, counters);
  ++counts[found];
  EXPECT_EQ(hit.t, first_hit(shape, ray));
  EXPECT_EQ(shape.any_hit(ray, counters), found);
}

TEST(CarvedSolids, EndsOfALineTellWhatTheSweepTells) {
  UniformNumbers numbers(9);
  int64_t counts[2] = {};
  for (int shapes = 0; shapes < 300; ++shapes) {
    const CsgShape shape = carved(numbers);
    for (int i = 0; i < 200; ++i) {
      // From outside, from inside of what is carved, and to a stop; at times seeing one side alone.
      Ray ray{point(numbers, i % 2 == 0 ? 1 : 3), {}};
      ray.direction = point(numbers, 0.7) - ray.origin;
      if (i % 3 == 0) ray.t_max = numbers.between(0, 1.5);
      if (i % 5 == 0) ray.cull = i % 10 == 0 ? Cull::back : Cull::front;
      expect_hit(shape, ray, counts);
      // And from its surface.
      Hit hit;
      TraversalCounters counters;
      if (!shape.closest_hit(ray, hit, counters)) continue;
      const SurfaceInteraction surface = to_world(shape.surface(ray, hit), {}, false, 0);
      expect_hit(shape, spawn_ray(surface, point(numbers, 1) - Point3{}), counts);
    }
  }
  EXPECT_GT(counts[0], 20000);
  EXPECT_GT(counts[1], 20000);
}

}  // namespace
}  // namespace tessera
