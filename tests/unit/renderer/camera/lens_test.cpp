#include "renderer/camera/lens.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "renderer/camera/camera.h"
#include "tests/chi_square.h"
#include "tests/uniform_numbers.h"

namespace tessera {
namespace {

constexpr int kSide = 256;

/// Means of x, y, x^2 + y^2 over a regular grid of uniform numbers.
struct Moments {
  double x = 0, y = 0, squares = 0;
};

template <typename Check>
Moments moments(LensShape shape, uint32_t blades, const Check& check) {
  Moments sum;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const Vec2 p = sample_lens(shape, blades, {(i + 0.5) / kSide, (j + 0.5) / kSide});
      check(p);
      sum.x += p.x / (kSide * kSide);
      sum.y += p.y / (kSide * kSide);
      sum.squares += (p.x * p.x + p.y * p.y) / (kSide * kSide);
    }
  }
  return sum;
}

TEST(Lens, circles_are_filled_evenly) {
  const Moments m = moments(LensShape::circle, 0,
                            [](const Vec2& p) { EXPECT_LE(p.x * p.x + p.y * p.y, 1 + 1e-12); });
  EXPECT_NEAR(m.x, 0, 1e-9);
  EXPECT_NEAR(m.y, 0, 1e-9);
  EXPECT_NEAR(m.squares, 0.5, 1e-4);
}

TEST(Lens, polygons_are_filled_evenly_to_their_corners) {
  for (const uint32_t blades : {3u, 4u, 5u, 6u, 16u}) {
    double leftmost = 0;
    const double inner = std::cos(std::numbers::pi / blades);
    const Moments m = moments(LensShape::polygon, blades, [&](const Vec2& p) {
      leftmost = std::min(leftmost, p.x);
      // Inside of every side; side k lies opposite to angle (2 k + 1) pi / n seen from -x.
      for (uint32_t k = 0; k < blades; ++k) {
        const double a = std::numbers::pi * (1 + (2.0 * k + 1) / blades);
        EXPECT_LE(p.x * std::cos(a) + p.y * std::sin(a), inner + 1e-12);
      }
    });
    EXPECT_LT(leftmost, -0.97) << blades;
    EXPECT_NEAR(m.x, 0, 2e-3) << blades;
    EXPECT_NEAR(m.y, 0, 2e-3) << blades;
    // The second moment of a regular polygon of circumradius 1.
    EXPECT_NEAR(m.squares, (2 + std::cos(2 * std::numbers::pi / blades)) / 6, 2e-3) << blades;
  }
}

TEST(Lens, the_other_shapes_have_their_densities) {
  const auto any = [](const Vec2&) {};
  EXPECT_NEAR(moments(LensShape::square, 0, any).squares, 2.0 / 3, 1e-4);
  EXPECT_NEAR(moments(LensShape::gaussian, 0, any).squares, 2, 2e-2);
  const Moments line = moments(LensShape::line, 0, [](const Vec2& p) { EXPECT_EQ(p.y, 0); });
  EXPECT_NEAR(line.squares, 1.0 / 6, 1e-4);
}

/// By how many deviations the chi-square of 100,000 samples over 20 x 20 cells of [-extent,
/// extent]^2 is too large, were they of that density.
double lens_sigmas(LensShape shape, uint32_t blades, double extent,
                   const std::function<double(double, double)>& density) {
  constexpr int kCells = 20, kFine = 40, kCount = 100000;
  std::vector<double> expected(kCells * kCells + 1), found(expected.size());
  double rest = kCount;
  UniformNumbers random(28);
  const double step = 2 * extent / (kCells * kFine);
  for (int i = 0; i < kCells * kFine * kCells * kFine; ++i) {
    const int row = i / (kCells * kFine), column = i % (kCells * kFine);
    // Somewhere in each: edges along the cells would make the same mistake in all of them.
    const double x = (column + random()) * step - extent, y = (row + random()) * step - extent;
    const double count = density(x, y) * step * step * kCount;
    const int cell = row / kFine * kCells + column / kFine;
    expected[static_cast<size_t>(cell)] += count;
    rest -= count;
  }
  expected.back() = std::max(rest, 0.0);
  for (int i = 0; i < kCount; ++i) {
    const double u = random(), v = random();
    const Vec2 p = sample_lens(shape, blades, {u, v});
    const double column = std::floor((p.x / extent + 1) / 2 * kCells);
    const double row = std::floor((p.y / extent + 1) / 2 * kCells);
    const bool is_inside = row >= 0 && row < kCells && column >= 0 && column < kCells;
    ++found[is_inside ? static_cast<size_t>(row * kCells + column) : found.size() - 1];
  }
  return chi_square_sigmas(found, expected);
}

TEST(Lens, samples_pass_a_chi_square_test) {  // N28; a false alarm in 300,000 a case
  const auto circle = [](double x, double y) {
    return x * x + y * y < 1 ? 1 / std::numbers::pi : 0;
  };
  EXPECT_LT(lens_sigmas(LensShape::circle, 0, 1, circle), kChiSquareAlarm);
  EXPECT_GT(lens_sigmas(LensShape::square, 0, 1, circle), 100) << "it can fail";
  EXPECT_LT(lens_sigmas(LensShape::square, 0, 1, [](double, double) { return 0.25; }),
            kChiSquareAlarm);
  EXPECT_LT(lens_sigmas(LensShape::gaussian, 0, 4,
                        [](double x, double y) {
                          return std::exp(-(x * x + y * y) / 2) / (2 * std::numbers::pi);
                        }),
            kChiSquareAlarm);
  for (const uint32_t blades : {3u, 5u, 6u}) {
    const auto polygon = [&](double x, double y) {
      for (uint32_t k = 0; k < blades; ++k) {
        const double a = std::numbers::pi * (1 + (2.0 * k + 1) / blades);
        if (x * std::cos(a) + y * std::sin(a) > std::cos(std::numbers::pi / blades)) return 0.0;
      }
      return 2 / (blades * std::sin(2 * std::numbers::pi / blades));
    };
    EXPECT_LT(lens_sigmas(LensShape::polygon, blades, 1, polygon), kChiSquareAlarm) << blades;
  }
}

CameraSettings with_lens(bool focal_sphere) {
  CameraSettings settings;
  settings.lens = {.radius = {0.2, 0.4}, .focal_distance = 3, .focal_sphere = focal_sphere};
  return settings;
}

TEST(Lens, rays_of_a_pixel_meet_in_focus) {
  for (const bool focal_sphere : {false, true}) {
    const Camera camera(with_lens(focal_sphere), 100, 100);
    const Ray pinhole = camera.ray(90, 20);
    const double t = focal_sphere ? 3 : 3 / -pinhole.direction.z;
    const Point3 focus = pinhole.at(t);
    for (const Vec2 u : {Vec2{0.1, 0.9}, Vec2{0.7, 0.2}, Vec2{0.5, 0.5}}) {
      const Ray ray = camera.lens_ray(90, 20, u);
      EXPECT_NEAR(length(ray.direction), 1, 1e-15);
      EXPECT_NEAR(length(cross(focus - ray.origin, ray.direction)), 0, 1e-14);
      const Vec3 on_lens = ray.origin - camera.position();
      EXPECT_LE(std::hypot(on_lens.x / 0.2, on_lens.y / 0.4), 1 + 1e-12);
    }
  }
}

TEST(Lens, its_size_may_follow_the_frame) {
  CameraSettings settings = with_lens(true);
  settings.lens.radius_over_frame = true;
  settings.lens.radius = {50, 50};
  settings.lens.shape = LensShape::square;
  const Ray ray = Camera(settings, 200, 100).lens_ray(100, 50, {0, 1});
  EXPECT_NEAR(ray.origin.x, -50.0 / 200, 1e-15);
  EXPECT_NEAR(ray.origin.y, 50.0 / 100, 1e-15);
}

TEST(Lens, without_a_radius_there_is_none) {
  EXPECT_EQ(Camera({}, 10, 10).lens_samples(), 0u);
  EXPECT_EQ(Camera(with_lens(true), 10, 10).lens_samples(), 1u);
}

}  // namespace
}  // namespace tessera
