// Whole renders of scenes whose pixel is known in closed form. The camera of every scene is X3D's
// default one: at (0, 0, 10), looking along -z.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// A wall in the plane z = 0 that faces the camera, of material 'm'.
std::string wall(const std::string& classic) {
  return "materials { name: 'm' classic { " + classic + " } }" +
         "nodes { shape { materials: 'm' plane { normal { z: 1 } } } }";
}

std::string light(const std::string& fields) { return "nodes { light { " + fields + " } }"; }

std::string head_on(const std::string& fields = "") {
  return light("directional { direction { z: -1 } } " + fields);
}

void expect_pixel(const std::string& scene, double r, double g, double b) {
  const auto pixel = render_pixel(scene);
  EXPECT_FLOAT_EQ(pixel[0], static_cast<float>(r)) << scene;
  EXPECT_FLOAT_EQ(pixel[1], static_cast<float>(g)) << scene;
  EXPECT_FLOAT_EQ(pixel[2], static_cast<float>(b)) << scene;
}

void expect_grey(const std::string& scene, double level) {
  expect_pixel(scene, level, level, level);
}

TEST(ClosedForm, x3d_ambient_light_meets_ambient_colour) {
  expect_grey(wall("ambient { value { r: .16 g: .16 b: .16 } }") +
                  head_on("intensity: 0 ambient_intensity: 1"),
              0.16);
  expect_grey(wall("ambient { value { r: .5 g: .5 b: .5 } }") +
                  "settings { integrator { ambient { r: .5 g: .5 b: .5 } } }",
              0.25);
}

TEST(ClosedForm, x3d_tilted_surface_and_highlight) {
  const double tilt = 60 * kDegree;
  const std::string tilted = "directional { direction { x: " + std::to_string(-std::sin(tilt)) +
                             " z: " + std::to_string(-std::cos(tilt)) + " } }";
  const auto pixel = render_pixel(wall("") + light(tilted));
  EXPECT_NEAR(pixel[0], 0.4, 1e-6);
  // The half vector of a light 20 degrees off the view is 10 degrees off it.
  const std::string shiny = wall("diffuse { value {} } specular { value { r: 1 g: 1 b: 1 } }");
  const std::string off_20 =
      "directional { direction { x: -0.3420201433256687 z: -0.9396926207859084 } }";
  EXPECT_NEAR(render_pixel(shiny + light(off_20))[0], 0.6758, 5e-5);
  // Phong's reflection vector is 20 degrees off.
  const std::string phong = wall(
      "diffuse { value {} } specular { value { r: 1 g: 1 b: 1 } } shininess { value: 3 } "
      "specular_model: PHONG");
  EXPECT_NEAR(render_pixel(phong + light(off_20))[0], std::pow(std::cos(20 * kDegree), 3), 1e-6);
}

TEST(ClosedForm, diffuse_models_behind_the_surface) {
  // The light is behind the wall, 60 degrees off its normal: n . l = -1/2.
  const std::string behind = light("directional { direction { x: .8660254037844386 z: .5 } }") +
                             "settings { integrator { shadows: SHADOWS_OFF } }";
  expect_grey(wall("diffuse_model: LAMBERT") + behind, 0);
  expect_grey(wall("diffuse_model: SIGNED") + behind, -0.4);
  expect_grey(wall("diffuse_model: HALF_LAMBERT") + behind, 0.8 / 64);
  expect_grey(wall("diffuse_model: HALF_LAMBERT diffuse_exponent: 1") + behind, 0.2);
}

TEST(ClosedForm, x3d_point_light_attenuation_and_radius) {
  const auto at = [](double z, const std::string& more) {
    return wall("diffuse { value { r: 1 g: 1 b: 1 } }") +
           light("point { position { z: " + std::to_string(z) + " } } " + more);
  };
  const std::string x3d = "attenuation { quadratic: 1 at_most_one: true } ";
  expect_grey(at(2, x3d), 0.25);
  expect_grey(at(.5, x3d), 1);
  expect_grey(at(.5, "attenuation { quadratic: 1 } "), 4);
  expect_grey(at(2, "attenuation { constant: 1 linear: 2 quadratic: 3 scale: 34 }"), 2);
  expect_grey(at(2, "radius: 2"), 1);
  expect_grey(at(2, "radius: 1.999"), 0);
  expect_grey(at(2, ""), 1);
  // The way from the camera counts: (2 + 10)^2.
  expect_grey(at(2, "attenuation { quadratic: 1 distance: PATH scale: 144 }"), 1);
}

TEST(ClosedForm, light_distances_are_of_its_own_frame) {
  // Scaled by 2, the wall is 2 of the light's metres away.
  expect_grey(wall("diffuse { value { r: 1 g: 1 b: 1 } }") +
                  "nodes { transform { steps { scale { x: 2 y: 2 z: 2 } } } light { point { "
                  "position { z: 2 } } attenuation { quadratic: 1 } } }",
              0.25);
}

TEST(ClosedForm, ambient_light_is_attenuated_on_demand) {
  const std::string lit = wall("diffuse { value {} } ambient { value { r: 1 g: 1 b: 1 } }");
  const std::string lamp =
      "point { position { z: 2 } } ambient_intensity: .8 radius: 3 "
      "attenuation { quadratic: 1 } ";
  expect_grey(lit + light(lamp), .8);
  expect_grey(lit + light(lamp + "ambient_attenuated: true"), .2);
  expect_grey(lit + light("point { position { z: 4 } } ambient_intensity: .8 radius: 3 "), .8);
  expect_grey(lit + light("point { position { z: 4 } } ambient_intensity: .8 radius: 3 "
                          "ambient_attenuated: true"),
              0);
}

TEST(ClosedForm, flat_materials_use_the_face_normal) {
  // Every vertex normal is 60 degrees off the face's.
  const auto lit = [](const char* more) {
    return std::string("materials { name: 'm' classic { ") + more + " } } " + head_on() +
           "nodes { shape { materials: 'm' mesh { inline_positions: [-9,-9,0, 9,-9,0, 0,9,0] "
           "inline_triangles: [0,1,2] inline_normals: [1.7320508,0,1, 1.7320508,0,1, "
           "1.7320508,0,1] } } }";
  };
  EXPECT_NEAR(render_pixel(lit(""))[0], 0.4, 1e-6);
  EXPECT_NEAR(render_pixel(lit("flat: true"))[0], 0.8, 1e-6);
}

TEST(ClosedForm, x3d_spot_light_is_linear_in_angle) {
  // The spot is 1 above the wall and turned by `degrees` from the point that the camera sees.
  const auto turned = [](double degrees) {
    return wall("diffuse { value { r: 1 g: 1 b: 1 } }") +
           light("spot { position { z: 1 } direction { x: " +
                 std::to_string(std::sin(degrees * kDegree)) +
                 " z: " + std::to_string(-std::cos(degrees * kDegree)) +
                 " } beam_width: 11.459155902616464 cut_off: 34.37746770784939 }");
  };
  EXPECT_NEAR(render_pixel(turned(0.4 / kDegree))[0], 0.5, 1e-5);
  EXPECT_NEAR(render_pixel(turned(0.2 / kDegree))[0], 1, 1e-5);
  EXPECT_NEAR(render_pixel(turned(0.6 / kDegree))[0], 0, 1e-5);
  EXPECT_EQ(render_pixel(turned(0.7 / kDegree))[0], 0);
  EXPECT_EQ(render_pixel(turned(0.1 / kDegree))[0], 1);
}

TEST(ClosedForm, x3d_fog) {
  const auto at = [](double z, const std::string& kind) {
    return "materials { name: 'm' unlit { color { value { g: 1 } } } } fog { visibility_range: 10 "
           "kind: " +
           kind + " color { r: 1 } } background { solid { b: 1 } }" +
           "nodes { shape { materials: 'm' plane { normal { z: 1 } offset: " + std::to_string(z) +
           " } } }";
  };
  expect_pixel(at(5, "LINEAR"), .5, .5, 0);
  expect_pixel(at(5, "EXPONENTIAL"), 1 - std::exp(-1), std::exp(-1), 0);
  expect_pixel(at(-1, "LINEAR"), 1, 0, 0);
  expect_pixel(at(20, "LINEAR"), 0, 0, 1);  // behind the camera: fog does not reach the background
}

TEST(ClosedForm, shadows) {
  const std::string lit = wall(
      "diffuse { value { r: 1 g: 1 b: 1 } } "
      "ambient { value { r: 1 g: 1 b: 1 } }");
  // A ball between light and wall, beside the view.
  const std::string lamp =
      "point { position { x: 4 z: 4 } } attenuation { scale: 1.4142135623730951 "
      "constant: 1 } ";
  const auto ball = [](const char* more, const char* fields) {
    return std::string("materials { name: 'b' classic { ") + fields +
           " } } nodes { transform { steps { translate { x: 2 z: 2 } } } " + more +
           " shape { materials: 'b' sphere { radius: .5 } } }";
  };
  expect_grey(lit + light(lamp), 1);
  expect_grey(lit + light(lamp) + ball("", ""), 0);
  expect_grey(lit + light(lamp + "ambient_intensity: .25") + ball("", ""), 0.25);
  expect_grey(lit + light(lamp) + ball("casts_no_shadow: true", ""), 1);
  expect_grey(lit + light(lamp) + ball("hidden: true", ""), 1);
  expect_grey(lit + light(lamp + "shadow_intensity: .75") + ball("", ""), .25);
  expect_grey(lit + light(lamp + "shadow_distance: 2") + ball("", ""), 1);
  expect_grey(lit + light(lamp + "shadow_distance: 3") + ball("", ""), 0);
  expect_grey(lit + light(lamp) + ball("", "") + "settings { integrator { shadows: SHADOWS_OFF } }",
              1);
  const std::string by_light = "settings { integrator { shadows: SHADOWS_BY_LIGHT } }";
  expect_grey(lit + light(lamp) + ball("", "") + by_light, 1);
  expect_grey(lit + light(lamp + "shadows: true") + ball("", "") + by_light, 0);
  // Through the ball's two sides.
  expect_grey(lit + light(lamp) + ball("", "transparency { value: .5 } transmission: STRAIGHT"),
              0.25);
  expect_pixel(lit + light(lamp) + ball("", "transparency { value: 1 } absorption { r: 1 g: 2 }"),
               std::exp(-1), std::exp(-2), 1);
}

// Of the way of the light only its first half metre lies in the glass around it.
TEST(ClosedForm, a_light_inside_an_absorbing_ball_is_absorbed) {
  expect_pixel(
      wall("diffuse { value { r: 1 g: 1 b: 1 } }") +
          light("point { position { x: 4 z: 4 } } attenuation { scale: 1.4142135623730951 "
                "constant: 1 } ") +
          "materials { name: 'b' classic { transparency { value: 1 } absorption { r: 1 g: 2 } } } "
          "nodes { shape { materials: 'b' sphere { center { x: 4 z: 4 } radius: .5 } } }",
      std::exp(-.5), std::exp(-1), 1);
}

TEST(ClosedForm, what_lies_behind_the_light_throws_no_shadow) {
  expect_grey(wall("diffuse { value { r: 1 g: 1 b: 1 } }") + light("point { position { z: 2 } }") +
                  "nodes { shape { sphere { center { z: 20 } } } }" +
                  "nodes { shape { sphere { center { z: 3.5 } } } }" +
                  "cameras { world_from_camera { steps { translate { z: 1 } } } }",
              1);
}

TEST(ClosedForm, straight_transparency_covers_the_rest) {
  expect_pixel(wall("diffuse { value {} } emission { value { r: 1 } } transparency { value: .25 } "
                    "transmission: STRAIGHT") +
                   "background { solid { b: 1 } }",
               .75, 0, .25);
}

TEST(ClosedForm, mirrors_show_what_is_before_them) {
  // Facing the camera, the wall mirrors the ball behind the camera, which is lit from the front.
  expect_pixel(wall("diffuse { value {} } reflectivity { value { r: .5 g: .25 b: 1 } }") +
                   "materials { name: 'glow' unlit { color { value { r: 1 g: 1 b: .5 } } } }" +
                   "nodes { shape { materials: 'glow' sphere { center { z: 13 } } } }",
               .5, .25, .5);
}

TEST(ClosedForm, glass_follows_fresnel_and_snell) {
  // One side of glass seen head-on: 4 % are mirrored, the rest goes on.
  const std::string glass =
      wall("diffuse { value {} } transparency { value: 1 } refractive_index: 1.5");
  expect_pixel(glass + "background { gradient { sky { r: 1 } ground { r: 1 } } }", 1, 0, 0);
  expect_pixel(glass +
                   "materials { name: 'glow' unlit { color { value { g: 1 } } } } "
                   "nodes { shape { materials: 'glow' sphere { center { z: 13 } } } }",
               0, .04, 0);
  // A slab: T = 12/13 with all inner reflections (numerics.md 3.1, 12).
  const std::string slab =
      "settings { integrator { max_depth: 40 } } materials { name: 'm' classic { diffuse { value "
      "{} } "
      "transparency { value: 1 } refractive_index: 1.5 } } nodes { shape { materials: 'm' box { "
      "min { "
      "x: -9 y: -9 } max { x: 9 y: 9 z: 1 } } } } materials { name: 'glow' unlit { color { value { "
      "g: 1 } } } } nodes { shape { materials: 'glow' sphere { center { z: -3 } } } }";
  EXPECT_NEAR(render_pixel(slab)[1], 12.0 / 13, 1e-7);
  // The slab of absorbing glass.
  const double r = 0.04, tau = std::exp(-0.5);
  const std::string absorbing =
      slab +
      "materials { name: 'a' classic { diffuse { value {} } transparency { value: 1 } "
      "refractive_index: 1.5 absorption { g: .5 } } }";
  std::string replaced = absorbing;
  replaced.replace(replaced.find("materials: 'm'"), 14, "materials: 'a'");
  EXPECT_NEAR(render_pixel(replaced)[1], (1 - r) * (1 - r) * tau / (1 - r * r * tau * tau), 1e-7);
}

// A ray leaves a tilted slab as it came, but moved aside: a small ball is seen where Snell's law
// puts it, and nowhere else.
TEST(ClosedForm, a_tilted_slab_moves_the_view_aside) {
  const double tilt = 40 * kDegree, n = 1.5, thickness = 2;
  const double cos_i = std::cos(tilt), cos_t = std::sqrt(1 - std::pow(std::sin(tilt) / n, 2));
  const double aside = thickness / cos_t * std::sin(tilt) * (cos_t - cos_i / n);
  const double parallel = (n * cos_i - cos_t) / (n * cos_i + cos_t);
  const double across = (cos_i - n * cos_t) / (cos_i + n * cos_t);
  const double fresnel = (parallel * parallel + across * across) / 2;
  const auto seen = [&](double y) {
    return render_pixel(
        "materials { name: 'm' classic { diffuse { value {} } transparency { value: 1 } "
        "refractive_index: 1.5 } } materials { name: 'glow' unlit {} } "
        "nodes { transform { steps { rotate { axis { x: 1 } angle: 40 } } } shape { materials: 'm' "
        "box { min { x: -20 y: -20 z: -1 } max { x: 20 y: 20 z: 1 } } } } "
        "nodes { shape { materials: 'glow' sphere { radius: .01 center { z: -30 y: " +
        std::to_string(y) + " } } } }")[0];
  };
  EXPECT_NEAR(seen(aside), (1 - fresnel) * (1 - fresnel), 1e-6);
  EXPECT_EQ(seen(0), 0);
  EXPECT_EQ(seen(-aside), 0);
}

TEST(ClosedForm, sides) {
  // The camera sees the back of a wall whose normal points away from it.
  const std::string wall_back =
      "nodes { shape { materials: 'm' plane { normal { z: -1 } } } } background { solid { b: 1 } }";
  const auto material = [](const char* more) {
    return std::string(
               "materials { name: 'm' classic { diffuse { value {} } emission { value { r: 1 } } "
               "} ") +
           more + " } materials { name: 'other' unlit { color { value { g: 1 } } } }";
  };
  expect_pixel(material("") + wall_back, 1, 0, 0);
  expect_pixel(material("sides: FRONT_ONLY") + wall_back, 0, 0, 1);
  expect_pixel(material("sides: BACK_MATERIAL back: 'other'") + wall_back, 0, 1, 0);
  const std::string flipped =
      "nodes { shape { flip_normals: true materials: 'm' plane { normal { z: -1 } } } }";
  expect_pixel(material("sides: FRONT_ONLY") + flipped, 1, 0, 0);
}

TEST(ClosedForm, two_sided_surfaces_are_lit_towards_the_viewer) {
  expect_grey("nodes { shape { plane { normal { z: -1 } } } } " + head_on(), 0.8);
}

TEST(ClosedForm, scoped_lights_reach_siblings_and_what_is_below) {
  const std::string lamp = "nodes { light { scoped: true directional { direction { z: -1 } } } }";
  const auto group = [](const std::string& inside) {
    return "nodes { children { " + inside + "}}";
  };
  const std::string sphere = "shape { plane { normal { z: 1 } } } ";
  const std::string scoped_lamp = "light { scoped: true directional { direction { z: -1 } } } ";
  expect_grey(lamp + group(sphere), 0.8);
  expect_grey("nodes { children { " + scoped_lamp + "} children { " + sphere + "} }", 0.8);
  expect_grey("nodes { children { " + scoped_lamp + "} } " + group(sphere), 0);
  expect_grey("objects { name: 'o' nodes { " + sphere + " } } nodes { children { " + scoped_lamp +
                  "} children { instance_of: 'o' } }",
              0.8);
}

TEST(ClosedForm, backgrounds) {
  const auto seen = [](double degrees_up, const std::string& background) {
    return "cameras { world_from_camera { steps { rotate { axis { x: 1 } angle: " +
           std::to_string(degrees_up) + " } } } } background { " + background + " }";
  };
  const std::string gradient = "gradient { sky { r: 1 } ground { b: 1 } ";
  expect_pixel(seen(30, gradient + "}"), .75, 0, .25);
  expect_pixel(seen(-30, gradient + "}"), .25, 0, .75);
  expect_pixel(seen(-30, gradient + "model: ABSOLUTE_Y }"), .5, 0, .5);
  const std::string rings = "rings { sky { r: 1 } sky { b: 1 } sky_angles: 90 ";
  expect_pixel(seen(45, rings + "}"), .5, 0, .5);
  expect_pixel(seen(-45, rings + "}"), 0, 0, 1);
  const std::string ground = "ground { g: 1 } ground { } ground_angles: 60 }";
  expect_pixel(seen(-45, rings + ground), 0, .25, 0);
  expect_pixel(seen(-15, rings + ground), 0, 0, 1);
  expect_pixel(seen(0, gradient + "} orientation { steps { rotate { axis { x: 1 } angle: 90 } } }"),
               0, 0, 1);
  expect_grey(seen(60, "solid { r: .1 g: .1 b: .1 } glow: .5") +
                  light("directional { direction { y: -1 } }"),
              .1 + .5 * std::cos(30 * kDegree));
}

TEST(ClosedForm, keyframes_move_things) {
  const std::string moving =
      "materials { name: 'm' unlit {} } nodes { shape { materials: 'm' box {} } "
      "keys { time: 1 transform { steps { translate { x: 0 } } } } "
      "keys { time: 3 transform { steps { translate { x: 40 } } } } }";
  const auto at = [&](double time) {
    v1::FrameSettings frame = frame_of(1, 1);
    frame.set_time(time);
    return render_rect(*make_tile_renderer(parse_scene(moving), {}, frame, 1), {0, 0, 1, 1})
        .values[0];
  };
  EXPECT_EQ(at(0), 1);
  EXPECT_EQ(at(1), 1);
  EXPECT_EQ(at(1.04), 1);
  EXPECT_EQ(at(1.06), 0);
  EXPECT_EQ(at(9), 0);
}

}  // namespace
}  // namespace tessera
