// Blur of a lens, coverage of pixels, and outlines, in closed form.
#include <random>

#include "renderer/camera/camera.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/torus.h"
#include "tests/accuracy/support.h"

namespace tessera {
namespace {

TEST(Lens, BlursAnEdgeByTheProfileOfItsDisc) {
  constexpr int kWidth = 64;
  const double radius = 2, focus = 20, distance = 50;
  // The window is as wide as 64 units of the plane of the edge.
  const double angle = 2 * std::atan(32 / distance) * 180 / kPi;
  const std::string scene =
      kGlow + node("half_plane { point { z: -50 } normal { z: 1 } edge_normal { x: 1 } }", "glow") +
      "cameras { perspective { field_of_view: " + number(angle) +
      " axis: HORIZONTAL } lens { radius_x: 2 radius_y: 2 focal_distance: 20 samples: 4096 } } " +
      "settings { sampling { pattern: CENTER } } ";
  const TilePixels tile = render_text(scene, kWidth, 1);
  const double blur = radius * std::abs(distance - focus) / focus;
  double squares = 0;
  for (int i = 0; i < kWidth; ++i) {
    const double t = std::clamp((i + 0.5 - 32) / blur, -1.0, 1.0);
    const double truth = 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / kPi;
    const double error = tile.values[3 * static_cast<size_t>(i)] - truth;
    squares += error * error;
  }
  EXPECT_LT(std::sqrt(squares / kWidth), 0.002);
}

TEST(Coverage, OfAHalfPlaneIsTheAreaThatItCutsOff) {
  // x cos a + y sin a > d over one pixel, by clipping its square.
  for (const double a : {0.1, 0.6, 1.2}) {
    for (const double d : {0.3, 0.7, 1.0}) {
      const double nx = std::cos(a), ny = std::sin(a);
      double area = 0;
      constexpr int kStrips = 100000;
      for (int i = 0; i < kStrips; ++i) {
        const double x = (i + 0.5) / kStrips;
        area += 1 - std::clamp((d - x * nx) / ny, 0.0, 1.0);
      }
      area /= kStrips;
      const std::string scene =
          kGlow + map_camera(1, 1) + samples(1024) +
          node("half_plane { point { x: " + number(d * nx) + " y: " + number(d * ny) +
                   " } normal { z: 1 } edge_normal { x: " + number(nx) + " y: " + number(ny) +
                   " } }",
               "glow");
      EXPECT_NEAR(render_text(scene, 1, 1).values[0], area, 0.003) << a << " " << d;
    }
  }
}

TEST(Coverage, OfDotsSmallerThanAPixelLosesNoEnergy) {
  struct Dots {
    double radius;
    uint32_t samples;
  };
  for (const Dots& dots : {Dots{0.1, 256}, Dots{0.3, 64}, Dots{0.5, 16}}) {
    constexpr int kDots = 32, kCell = 3, kSide = kDots * kCell;
    std::mt19937 engine(5);
    std::string scene = kGlow + map_camera(kSide, kSide) + samples(dots.samples);
    for (int i = 0; i < kDots * kDots; ++i) {
      const int column = i % kDots, row = i / kDots;
      const double x = column * kCell + 1 + engine() * 0x1p-32;
      const double y = row * kCell + 1 + engine() * 0x1p-32;
      scene += node("disc { center { x: " + number(x) + " y: " + number(y) +
                        " } radius: " + number(dots.radius) + " }",
                    "glow");
    }
    v1::FrameSettings frame = frame_of(kSide, kSide);
    frame.set_accelerator("bvh");
    const auto renderer = make_tile_renderer(parse_scene(scene), {}, frame, 1);
    const TilePixels tile = render_rect(*renderer, {0, 0, kSide, kSide}, dots.samples);
    double sum = 0;
    for (size_t i = 0; i < tile.values.size(); i += 3) sum += tile.values[i];
    EXPECT_NEAR(sum / (kDots * kDots) / (kPi * dots.radius * dots.radius), 1, 0.01) << dots.radius;
  }
}

TEST(Coverage, OfACheckerboardUpToTheHorizonIsAHalf) {
  const std::string scene =
      "textures { name: 'board' checker { } mapping: WORLD } materials { name: 'm' unlit { color { "
      "texture: 'board' } } } " +
      node("plane { }", "m") +
      "cameras { world_from_camera { steps { look_at { eye { x: .3 y: 1.7 z: .2 } target { x: .5 "
      "y: "
      "1.6 z: -1 } } } } } " +
      samples(16);
  constexpr int kSide = 64;
  const TilePixels tile = render_text(scene, kSide, kSide);
  double sum = 0;
  int rows = 0;
  for (int row = kSide * 5 / 8; row < kSide; ++row, ++rows) {
    for (int column = 0; column < kSide; ++column) {
      sum += tile.values[static_cast<size_t>(row * kSide + column) * 3];
    }
  }
  EXPECT_NEAR(sum / (rows * kSide), 0.5, 0.02);
}

TEST(Outline, OfASphereIsTheEllipseThatItShouldBe) {
  // Seen from the origin, the outline is a cone: asin(R / d) about the centre's direction.
  CameraSettings settings;
  settings.field_of_view = 1.2;
  settings.axis = CameraSettings::Axis::horizontal;
  constexpr int kSide = 1000;
  const Camera camera(settings, kSide, kSide);
  const double scale = kSide / 2.0 / std::tan(0.6);
  TraversalCounters counters;
  for (const double x : {0.0, 2.0, 4.5}) {
    const double z = -10, radius = 1.3, d = std::sqrt(x * x + z * z);
    const Sphere sphere({x, 0, z}, radius);
    const auto hits = [&](double raster) {
      Hit hit;
      return sphere.closest_hit(camera.ray(raster, kSide / 2.0), hit, counters);
    };
    const double middle = std::atan(x / -z), half = std::asin(radius / d);
    for (const int side : {-1, 1}) {
      double in = kSide / 2.0 + scale * std::tan(middle), out = in + side * 400;
      ASSERT_TRUE(hits(in));
      ASSERT_FALSE(hits(out));
      for (int i = 0; i < 60; ++i) (hits((in + out) / 2) ? in : out) = (in + out) / 2;
      EXPECT_NEAR(in, kSide / 2.0 + scale * std::tan(middle + side * half), 1e-6) << x;
    }
  }
}

TEST(Outline, OfATorusFaceOnAreItsTwoCircles) {
  const Torus torus(1, 0.3);
  TraversalCounters counters;
  const auto hits = [&](double x) {
    Hit hit;
    return torus.closest_hit({{x, 10, 0}, {0, -1, 0}}, hit, counters);
  };
  for (const double outline : {0.7, 1.3}) {
    double in = 1, out = outline < 1 ? 0.5 : 1.5;
    ASSERT_TRUE(hits(in));
    ASSERT_FALSE(hits(out));
    for (int i = 0; i < 60; ++i) (hits((in + out) / 2) ? in : out) = (in + out) / 2;
    EXPECT_NEAR(in, outline, 1e-9);
  }
}

}  // namespace
}  // namespace tessera
