// What direct light of lights without extent is known to be, by Whitted's integrator; shadows of
// both.
#include "tests/accuracy/support.h"

namespace tessera {
namespace {

const std::string kWhiteWall = "materials { name: 'm' classic { diffuse " + grey(1) + " } } " +
                               node("plane { normal { z: 1 } }", "m");

TEST(DirectLight, FallsOffAsTheFormulaSaysInEveryPixel) {
  constexpr int kSide = 16;
  const double h = 3, lx = 5, ly = 9, c1 = 0.5, c2 = 0.1, c3 = 0.02;
  const std::string scene =
      kWhiteWall + map_camera(kSide, kSide) +
      "nodes { light { point { position { x: " + number(lx) + " y: " + number(ly) +
      " z: " + number(h) +
      " } } attenuation { constant: .5 linear: .1 quadratic: .02 at_most_one: true } } }";
  const TilePixels tile = render_text(scene, kSide, kSide);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const double x = column + 0.5 - lx, y = kSide - row - 0.5 - ly;
      const double d = std::sqrt(x * x + y * y + h * h);
      const double truth = h / d / std::max(c1 + c2 * d + c3 * d * d, 1.0);
      const double found = tile.values[static_cast<size_t>(row * kSide + column) * 3];
      EXPECT_NEAR(found, truth, 1e-6 * truth) << column << ", " << row;
    }
  }
}

TEST(DirectLight, SphereInParallelLightAtEveryPhase) {
  constexpr int kSide = 64;
  for (const double phase : {0.0, 0.5, 1.2, 2.0, 3.0}) {
    const std::string scene =
        "materials { name: 'm' classic { diffuse " + grey(0.9) + " } } " +
        node("sphere { center { x: 32 y: 32 } radius: 32 }", "m") + map_camera(kSide, kSide) +
        samples(16) + "nodes { light { directional { direction { x: " + number(-std::sin(phase)) +
        " z: " + number(-std::cos(phase)) + " } } } }";
    const TilePixels tile = render_text(scene, kSide, kSide);
    double sum = 0;
    for (size_t i = 0; i < tile.values.size(); i += 3) sum += tile.values[i];
    const double truth = 2.0 / 3 * 0.9 * (std::sin(phase) + (kPi - phase) * std::cos(phase)) / kPi;
    EXPECT_NEAR(sum / (kPi * 32 * 32), truth, 0.005 * truth + 2e-5) << phase;
  }
}

/// Hides light, but not the view: its back, which the camera sees, is not there.
std::string blind(double edge, double height) {
  return "materials { name: 'blind' sides: FRONT_ONLY classic { } } " +
         node("rectangle { corner { x: " + number(edge) + " y: -50 z: " + number(height) +
                  " } edge_u { y: 100 } edge_v { x: 200 } }",
              "blind");
}

TEST(DirectLight, ShadowEdgesLieWhereTheyBelong) {
  constexpr int kWidth = 80;
  const double hl = 40, ho = 10;
  for (const double edge : {30.3, 30.075, 30.51}) {
    const double truth = edge * hl / (hl - ho);  // the light is at x = 0
    const std::string scene = kWhiteWall + blind(edge, ho) + map_camera(kWidth, 1) + samples(256);
    const std::string light = "nodes { light { point { position { y: .5 z: 40 } } } }";
    const TilePixels shaded = render_text(scene + light, kWidth, 1);
    const TilePixels bare =
        render_text(kWhiteWall + map_camera(kWidth, 1) + samples(256) + light, kWidth, 1);
    double lit = 0;
    for (size_t i = 0; i < kWidth; ++i) lit += shaded.values[3 * i] / bare.values[3 * i];
    EXPECT_NEAR(lit, truth, 0.02) << edge;
  }
}

TEST(DirectLight, PenumbrasAreAsWideAsTheyShouldBe) {
  constexpr int kWidth = 80;
  const double hl = 40, ho = 10, w = 12, edge = 30;
  const double middle = edge * hl / (hl - ho), half = w * ho / (hl - ho) / 2;
  const std::string path =
      "settings { sampling { samples_per_pixel: 64 pattern: CENTER } integrator { kind: 'path' "
      "max_depth: 1 } } ";
  const std::string lamp =
      "materials { name: 'lamp' sides: FRONT_ONLY classic { diffuse { value { } } emission " +
      grey(1) + " } } " +
      node("rectangle { corner { x: -6 y: -2 z: 40 } edge_u { y: 5 } edge_v { x: 12 } }", "lamp");
  const std::string scene = kWhiteWall + lamp + map_camera(kWidth, 1) + path;
  const TilePixels bare = render_text(scene, kWidth, 1);
  const TilePixels shaded = render_text(scene + blind(edge, ho), kWidth, 1);
  for (int i = 0; i < kWidth; ++i) {
    const double x = i + 0.5;
    const float found = shaded.values[3 * static_cast<size_t>(i)];
    const float whole = bare.values[3 * static_cast<size_t>(i)];
    if (x < middle - half - 0.01) {
      EXPECT_EQ(found, whole) << x;
    } else if (x > middle + half + 0.01) {
      EXPECT_EQ(found, 0) << x;
    } else {
      EXPECT_GE(found, 0) << x;
      EXPECT_LE(found, whole) << x;
    }
  }
}

TEST(DirectLight, PenumbrasFallByWhatIsSeenOfTheLamp) {
  constexpr int kWidth = 8;  // from x = 38, where they begin, to 42
  const double hl = 40, ho = 10, edge = 30;
  const std::string scene =
      kWhiteWall + blind(edge, ho) +
      "materials { name: 'lamp' sides: FRONT_ONLY classic { diffuse { value { } } emission " +
      grey(1) + " } } " +
      node("rectangle { corner { x: -6 y: -2 z: 40 } edge_u { y: 5 } edge_v { x: 12 } }", "lamp") +
      "cameras { world_from_camera { steps { translate { x: 38 z: 100 } } } orthographic { min_x: "
      "0 "
      "min_y: 0 max_x: 4 max_y: .5 } } settings { sampling { samples_per_pixel: 4096 pattern: "
      "CENTER } integrator { kind: 'path' max_depth: 1 } } ";
  const TilePixels tile = render_text(scene, kWidth, 1);
  const auto seen = [&](double x, double to) {  // of the lamp up to `to`, from (x, .25, 0)
    return irradiance(
               {{-6 - x, -2.25, hl}, {to - x, -2.25, hl}, {to - x, 2.75, hl}, {-6 - x, 2.75, hl}}) /
           kPi;
  };
  for (int i = 0; i < kWidth; ++i) {
    const double x = 38 + (i + 0.5) / 2;
    const double last = std::clamp(x + (edge - x) * hl / ho, -6.0, 6.0);
    EXPECT_NEAR(tile.values[3 * static_cast<size_t>(i)], seen(x, last), 0.005 * seen(x, 6)) << x;
  }
}

}  // namespace
}  // namespace tessera
