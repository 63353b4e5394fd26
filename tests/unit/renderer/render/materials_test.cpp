// Pixels of physical, conducting and dielectric surfaces in closed form. The camera of every scene
// is X3D's default one: at (0, 0, 10), looking along -z.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

constexpr double kRadiansOfDegree = std::numbers::pi / 180;

std::string material_wall(const std::string& material, const std::string& more = "") {
  return "materials { name: 'm' " + material +
         " } nodes { shape { materials: 'm' plane { normal { z: 1 } } } } " + more;
}

std::string sun(double degrees) {
  return "nodes { light { directional { direction { x: " +
         std::to_string(-std::sin(degrees * kRadiansOfDegree)) +
         " z: " + std::to_string(-std::cos(degrees * kRadiansOfDegree)) + " } } } } ";
}

double grey(const std::string& scene) { return render_pixel(scene)[1]; }

TEST(Physical, rough_surfaces_are_nearly_lambertian) {
  // At normal incidence: F = .04, D pi = 1, V = 1/4.
  const std::string rough = material_wall(
      "physical { metallic { value: 0 } base_color { value { r: .5 g: .5 "
      "b: .5 } } }");
  EXPECT_NEAR(grey(rough + sun(0)), .96 * .5 + .04 / 4, 1e-6);
  // A metal's base colour is its reflectance.
  EXPECT_NEAR(
      grey(material_wall("physical { base_color { value { r: .5 g: .5 b: .5 } } }") + sun(0)),
      .5 / 4, 1e-6);
}

TEST(Physical, highlights_by_ggx) {
  // Metal, light 40 degrees off: the half vector is 20 degrees off, n.v = 1, n.l = cos 40.
  const double r = .5, a2 = std::pow(r, 4), h = 20 * kRadiansOfDegree, l = 40 * kRadiansOfDegree;
  const double t = std::cos(h) * std::cos(h) * (a2 - 1) + 1;
  const double visibility =
      .5 / (std::cos(l) + std::sqrt(a2 + (1 - a2) * std::cos(l) * std::cos(l)));
  const double fresnel = .5 + .5 * std::pow(1 - std::cos(h), 5);
  const double expected = a2 / (t * t) * visibility * fresnel * std::cos(l);
  const std::string metal =
      "physical { base_color { value { r: .5 g: .5 b: .5 } } roughness { value: .5 } }";
  EXPECT_NEAR(grey(material_wall(metal) + sun(40)), expected, 1e-6);
  EXPECT_EQ(grey(material_wall(metal) + sun(120)), 0);
}

TEST(Physical, smooth_metal_mirrors_its_surroundings) {
  const std::string sky = "background { solid { r: 1 g: 1 b: 1 } }";
  const auto metal = [&](double roughness) {
    return material_wall(
        "physical { base_color { value { r: .5 g: .5 b: .5 } } roughness { value: " +
            std::to_string(roughness) + " } }",
        sky);
  };
  EXPECT_NEAR(grey(metal(0)), .5, 1e-6);
  EXPECT_NEAR(grey(metal(.5)), .125, 1e-6);
  EXPECT_EQ(grey(metal(1)), 0);
}

TEST(Physical, ambient_light_meets_base_colour_and_occlusion) {
  const std::string ambient = "settings { integrator { ambient { r: 1 g: 1 b: 1 } } } ";
  EXPECT_NEAR(grey(ambient +
                   material_wall("physical { base_color { value { r: .5 g: .5 b: .5 } } occlusion "
                                 "{ value: .5 } }")),
              .25, 1e-6);
  // What is smooth mirrors instead, and here there is nothing to mirror.
  EXPECT_EQ(grey(ambient + material_wall("physical { roughness { value: 0 } }")), 0);
}

TEST(Physical, covers_and_lets_through) {
  const std::string sky = "background { solid { r: 1 g: 1 b: 1 } }";
  EXPECT_NEAR(grey(material_wall("physical { transparency { value: .25 } }", sky)), .25, 1e-6);
  // Transmission: what is not mirrored by Fresnel goes through a thin sheet, in its colour.
  const double f = .04, sheet = 2 * f / (1 + f);
  EXPECT_NEAR(
      grey(material_wall("physical { metallic { value: 0 } transmission { value: 1 } thin: true "
                         "base_color { value { r: .5 g: .5 b: .5 } } }",
                         sky)),
      .5 * (1 - sheet) + sheet, 1e-6);
}

TEST(Physical, clear_coat_lies_over_all) {
  const std::string sky = "background { solid { r: 1 g: 1 b: 1 } }";
  EXPECT_NEAR(grey(material_wall("physical { clearcoat { value: 1 } }", sky)), .04, 1e-6);
  const double alpha = .045 * .045;  // the smoothest highlight
  EXPECT_NEAR(grey(material_wall("physical { clearcoat { value: 1 } }") + sun(0)),
              .96 / 4 + .04 / (alpha * alpha) / 4, 1e-2);
}

TEST(Conductor, mirrors_by_its_refractive_index) {
  const auto pixel = render_pixel(
      material_wall("conductor { eta { r: .18 g: .42 b: 1.37 } k { r: 3.42 g: 2.35 b: 1.77 } }",
                    "background { solid { r: 1 g: 1 b: 1 } }"));
  EXPECT_NEAR(pixel[0], (.82 * .82 + 3.42 * 3.42) / (1.18 * 1.18 + 3.42 * 3.42), 1e-6);
  EXPECT_NEAR(pixel[1], (.58 * .58 + 2.35 * 2.35) / (1.42 * 1.42 + 2.35 * 2.35), 1e-6);
  EXPECT_EQ(grey(material_wall("conductor { eta { g: 1 } k { g: 1 } }") + sun(0)), 0);
  EXPECT_GT(
      grey(material_wall("conductor { eta { g: 1 } k { g: 1 } roughness { value: .5 } }") + sun(0)),
      0);
}

TEST(Dielectric, is_clear_glass) {
  // Through a block of glass before a bright sky all light comes back somewhere: 1. With no sky
  // beyond, what is mirrored at the front is Fresnel's share.
  const std::string block =
      "nodes { shape { materials: 'm' box { min { x: -9 y: -9 z: -1 } max { "
      "x: 9 y: 9 z: 0 } } } } ";
  const std::string sky = "background { solid { r: 1 g: 1 b: 1 } } ";
  EXPECT_NEAR(grey("materials { name: 'm' dielectric {} } settings { integrator { max_depth: 40 } "
                   "} " +
                   block + sky),
              1, 1e-6);
  const double depth_1 = .04 + .96 * .96;  // two faces, what is mirrored inside cut off
  EXPECT_NEAR(grey("materials { name: 'm' dielectric { absorption { g: .5 } } } settings { "
                   "integrator { max_depth: 2 } } " +
                   block + sky),
              .04 + .96 * .96 * std::exp(-.5), 1e-6);
  EXPECT_NEAR(grey("materials { name: 'm' dielectric {} } settings { integrator { max_depth: 2 } "
                   "} " +
                   block + sky),
              depth_1, 1e-6);
  // A sheet: straight through, both faces at once.
  EXPECT_NEAR(
      grey(material_wall("dielectric { thin: true }", sky) + "settings { integrator { max_depth: 1 "
                                                             "} }"),
      1, 1e-6);
}

TEST(Dielectric, lets_light_through_to_what_is_behind) {
  const std::string scene =
      "materials { name: 'm' dielectric { refractive_index: 1 } } materials { name: "
      "'material_wall' classic "
      "{ diffuse { value { r: 1 g: 1 b: 1 } } } } nodes { shape { materials: 'material_wall' plane "
      "{ normal "
      "{ z: 1 } offset: -2 } } } nodes { shape { materials: 'm' sphere {} } } ";
  EXPECT_NEAR(grey(scene + sun(0)), 1, 1e-6);
}

/// A square across the view whose four corners have that normal.
std::string leaning(const std::string& material, double y, double z) {
  const std::string n = "0, " + std::to_string(y) + ", " + std::to_string(z);
  return "materials { name: 'm' " + material +
         " } nodes { shape { materials: 'm' mesh { inline_positions: [-9, -9, 0, 9, -9, 0, 9, 9, "
         "0, "
         "-9, 9, 0] inline_triangles: [0, 1, 2, 0, 2, 3] inline_normals: [" +
         n + ", " + n + ", " + n + ", " + n + "] } } } ";
}

TEST(LeaningNormals, light_changes_by_little_where_they_turn_away) {
  const std::string light = "nodes { light { directional { direction { y: -1 z: -.5 } } } } ";
  const std::string plastic =
      "physical { metallic { value: 0 } base_color { value { r: .5 g: .5 b: .5 } } }";
  for (const std::string kind : {"whitted", "path"}) {
    const std::string settings = "settings { integrator { kind: '" + kind + "' } } ";
    for (const std::string& material : {plastic, std::string("classic { }")}) {
      SCOPED_TRACE(kind + ", " + material);
      const auto seen = [&](double z) { return grey(settings + leaning(material, 1, z) + light); };
      // From the viewer's side to the other, where they also lean over the face's edge.
      EXPECT_GT(seen(.01), .3);
      EXPECT_NEAR(seen(-.01), seen(.01), .02);
      EXPECT_NEAR(seen(-.3), seen(-.28), .03);
      EXPECT_GT(seen(-.3), .2);
    }
  }
}

TEST(LeaningNormals, those_that_point_inward_are_turned) {
  const std::string light = "nodes { light { directional { direction { z: -1 } } } } ";
  EXPECT_NEAR(grey(leaning("classic { }", .3, -1) + light),
              grey(leaning("classic { }", -.3, 1) + light), 1e-9);
}

TEST(LeaningNormals, mirrors_and_glass_see_all_that_is_around_them) {
  const std::string sky = "background { solid { r: 1 g: 1 b: 1 } } ";
  for (const double z : {1., .6, .3, .05, -.1, -.4}) {
    SCOPED_TRACE(z);
    for (const std::string kind : {"whitted", "path"}) {
      const std::string settings = "settings { integrator { kind: '" + kind + "' } } ";
      EXPECT_NEAR(grey(settings + leaning("physical { roughness { value: 0 } }", 1, z) + sky), 1,
                  1e-6);
      EXPECT_NEAR(
          grey(settings +
               leaning("classic { diffuse { value { } } reflectivity { value { g: 1 } } }", 1, z) +
               sky),
          1, 1e-6);
    }
    EXPECT_NEAR(grey(leaning("dielectric { }", 1, z) + sky), 1, 1e-6);
  }
}

}  // namespace
}  // namespace tessera
