#include "renderer/accel/light_buffer.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>

#include "renderer/accel/few_instances.h"
#include "renderer/shapes/box.h"
#include "tests/uniform_numbers.h"

namespace tessera {
namespace {

/// Parts are often equal or nothing, as where faces of the table meet.
Vec3 vector(UniformNumbers& numbers, double reach) {
  const auto part = [&] { return numbers.between(-reach, reach); };
  Vec3 v{part(), part(), part()};
  const size_t kind = numbers.below(8);
  if (kind == 0) v.y = v.x;
  if (kind == 1) v.z = -v.x;
  if (kind == 2) v.x = v.y = v.z;
  if (kind == 3) v.z = 0;
  return v;
}

std::vector<Instance> some_instances(UniformNumbers& numbers) {
  std::vector<Instance> all;
  for (int i = 0; i < 10; ++i) {
    const Point3 center = Point3{} + vector(numbers, 4);
    const double size = numbers.between(0.05, 0.8);
    const Vec3 half{size, size * numbers.between(0.1, 1), size};
    if (i % 2 == 0)
      all.push_back({std::make_shared<Sphere>(center, size)});
    else
      all.push_back({std::make_shared<Box>(Bounds3{center - half, center + half})});
  }
  return all;
}

/// What `buffer` says of rays to a light, held against tests of all boxes; how many bits it sets.
int64_t compare(const FewInstances& few, const LightBuffer& buffer, const Ray& ray, const Vec3& wi,
                double distance) {
  const uint32_t boxes = buffer.boxes_met(ray.origin, wi, distance);
  TraversalCounters counters;
  const bool expected = few.any_hit(ray, counters);
  EXPECT_EQ(expected, few.any_hit_among(boxes, ray, counters));
  return std::popcount(boxes);
}

TEST(LightBuffer, LeavesOutNothingThatIsInTheWayOfAPlace) {
  UniformNumbers numbers(5);
  int64_t looked_at = 0, rays = 0;
  for (int scene = 0; scene < 40; ++scene) {
    const FewInstances few(some_instances(numbers));
    // Now and then inside of something, or in line with it.
    const Point3 place = Point3{} + vector(numbers, scene % 2 == 0 ? 4 : 40);
    const LightBuffer buffer = LightBuffer::of_place(few.boxes(), place);
    for (int i = 0; i < 2000; ++i) {
      const Point3 from = Point3{} + vector(numbers, 5);
      const Vec3 way = place - from;
      ++rays;
      looked_at += compare(few, buffer, {from, way, 0, 1}, normalize(way), length(way));
    }
  }
  EXPECT_LT(looked_at, 2 * rays);  // of ten
}

TEST(LightBuffer, LeavesOutNothingThatIsInTheWayOfADirection) {
  UniformNumbers numbers(5);
  int64_t looked_at = 0, rays = 0;
  for (int scene = 0; scene < 40; ++scene) {
    const FewInstances few(some_instances(numbers));
    const Vec3 wi = normalize(vector(numbers, 1) + Vec3{1e-9, 0, 0});
    const LightBuffer buffer = LightBuffer::of_direction(few.boxes(), -wi);
    for (int i = 0; i < 2000; ++i) {
      ++rays;
      looked_at +=
          compare(few, buffer, {Point3{} + vector(numbers, 9), wi}, wi, Bounds3::kInfinity);
    }
  }
  EXPECT_LT(looked_at, rays);
}

TEST(LightBuffer, LeavesOutNothingAmongTheSmallestBoxes) {
  // The scale from places to cells overflows, or sides and the rounding between them vanish.
  for (const double size : {1e-300, 1e-305, 1e-308, 1e-310, 5e-324}) {
    const Bounds3 first{{0, 0, 0}, {size, size, size}};
    const Bounds3 second{{-size, -size, size}, {0, 0, size}};
    const BoxSoA row(std::array{first, second});
    for (const Vec3& direction :
         {Vec3{1, 0, 0}, Vec3{0, -1, 0}, normalize(Vec3{1, 2, -3}), normalize(Vec3{1, 1, 1})}) {
      const LightBuffer buffer = LightBuffer::of_direction(row, direction);
      EXPECT_TRUE(buffer.boxes_met(first.max, -direction, Bounds3::kInfinity) & 1u) << size;
      EXPECT_TRUE(buffer.boxes_met(second.min, -direction, Bounds3::kInfinity) & 2u) << size;
    }
  }
}

TEST(LightBuffer, AnswersNotWhereRaysStartFarOff) {
  const FewInstances few({{std::make_shared<Sphere>(Point3{}, 1)}});
  SurfaceInteraction surface;
  surface.point = {1, 2, 0};
  EXPECT_TRUE(LightBuffer::has_answers(few.boxes(), surface));
  surface.point_error = {0, 1e-5, 0};
  EXPECT_FALSE(LightBuffer::has_answers(few.boxes(), surface));
  surface.point_error = {};
  surface.smooth_shift = {0, 0, -0.1};
  EXPECT_FALSE(LightBuffer::has_answers(few.boxes(), surface));
  surface.smooth_shift = {};
  surface.point = {100, 0, 0};
  EXPECT_FALSE(LightBuffer::has_answers(few.boxes(), surface));
  surface.point.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(LightBuffer::has_answers(few.boxes(), surface));
}

TEST(LightBuffer, LooksAtAllFromTheLightItself) {
  const FewInstances few({{std::make_shared<Sphere>(Point3{}, 1)}});
  const LightBuffer buffer = LightBuffer::of_place(few.boxes(), {5, 0, 0});
  EXPECT_EQ(buffer.boxes_met({5, 0, 0}, {0, 1, 0}, 0), few.boxes().all);
  EXPECT_EQ(buffer.boxes_met({9, 0, 0}, {-1, 0, 0}, 4), 0u);
  EXPECT_EQ(buffer.boxes_met({-9, 0, 0}, {1, 0, 0}, 14), few.boxes().all);
}

}  // namespace
}  // namespace tessera
