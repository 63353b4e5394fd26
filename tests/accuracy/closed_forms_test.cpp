// The path tracer against radiance known in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "renderer/math/vec.h"
#include "tests/accuracy/estimate.h"

namespace tessera {
namespace {

TEST(ClosedForms, DiscFacingAndAside) {
  const double R = 1.5, h = 2;
  const auto disc = [&](double a) {
    return kLampAndWall + node("disc { center { x: " + number(a) + " z: " + number(h) +
                                   " } normal { z: -1 } radius: " + number(R) + " }",
                               "lamp");
  };
  expect_estimate(wall(kPi * 2 * R * R / (R * R + h * h)), estimate(disc(0)));
  const double a = 3, s = h * h + a * a;
  expect_estimate(
      wall(kPi * 2 / 2 *
           (1 - (s - R * R) / std::sqrt((s + R * R) * (s + R * R) - 4 * R * R * a * a))),
      estimate(disc(a)));
}

TEST(ClosedForms, SphereAboveAndAcrossTheHorizon) {
  const auto sphere = [&](double d, double theta) {
    return material("lamp", 0, 2) + material("wall", 0.6) +
           node("plane { normal { z: 1 } }", "wall") +
           node("sphere { center { x: " + number(d * std::sin(theta)) +
                    " z: " + number(d * std::cos(theta)) + " } radius: 1 }",
                "lamp");
  };
  expect_estimate(wall(kPi * 2 * (1.0 / 9) * std::cos(0.9)), estimate(sphere(3, 0.9)));
  // Its centre 80 degrees off the normal, so that a part is below the wall.
  const double h = 2, c = std::cos(80 * kPi / 180), k = 1 - h * h * c * c;
  const double e =
      ((c * std::acos(-c * std::sqrt((h * h - 1) / (1 - c * c))) - std::sqrt(k * (h * h - 1))) /
           (h * h) +
       std::atan(std::sqrt(k / (h * h - 1)))) *
      2;
  expect_estimate(wall(e), estimate(sphere(2, 80 * kPi / 180)));
}

TEST(ClosedForms, RectangleByAreaAndBySolidAngleAndAsTriangles) {
  for (const double h : {0.3, 1.0, 20.0}) {  // near, near, far
    SCOPED_TRACE(h);
    const double w = 2, l = 1, a = w / h, b = l / h;
    const double e = 2.0 / 2 *
                     (a / std::sqrt(1 + a * a) * std::atan(b / std::sqrt(1 + a * a)) +
                      b / std::sqrt(1 + b * b) * std::atan(a / std::sqrt(1 + b * b)));
    const std::string z = " z: " + number(h);
    const std::string rectangle =
        "rectangle { corner {" + z + " } edge_u { y: 1 } edge_v { x: 2 } }";
    const std::string mesh = "mesh { inline_positions: [0, 0, " + number(h) + ", 2, 0, " +
                             number(h) + ", 2, 1, " + number(h) + ", 0, 1, " + number(h) +
                             "] inline_triangles: [0, 2, 1, 0, 3, 2] }";
    // The camera would be in the far one's way.
    const std::string from =
        h > 10 ? "cameras { world_from_camera { steps { look_at { eye { x: -1 y: -1 z: 5 } "
                 "target { } } } } } "
               : "";
    expect_estimate(wall(e), estimate(from + kLampAndWall + node(rectangle, "lamp")));
    expect_estimate(wall(e), estimate(from + kLampAndWall + node(mesh, "lamp")));
  }
}

TEST(ClosedForms, WhatStopsPathsStopsTheirLight) {
  // A card that is said to cast no shadow: paths meet it all the same, so that light from surfaces
  // must not go through it either, or the two ways of sampling would not add up.
  const auto scene = [](const char* flag) {
    return kLampAndWall + material("card", 0.3) +
           node("disc { center { z: 4 } normal { z: -1 } radius: 2 }", "lamp") + "nodes { " + flag +
           " shape { materials: 'card' rectangle { corner { x: .1 y: -3 z: 1 } "
           "edge_u { y: 6 } edge_v { x: 3 } } } } ";
  };
  EXPECT_EQ(estimate(scene("casts_no_shadow: true")).mean, estimate(scene("")).mean);
}

TEST(ClosedForms, FurnaceToAnyDepth) {
  const std::string furnace = material("glow", 0.7, 0.3) + node("sphere { radius: 50 }", "glow");
  expect_estimate(1.0, estimate(furnace, "max_depth: 200"));
  for (const int n : {0, 1, 2, 7}) {
    expect_estimate(0.3 * (1 - std::pow(0.7, n + 1)) / 0.3,
                    estimate(furnace, "max_depth: " + std::to_string(n)));
  }
}

TEST(ClosedForms, FurnacesOfNori) {  // N29
  for (const double albedo : {0.5, 0.8}) {
    const std::string furnace = material("glow", albedo, 1) + node("sphere { radius: 50 }", "glow");
    expect_estimate(1 / (1 - albedo), estimate(furnace, "max_depth: 1000"));
    expect_estimate(1 + albedo, estimate(furnace, "max_depth: 1"));
  }
}

TEST(ClosedForms, PointLightInASphere) {
  // A light of intensity 1 in our units is of radiant intensity pi.
  const double R = 20, rho = 0.5;
  for (const Vec3& at : {Vec3{4, 7, -3}, Vec3{-3, 1, 9}, Vec3{0, -8, -6}}) {
    const std::string scene = material("inside", rho) + node("sphere { radius: 20 }", "inside") +
                              "nodes { light { point { position { x: " + number(at.x) +
                              " y: " + number(at.y) + " z: " + number(at.z) +
                              " } } attenuation { quadratic: 1 } } } ";
    const double dz = at.z + R, d2 = at.x * at.x + at.y * at.y + dz * dz;
    const double direct = rho * (dz / std::sqrt(d2)) / d2;
    expect_estimate(direct + rho * rho / (R * R * (1 - rho)), estimate(scene, "max_depth: 100"));
  }
}

TEST(ClosedForms, SkyOverAnEndlessWall) {
  const double H = 3, x = 2;
  const std::string scene =
      "background { solid { r: 2 g: 2 b: 2 } } " + material("ground", 0.6) + material("black", 0) +
      node("plane { normal { z: 1 } }", "ground") +
      node("rectangle { corner { x: 2 y: -20000 } edge_u { y: 40000 } edge_v { z: 3 } }", "black");
  expect_estimate(wall(kPi * 2 / 2 * (1 + x / std::sqrt(x * x + H * H))), estimate(scene));
}

TEST(ClosedForms, ClearAndTintedSlab) {
  const auto slab = [](double absorption) {
    const std::string a = number(absorption);
    return material("lamp", 0, 2) + node("plane { normal { z: 1 } offset: -5 }", "lamp") +
           "materials { name: 'glass' dielectric { refractive_index: 1.5 absorption { r: " + a +
           " g: " + a + " b: " + a + " } } } " +
           node("box { min { x: -500 y: -500 } max { x: 500 y: 500 z: .5 } }", "glass");
  };
  expect_estimate(2 * 0.923076923, estimate(slab(0)));
  const double R = 0.04, tau = std::exp(-0.5);
  expect_estimate(2 * (1 - R) * (1 - R) * tau / (1 - R * R * tau * tau), estimate(slab(1)));
}

TEST(ClosedForms, WhiteSurfacesOfEveryKindReflectAllTheyGet) {  // N30
  const std::string white = "{ value { r: 1 g: 1 b: 1 } }";
  const std::string coat = "clearcoat { value: 1 } clearcoat_roughness { value: .2 } }";
  for (const std::string& kind :
       {std::string("classic { diffuse ") + white + " }",
        "physical { base_color " + white + " metallic { value: 1 } roughness { value: .3 } }",
        "physical { base_color " + white + " metallic { value: 1 } roughness { value: 1 } }",
        "physical { base_color " + white + " metallic { value: 0 } roughness { value: .5 } }",
        "physical { base_color " + white + " metallic { value: 0 } roughness { value: 0 } }",
        "physical { base_color " + white + " metallic { value: .5 } roughness { value: .5 } }",
        "physical { base_color " + white + " metallic { value: 0 } roughness { value: .5 } " + coat,
        "physical { base_color " + white + " metallic { value: 1 } roughness { value: .3 } " + coat,
        "physical { base_color " + white +
            " metallic { value: 0 } roughness { value: .4 } "
            "transmission { value: 1 } " +
            coat,
        std::string("classic { diffuse { value { r: .6 g: .6 b: .6 } } "
                    "specular { value { r: .4 g: .4 b: .4 } } shininess { value: 20 } }"),
        "classic { diffuse " + white + " specular " + white + " shininess { value: 100 } }",
        std::string("classic { diffuse { value { r: 1.5 g: 1.5 b: 1.5 } } }"),
        std::string("physical { base_color { value { r: 1.5 g: 1.5 b: 1.5 } } }"),
        std::string("dielectric { }"), std::string("dielectric { thin: true }"),
        std::string("dielectric { roughness { value: .4 } }"),
        std::string("dielectric { roughness { value: .7 } }")}) {
    SCOPED_TRACE(kind);
    const std::string scene = "background { solid { r: 1 g: 1 b: 1 } } materials { name: 'm' " +
                              kind + " } " +
                              node("sphere { center { x: .4 z: 2 } radius: 1 }", "m");
    const Estimate found = estimate(scene, "max_depth: 200");
    EXPECT_NEAR(found.mean, 1, std::max(3 * found.error, 1e-6) + 0.002);
  }
}

TEST(ClosedForms, WhiteShapesVanishInAWhiteFurnace) {  // N30
  for (const char* shape :
       {"sphere { radius: 1.2 }", "box { }", "torus { major_radius: 1 minor_radius: .4 }",
        "cylinder { }", "cone { }", "disc { normal { x: 1 z: 1 } radius: 2 }",
        "rectangle { corner { x: -1 y: -1 } edge_u { x: 2 } edge_v { y: 2 z: 1 } }",
        "mesh { inline_positions: [-2, -2, 0, 2, -2, 1, 0, 2, 0] inline_triangles: [0, 1, 2] }",
        "plane { normal { x: .4 z: 1 } }", "cylinder { open_top: true }",
        "half_plane { point { x: -3 } normal { x: .3 z: 1 } edge_normal { x: 1 } }",
        "polygon { points { x: -2 y: -2 } points { x: 2 y: -2 z: 1 } points { y: 2 } }",
        "disc { normal { x: 1 z: 1 } radius: 2 inner_radius: .01 }", "cone { open_bottom: true }",
        // One text in three lines.
        ("csg { operation: DIFFERENCE operands { shape { materials: 'white' box { } } } "
         "operands { shape { materials: 'white' sphere { "
         "center { z: 1 } radius: .8 } } } }")}) {
    SCOPED_TRACE(shape);
    const Estimate found = estimate(
        "background { solid { r: 1 g: 1 b: 1 } } " + material("white", 1) + node(shape, "white"),
        "max_depth: 1000");
    EXPECT_NEAR(found.mean, 1, std::max(3 * found.error, 1e-6));
    EXPECT_NEAR(found.mean, 1, 0.002);
  }
}

}  // namespace
}  // namespace tessera
