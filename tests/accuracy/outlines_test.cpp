// Where things are in the picture: vanishing points, outlines, circles' shares of pixels.
#include <vector>

#include "renderer/camera/camera.h"
#include "renderer/shapes/torus.h"
#include "tests/accuracy/support.h"

namespace tessera {
namespace {

constexpr int kSide = 1000;

CameraSettings tilted() {
  CameraSettings settings;
  settings.field_of_view = 1.1;
  settings.world_from_camera = translation({1, 2, 3}) * rotation({1, 2, -0.5}, 0.4);
  return settings;
}

TEST(Projection, ParallelLinesMeetInTheirVanishingPoint) {
  const Camera camera(tilted(), kSide, kSide);
  const double scale = kSide / 2.0 / std::tan(0.55);
  for (const Vec3& direction : {Vec3{0, 0, -1}, Vec3{0.4, 0.1, -1}, Vec3{-0.3, 0.5, -0.9}}) {
    const double ahead = dot(direction, camera.view());
    ASSERT_GT(ahead, 0);
    const Vec2 truth{kSide / 2.0 + scale * dot(direction, camera.right()) / ahead,
                     kSide / 2.0 - scale * dot(direction, camera.up()) / ahead};
    EXPECT_LT(length(cross(camera.ray(truth.x, truth.y).direction, normalize(direction))), 1e-14);
    for (const Vec3& aside : {Vec3{0.3, -0.2, 0}, Vec3{-1, 0.5, 0.4}, Vec3{0.1, 1, -0.3}}) {
      // The line's picture is straight, and the point on it.
      const Point3 start = camera.position() + camera.view() * 4 + aside;
      const auto a = camera.raster_of(start), b = camera.raster_of(start + direction * 5);
      const auto far = camera.raster_of(start + direction * 1e10);
      ASSERT_TRUE(a && b && far);
      const double off = (b->x - a->x) * (truth.y - a->y) - (b->y - a->y) * (truth.x - a->x);
      EXPECT_NEAR(off / std::hypot(b->x - a->x, b->y - a->y), 0, 1e-6);
      EXPECT_NEAR(std::hypot(far->x - truth.x, far->y - truth.y), 0, 1e-6);
    }
  }
}

/// The distance of a ray from the circle of radius `major` about the y axis, as a torus has it.
double distance_to_circle(const Ray& ray, double major) {
  const auto at = [&](double turn) {
    const Point3 p{major * std::cos(turn), 0, major * std::sin(turn)};
    return length(cross(p - ray.origin, normalize(ray.direction)));
  };
  constexpr int kSteps = 720;
  double best = 0;
  for (int i = 1; i < kSteps; ++i)
    if (at(2 * kPi * i / kSteps) < at(best)) best = 2 * kPi * i / kSteps;
  double low = best - 2 * kPi / kSteps, high = best + 2 * kPi / kSteps;
  for (int i = 0; i < 100; ++i) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (at(a) < at(b) ? high : low) = at(a) < at(b) ? b : a;
  }
  return at(low);
}

TEST(Projection, ATorusInPerspectiveEndsWhereRaysPassItsCircleByItsRadius) {
  const double minor = 0.3;
  const Torus torus(1, minor);
  TraversalCounters counters;
  CameraSettings settings;
  settings.field_of_view = 1;
  settings.world_from_camera = rotation({1, 0.3, 0}, 0.9) * translation({0.2, 0.1, 4});
  const Camera camera(settings, kSide, kSide);
  const auto ray_at = [&](double turn, double out) {
    return camera.ray(kSide / 2.0 + out * std::cos(turn), kSide / 2.0 + out * std::sin(turn));
  };
  const auto hits = [&](const Ray& ray) {
    Hit hit;
    return torus.closest_hit(ray, hit, counters);
  };
  const double pixel = 4 * std::tan(0.5) / (kSide / 2.0);
  for (double turn = 0.1; turn < 2 * kPi; turn += 0.4) {
    double in = 0, out = 480;
    while (in < out && !hits(ray_at(turn, in))) in += 5;
    ASSERT_TRUE(hits(ray_at(turn, in)) && !hits(ray_at(turn, out))) << turn;
    for (int i = 0; i < 60; ++i) (hits(ray_at(turn, (in + out) / 2)) ? in : out) = (in + out) / 2;
    Ray ray = ray_at(turn, in);
    EXPECT_NEAR(distance_to_circle(ray, 1), minor, 1e-6 * pixel) << turn;
  }
}

/// The area of the unit square from (x, y) inside of the circle about the origin, by strips.
double circle_in_pixel(double x, double y, double radius) {
  constexpr int kStrips = 2000;
  double area = 0;
  for (int i = 0; i < kStrips; ++i) {
    const double at = x + (i + 0.5) / kStrips, half2 = radius * radius - at * at;
    if (half2 <= 0) continue;
    const double half = std::sqrt(half2);
    area += std::max(0.0, std::min(half, y + 1) - std::max(-half, y)) / kStrips;
  }
  return area;
}

/// A disc about the middle of the picture, which may have a hole.
std::string ring(int side, double inner, double outer) {
  return node("disc { center { x: " + number(side / 2.0) + " y: " + number(side / 2.0) +
                  " } radius: " + number(outer) + " inner_radius: " + number(inner) + " }",
              "glow");
}

TEST(Coverage, OfACircleIsItsShareOfEachPixel) {
  constexpr int kDisc = 16;
  const double radius = 5.3;
  const TilePixels tile = render_text(
      kGlow + map_camera(kDisc, kDisc) + samples(1024) + ring(kDisc, 0, radius), kDisc, kDisc);
  double sum = 0;
  for (int i = 0; i < kDisc * kDisc; ++i) {
    const int x = i % kDisc - 8, y = i / kDisc - 8;
    const double truth = circle_in_pixel(x, y, radius);
    const float found = tile.values[3 * static_cast<size_t>(i)];
    EXPECT_NEAR(found, truth, 0.005) << i;
    EXPECT_TRUE(truth > 0 || found == 0) << i;
    sum += found;
  }
  EXPECT_NEAR(sum, kPi * radius * radius, 1e-3 * kPi * radius * radius);
}

TEST(Coverage, OfAZonePlateHasNoPatternsOfItsOwn) {
  // Rings of equal area, at the rim a third of a pixel wide: what is too fine to be seen must come
  // out as their mean, half, with noise, not as the false circles of a regular pattern.
  constexpr int kPlate = 48, kRings = 16, kBlock = 8;
  const double scale = 4;
  std::string scene = kGlow + map_camera(kPlate, kPlate) + samples(64);
  for (int i = 0; i < kRings; ++i)
    scene += ring(kPlate, scale * std::sqrt(2.0 * i), scale * std::sqrt(2.0 * i + 1));
  const TilePixels tile = render_text(scene, kPlate, kPlate);
  std::vector<double> blocks((kPlate / kBlock) * (kPlate / kBlock));
  double squares = 0;
  for (int i = 0; i < kPlate * kPlate; ++i) {
    const int x = i % kPlate, y = i / kPlate;
    const int left = x - kPlate / 2, top = y - kPlate / 2;
    const int block = y / kBlock * (kPlate / kBlock) + x / kBlock;
    double truth = 0;
    for (int n = 1; n < 2 * kRings; ++n)
      truth += (n % 2 == 1 ? 1 : -1) * circle_in_pixel(left, top, scale * std::sqrt(n));
    const double error = tile.values[3 * static_cast<size_t>(i)] - truth;
    squares += error * error;
    blocks[static_cast<size_t>(block)] += error / (kBlock * kBlock);
  }
  EXPECT_LT(std::sqrt(squares / (kPlate * kPlate)), 0.05);
  for (const double block : blocks) EXPECT_LT(std::abs(block), 0.015);
}

}  // namespace
}  // namespace tessera
