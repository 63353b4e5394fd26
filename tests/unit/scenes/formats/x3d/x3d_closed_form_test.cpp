// What clause 17 of ISO/IEC 19775-1 and the geometry clauses say of single pixels, from X3D's own
// text to the traced value. The camera is at a Viewpoint's default place, (0, 0, 10), looking along
// -z.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/scenes/formats/x3d/x3d_testing.h"

namespace tessera {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
const std::string kNoHeadlight = "NavigationInfo { headlight FALSE } ";

/// A white or other wall in the plane z = 0 that faces the camera.
std::string wall(const std::string& material = "", const std::string& more = "") {
  return "Shape { geometry Rectangle2D { size 8 8 } appearance Appearance { material Material { " +
         material + " } " + more + " } } ";
}

/// The wall turned by `degrees` about the y axis.
std::string turned_wall(double degrees, const std::string& material) {
  return "Transform { rotation 0 1 0 " + std::to_string(degrees * kDegree) + " children " +
         wall(material) + "} ";
}

void expect_pixel(const std::string& scene, double r, double g, double b, double most = 1e-6,
                  const std::string& version = "3.3") {
  const auto pixel = render_x3d(scene, 1, 1, version);
  EXPECT_NEAR(pixel[0], r, most) << scene;
  EXPECT_NEAR(pixel[1], g, most) << scene;
  EXPECT_NEAR(pixel[2], b, most) << scene;
}

void expect_grey(const std::string& scene, double level, double most = 1e-6) {
  expect_pixel(scene, level, level, level, most);
}

TEST(X3dClosedForm, c01_default_material_under_the_headlight_is_204) {
  expect_grey(wall(), .8);
  expect_grey("", 0);
  const auto scene = parse_classic(wall()).scene;
  EXPECT_EQ(scene.settings().output().transfer(), v1::Output::DISPLAY);
  EXPECT_EQ(std::lround(.8 * 255), 204);
}

TEST(X3dClosedForm, c02_ambient_light_meets_the_diffuse_colour) {
  expect_grey(kNoHeadlight + "DirectionalLight { ambientIntensity 1 intensity 0 } " + wall(), .16);
  expect_pixel(kNoHeadlight + "DirectionalLight { ambientIntensity 1 intensity 0 } " +
                   wall("diffuseColor 1 .5 0 ambientIntensity .5"),
               .5, .25, 0);
}

TEST(X3dClosedForm, c03_tilted_surface_and_highlight) {
  const std::string head_on = kNoHeadlight + "DirectionalLight { } ";
  expect_grey(head_on + turned_wall(60, ""), .4, 1e-5);
  // A light 20 degrees off the view: the half vector is 10 degrees off.
  const std::string off_20 = kNoHeadlight +
                             "DirectionalLight { direction -0.3420201433256687 0 "
                             "-0.9396926207859084 } ";
  expect_grey(off_20 + wall("diffuseColor 0 0 0 specularColor 1 1 1"), .6758, 5e-5);
  expect_grey(off_20 + wall("diffuseColor 0 0 0 specularColor 1 1 1"),
              std::pow(std::cos(10 * kDegree), 25.6));
  // No highlight where the light does not reach.
  expect_grey(kNoHeadlight + "DirectionalLight { direction 0.98 0 0.199 } " +
                  wall("diffuseColor 0 0 0 specularColor 1 1 1 shininess 0"),
              0);
}

TEST(X3dClosedForm, c04_attenuation_and_radius) {
  const auto at = [](double z, const std::string& more) {
    return kNoHeadlight + "PointLight { location 0 0 " + std::to_string(z) + " " + more + " } " +
           wall("diffuseColor 1 1 1");
  };
  expect_grey(at(2, "attenuation 0 0 1"), .25);
  expect_grey(at(.5, "attenuation 0 0 1"), 1);
  expect_grey(at(2, "attenuation 0 0 0"), 1);
  expect_grey(at(2, "radius 1.99"), 0);
  expect_grey(at(2, "radius 2.01"), 1);
  expect_grey(at(2, "radius 0"), 0);
  // Ambient light is attenuated too: 1/4 (.2 + 1).
  expect_grey(at(2, "attenuation 0 0 1 ambientIntensity 1"), .3);
  // In the light's own frame the wall is 1 away.
  expect_grey(kNoHeadlight +
                  "Transform { scale 2 2 2 children PointLight { location 0 0 1 "
                  "attenuation 0 0 1 radius 1.01 } } " +
                  wall("diffuseColor 1 1 1"),
              1);
}

TEST(X3dClosedForm, c05_spot_is_linear_in_angle) {
  const auto turned = [](double angle, const std::string& more = "beamWidth .2 cutOffAngle .6") {
    return kNoHeadlight + "SpotLight { location 0 0 1 direction " +
           std::to_string(std::sin(angle)) + " 0 " + std::to_string(-std::cos(angle)) + " " + more +
           " } " + wall("diffuseColor 1 1 1");
  };
  expect_grey(turned(.4), .5, 1e-5);
  expect_grey(turned(.2), 1, 1e-5);
  expect_grey(turned(.6), 0, 1e-5);
  expect_grey(turned(.3, "beamWidth .7 cutOffAngle .6"), 1);  // no soft edge
  // The defaults by version: VRML97 has a hard edge at pi/4.
  expect_pixel(turned(.78, ""), 1, 1, 1, 1e-6, "VRML");
  expect_pixel(turned(.79, ""), 0, 0, 0, 1e-6, "VRML");
  const double half = std::numbers::pi / 2;
  for (const auto& [version, beam] : {std::pair{"3.3", std::numbers::pi / 4}, {"4.0", .589049}}) {
    const double level = (1 - half) / (beam - half);
    expect_pixel(turned(1, ""), level, level, level, 1e-5, version);
  }
}

TEST(X3dClosedForm, c06_fog) {
  const auto at = [](double z, const std::string& type) {
    return "Fog { color 1 0 0 visibilityRange 10 fogType \"" + type +
           "\" } Background { skyColor 0 0 1 } Transform { translation 0 0 " + std::to_string(z) +
           " children Shape { geometry Rectangle2D { } appearance Appearance { material Material { "
           "diffuseColor 0 0 0 emissiveColor 0 1 0 } } } }";
  };
  expect_pixel(at(5, "LINEAR"), .5, .5, 0);
  expect_pixel(at(5, "EXPONENTIAL"), 1 - std::exp(-1), std::exp(-1), 0);
  expect_pixel(at(0, "LINEAR"), 1, 0, 0);
  expect_pixel(at(-1, "EXPONENTIAL"), 1, 0, 0);
  expect_pixel(at(20, "LINEAR"), 0, 0, 1);  // never before the background
  // In the fog's own frame the range is 20.
  expect_pixel(
      "Transform { scale 2 2 2 children Fog { color 1 0 0 visibilityRange 10 } } "
      "Shape { geometry Rectangle2D { } }",
      1, .5, .5);
}

/// Whether each pixel of the frame's middle row is white.
std::string middle_row(const std::string& scene, int width, int height) {
  const auto values = render_x3d(scene, width, height);
  std::string row;
  for (int x = 0; x < width; ++x)
    row += values[3 * (static_cast<size_t>(height / 2) * static_cast<size_t>(width) +
                       static_cast<size_t>(x))] > .5f
               ? '#'
               : '.';
  return row;
}

TEST(X3dClosedForm, c07_fields_of_view) {
  const auto card = [](double width, double height) {
    return "Shape { geometry Rectangle2D { size " + std::to_string(width) + " " +
           std::to_string(height) + " } } ";
  };
  // 72.73 degrees across 16:9, whose every pixel is 1/160 of it; a card that ends between pixels.
  const std::string view = "Viewpoint { fieldOfView 0.7854 } ";
  const double across = 20 * std::tan(72.73 / 2 * kDegree), tall = 20 * std::tan(22.5 * kDegree);
  EXPECT_EQ(middle_row(view + card(across * 158 / 160, 99), 160, 90),
            "." + std::string(158, '#') + ".");
  EXPECT_NEAR(across, tall * 16 / 9, 2e-3);
  // Portrait: 45 degrees across.
  EXPECT_EQ(middle_row(view + card(tall * 7 / 9, 99), 9, 16), ".#######.");
  // A pixel is 2 / min(w, h) wide.
  EXPECT_EQ(middle_row("OrthoViewpoint { } " + card(3.8, 99), 40, 20),
            "." + std::string(38, '#') + ".");
  EXPECT_EQ(middle_row("OrthoViewpoint { } " + card(1.8, 99), 20, 40),
            "." + std::string(18, '#') + ".");
}

TEST(X3dClosedForm, c08_normals_take_the_inverse_transpose) {
  // (1, 1, 1) under a scale of 1 2 4 is along (1, 1/2, 1/4).
  const std::string card =
      "Transform { scale 1 2 4 children Shape { appearance Appearance { material Material { "
      "diffuseColor 1 1 1 } } geometry TriangleSet { coord Coordinate { point [ -9 -9 0 9 -9 0 0 9 "
      "0 ] } normal Normal { vector [ 1 1 1 1 1 1 1 1 1 ] } } } }";
  expect_grey(card, .25 / std::sqrt(1 + .25 + .0625));
}

TEST(X3dClosedForm, c09_crease_angle_on_a_cube) {
  const auto normals = [](const std::string& angle) {
    const auto loaded = parse_classic(
        "Shape { geometry IndexedFaceSet { creaseAngle " + angle +
        " coordIndex [ 0 1 3 2 -1 4 6 7 5 -1 0 4 5 1 -1 2 3 7 6 -1 0 2 6 4 -1 1 5 7 3 -1 ] coord "
        "Coordinate { point [ 0 0 0, 0 0 1, 0 1 0, 0 1 1, 1 0 0, 1 0 1, 1 1 0, 1 1 1 ] } } }");
    return blob_values<float>(loaded.scene.nodes(0).shape().mesh().normals(), loaded.blobs);
  };
  for (const float n : normals("1.6")) EXPECT_NEAR(std::abs(n), 1 / std::sqrt(3), 1e-6);
  EXPECT_EQ(normals("1.6").size(), 24u);
  for (const char* flat : {"0", "1.5"})
    for (const float n : normals(flat)) EXPECT_TRUE(n == 0 || std::abs(n) == 1) << n;
}

/// A texture whose texels are red, green, blue and white: in one row, or bottom row first.
std::string pixels(int width, int height) {
  return "texture PixelTexture { image " + std::to_string(width) + " " + std::to_string(height) +
         " 3 0xFF0000 0x00FF00 0x0000FF 0xFFFFFF textureProperties TextureProperties { "
         "magnificationFilter \"NEAREST_PIXEL\" } } ";
}

std::string textured(const std::string& geometry, const std::string& texture) {
  return "Shape { appearance Appearance { " + texture + " } geometry " + geometry + " } ";
}

TEST(X3dClosedForm, c10_where_textures_lie) {
  // At +z s is 1/2, between the second and third of four columns; and so on around the sphere.
  const auto seen = [](double turn, double aside) {
    return "Transform { translation " + std::to_string(-aside) + " 0 0 rotation 0 1 0 " +
           std::to_string(turn) + " children " + textured("Sphere { }", pixels(4, 1)) + " }";
  };
  const double quarter = std::numbers::pi / 2;
  expect_pixel(seen(0, -.1), 0, 1, 0);
  expect_pixel(seen(0, .1), 0, 0, 1);
  expect_pixel(seen(-quarter, -.1), 0, 0, 1);  // +x: 3/4
  expect_pixel(seen(-quarter, .1), 1, 1, 1);
  expect_pixel(seen(quarter, -.1), 1, 0, 0);  // -x: 1/4
  expect_pixel(seen(quarter, .1), 0, 1, 0);
  expect_pixel(seen(2 * quarter, -.1), 1, 1, 1);  // the seam at the back
  expect_pixel(seen(2 * quarter, .1), 1, 0, 0);

  // Row 0 is the lower one; a box shows the picture upright, on its top with up at -z.
  const std::string view = "OrthoViewpoint { } ";
  const std::string box = textured("Box { }", pixels(2, 2));
  const std::vector<float> upright{0, 0, 1, 1, 1, 1, 1, 0, 0, 0, 1, 0};
  EXPECT_EQ(render_x3d(view + box, 2, 2), upright);
  EXPECT_EQ(render_x3d(view + "Transform { rotation 1 0 0 1.5707963 children " + box + " }", 2, 2),
            upright);
  EXPECT_EQ(render_x3d(view + "Transform { rotation 1 0 0 -1.5707963 children " + box + " }", 2, 2),
            upright);
  // A scale of 2 shows the picture at half the size: each pixel is a whole picture's quarter.
  EXPECT_EQ(render_x3d(view + textured("Box { }", pixels(2, 2) +
                                                      "textureTransform TextureTransform { scale 2 "
                                                      "2 translation -.125 -.125 }"),
                       2, 2),
            std::vector<float>({1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0}));
}

TEST(X3dClosedForm, c11_sky) {
  const auto up = [](double degrees) {
    return "Viewpoint { orientation 1 0 0 " + std::to_string(degrees * kDegree) +
           " } Background { skyColor [ 1 0 0, 0 0 1 ] skyAngle 1.5708 }";
  };
  expect_pixel(up(0), 0, 0, 1, 1e-5);
  expect_pixel(up(45), .5, 0, .5, 1e-5);
  expect_pixel(up(90), 1, 0, 0, 1e-5);
  expect_pixel(up(-30), 0, 0, 1, 1e-5);
}

TEST(X3dClosedForm, c12_textures_replace_or_multiply_by_version) {
  const auto scene = [](const std::string& image, const std::string& diffuse) {
    return wall("diffuseColor " + diffuse, "texture PixelTexture { image 1 1 " + image + " }");
  };
  const std::string red = scene("3 0xFF0000", "0 1 0");
  expect_pixel(red, 1, 0, 0);
  expect_pixel(red, 0, 0, 0, 1e-6, "4.0");
  expect_pixel(scene("1 51", "0 1 .5"), 0, .2, .1);  // grey stays a factor
  expect_pixel(scene("2 0xFF33", "0 1 0"), 0, .2, 0);
  ReadOptions modulate;
  modulate.x3d_texture = ReadOptions::X3dTexture::modulate;
  EXPECT_EQ(render_x3d(red, 1, 1, "3.3", modulate), std::vector<float>({0, 0, 0}));
  ReadOptions replace;
  replace.x3d_texture = ReadOptions::X3dTexture::replace;
  EXPECT_EQ(render_x3d(red, 1, 1, "4.0", replace), std::vector<float>({1, 0, 0}));
}

TEST(X3dClosedForm, colours_of_points_take_the_materials_place) {
  const auto quad = [](const std::string& color, const std::string& material) {
    return "Background { skyColor 0 0 1 } Shape { appearance Appearance { " + material +
           " } geometry QuadSet { solid FALSE coord Coordinate { point [ -1 -1 0 1 -1 0 1 1 0 -1 1 "
           "0 ] } color " +
           color + " } } ";
  };
  const std::string red = "Color { color [ 1 0 0 1 0 0 1 0 0 1 0 0 ] }";
  const std::string half = "ColorRGBA { color [ 1 0 0 .5 1 0 0 .5 1 0 0 .5 1 0 0 .5 ] }";
  expect_pixel(quad(red, "material Material { diffuseColor 0 1 0 }"), 1, 0, 0);
  expect_pixel(quad(red, ""), 1, 0, 0);
  expect_pixel(quad(red, "material UnlitMaterial { emissiveColor 0 1 0 }"), 1, 0, 0);
  expect_pixel(quad(half, "material Material { transparency .9 }"), .5, 0, .5);
  expect_pixel(quad(red, "material Material { transparency .75 }"), .25, 0, .75);
}

TEST(X3dClosedForm, sides_have_their_own_materials) {
  const auto seen = [](const std::string& turn, const std::string& solid) {
    return "Background { skyColor 0 0 1 } Transform { " + turn +
           " children Shape { appearance Appearance { material TwoSidedMaterial { diffuseColor 1 0 "
           "0 separateBackColor TRUE backDiffuseColor 0 1 0 } } geometry Rectangle2D { solid " +
           solid + " } } }";
  };
  const std::string back = "rotation 0 1 0 3.14159265358979";
  expect_pixel(seen("", "FALSE"), 1, 0, 0);
  expect_pixel(seen(back, "FALSE"), 0, 1, 0);
  expect_pixel(seen(back, "TRUE"), 0, 0, 1);
}

TEST(X3dClosedForm, what_has_no_material_is_not_lit) {
  expect_grey(kNoHeadlight + "Shape { geometry Box { } }", 1);
  expect_pixel(kNoHeadlight +
                   "Shape { geometry Box { } appearance Appearance { texture "
                   "PixelTexture { image 1 1 3 0x3300FF } } }",
               .2, 0, 1);
  expect_pixel(kNoHeadlight +
                   "Shape { geometry Box { } appearance Appearance { material "
                   "UnlitMaterial { emissiveColor .25 .5 1 } } }",
               .25, .5, 1);
}

TEST(X3dClosedForm, mirror_is_the_share_that_is_mirrored) {
  // The wall mirrors the glowing ball behind the camera.
  expect_pixel(wall("diffuseColor 1 0 0 mirror .75") +
                   "Transform { translation 0 0 13 children Shape { geometry Sphere { } appearance "
                   "Appearance { material UnlitMaterial { emissiveColor 0 1 0 } } } }",
               .25, .75, 0);
}

TEST(X3dClosedForm, units_scale_lengths_and_angles) {
  // A centimetre a unit: the default camera's 10 and the ball's 1 shrink alike, the fog's range
  // too.
  expect_grey("UNIT length centimetre 0.01 " + wall(), .8);
  expect_pixel(
      "UNIT length centimetre 0.01 Viewpoint { } Fog { color 1 0 0 visibilityRange 20 } "
      "Shape { geometry Rectangle2D { } }",
      1, .5, .5);
  expect_pixel(
      "UNIT angle degree 0.017453292519943295 Viewpoint { orientation 1 0 0 45 } "
      "Background { skyColor [ 1 0 0, 0 0 1 ] skyAngle 90 }",
      .5, 0, .5, 1e-5);
}

/// The numbers of lit pixels in the rows that have any.
std::vector<int> lit_rows(const std::vector<float>& pixels, int width) {
  std::vector<int> rows;
  for (size_t at = 0; at < pixels.size(); at += 3 * static_cast<size_t>(width)) {
    int count = 0;
    for (size_t x = 0; x < static_cast<size_t>(width); ++x) count += pixels[at + 3 * x] > 0;
    if (count > 0) rows.push_back(count);
  }
  return rows;
}

TEST(X3dClosedForm, a_billboard_without_an_axis_is_parallel_to_the_screen) {
  const std::string card = "Shape { geometry Rectangle2D { size 2 2 solid FALSE } } ";
  const std::string at =
      "Viewpoint { position 0 0 6 fieldOfView 1.5707963 } Transform { "
      "translation 4 3 0 rotation 1 1 0 .4 children Billboard { ";
  // As wide as high in each row: 2 m of the 12 m that 120 pixels see at that distance.
  EXPECT_EQ(
      lit_rows(render_x3d(at + "axisOfRotation 0 0 0 children " + card + "} }", 120, 120), 120),
      std::vector<int>(20, 20));
  // About y it turns to the viewer's place instead, and is seen aslant.
  EXPECT_NE(lit_rows(render_x3d(at + "children " + card + "} }", 120, 120), 120),
            std::vector<int>(20, 20));
}

}  // namespace
}  // namespace tessera
