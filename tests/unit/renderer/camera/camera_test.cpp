#include "renderer/camera/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tessera {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// The full angle between the rays through the middles of two opposite sides.
double angle(const Camera& camera, double x0, double y0, double x1, double y1) {
  const Vec3 a = camera.ray(x0, y0).direction, b = camera.ray(x1, y1).direction;
  return std::atan2(length(cross(a, b)), dot(a, b)) / kDegree;
}

Camera make(CameraSettings::Axis axis, int width, int height) {
  return Camera({.field_of_view = 0.7854, .axis = axis}, width, height);
}

TEST(Camera, field_of_view_spans_the_smaller_side) {
  const Camera wide = make(CameraSettings::Axis::smaller, 1600, 900);
  EXPECT_NEAR(angle(wide, 0, 450, 1600, 450), 72.73, 0.01);
  EXPECT_NEAR(angle(wide, 800, 0, 800, 900), 45.00, 0.01);
  const Camera tall = make(CameraSettings::Axis::smaller, 900, 1600);
  EXPECT_NEAR(angle(tall, 0, 800, 900, 800), 45.00, 0.01);
}

TEST(Camera, or_the_side_that_is_named) {
  EXPECT_NEAR(angle(make(CameraSettings::Axis::vertical, 900, 1600), 450, 0, 450, 1600), 45, 0.01);
  EXPECT_NEAR(angle(make(CameraSettings::Axis::horizontal, 1600, 900), 0, 450, 1600, 450), 45,
              0.01);
  EXPECT_NEAR(angle(make(CameraSettings::Axis::larger, 900, 1600), 450, 0, 450, 1600), 45, 0.01);
}

TEST(Camera, windows_are_shifted_and_pixels_wider_than_high) {
  const Camera camera({.field_of_view = 2 * std::atan(1.0),
                       .axis = CameraSettings::Axis::horizontal,
                       .shift = {0.25, -0.5},
                       .pixel_aspect = 2},
                      200, 100);
  const auto expect = [&](double x, double y, const Vec3& through) {
    EXPECT_LT(length(camera.ray(x, y).direction - normalize(through)), 1e-15) << x << " " << y;
    const auto raster = camera.raster_of(Point3{} + through * 3);
    ASSERT_TRUE(raster);
    EXPECT_NEAR(raster->x, x, 1e-12);
    EXPECT_NEAR(raster->y, y, 1e-12);
  };
  expect(100, 50, {0.5, -0.25, -1});
  expect(0, 0, {-0.5, 0, -1});
  expect(200, 100, {1.5, -0.5, -1});
}

TEST(Camera, image_axes) {
  const Camera camera = make(CameraSettings::Axis::smaller, 100, 100);
  EXPECT_EQ(camera.ray(50, 50).direction, (Vec3{0, 0, -1}));
  EXPECT_GT(camera.ray(100, 50).direction.x, 0);
  EXPECT_GT(camera.ray(50, 0).direction.y, 0);
}

TEST(Camera, frames_may_mirror_and_scale) {
  CameraSettings settings{.world_from_camera = scaling({-3, 2, 5})};
  const Camera camera(settings, 100, 100);
  const Vec3 d = camera.ray(100, 20).direction;
  const Vec3 plain = Camera({}, 100, 100).ray(100, 20).direction;
  EXPECT_EQ(d, (Vec3{-plain.x, plain.y, plain.z}));
}

TEST(Camera, orthographic_pixels_have_one_size_and_nothing_is_cropped) {
  const Camera camera({.projection = Projection::orthographic}, 400, 200);
  const Ray a = camera.ray(0, 0), b = camera.ray(1, 0), c = camera.ray(0, 200);
  EXPECT_NEAR(b.origin.x - a.origin.x, 2.0 / 200, 1e-15);
  EXPECT_DOUBLE_EQ(a.origin.y, 1);
  EXPECT_DOUBLE_EQ(c.origin.y, -1);
  EXPECT_DOUBLE_EQ(a.origin.x, -2);
  EXPECT_EQ(a.direction, (Vec3{0, 0, -1}));
  const Camera shifted(
      {.projection = Projection::orthographic, .min_x = 0, .min_y = 0, .max_x = 4, .max_y = 1}, 100,
      100);
  EXPECT_DOUBLE_EQ(shifted.ray(0, 0).origin.x, 0);
  EXPECT_DOUBLE_EQ(shifted.ray(0, 0).origin.y, 2.5);
}

TEST(Camera, panoramas_have_angles_as_axes) {
  const Camera sphere({.projection = Projection::spherical, .field_of_view = std::numbers::pi}, 200,
                      100);
  EXPECT_NEAR(sphere.ray(150, 50).direction.x, 1, 1e-15);
  EXPECT_NEAR(sphere.ray(200, 50).direction.z, 1, 1e-15);
  EXPECT_NEAR(sphere.ray(100, 0).direction.y, 1, 1e-15);
  EXPECT_NEAR(sphere.ray(100, 25).direction.y, std::sqrt(.5), 1e-15);
  const Camera cylinder(
      {.projection = Projection::cylindrical, .field_of_view = std::numbers::pi / 2}, 200, 100);
  const Vec3 up = cylinder.ray(100, 0).direction;
  EXPECT_NEAR(up.y / -up.z, 1, 1e-15);
  EXPECT_NEAR(cylinder.ray(200, 50).direction.x, 1, 1e-15);
}

TEST(Camera, near_and_far_bound_the_ray) {
  const Ray ray = Camera({.near_distance = 2, .far_distance = 9}, 10, 10).ray(1, 1);
  EXPECT_EQ(ray.t_min, 2);
  EXPECT_EQ(ray.t_max, 9);
  EXPECT_DOUBLE_EQ(length(ray.direction), 1);
}

TEST(Camera, raster_of_undoes_ray) {
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    const Affine frame = look_at({1, 2, 3}, {-2, 0, 1}, {0, 1, 0});
    const Camera camera({.world_from_camera = frame, .projection = projection}, 640, 480);
    const auto raster = camera.raster_of(camera.ray(123.25, 77.5).at(5));
    ASSERT_TRUE(raster);
    EXPECT_NEAR(raster->x, 123.25, 1e-9);
    EXPECT_NEAR(raster->y, 77.5, 1e-9);
  }
  EXPECT_FALSE(Camera({}, 10, 10).raster_of({0, 0, 1}));
  EXPECT_FALSE(Camera({}, 10, 10).raster_of({0, 0, 0}));
}

}  // namespace
}  // namespace tessera
