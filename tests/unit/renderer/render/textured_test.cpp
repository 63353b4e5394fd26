// Whole renders of textured scenes whose pixels are known in closed form. The camera of every scene
// is X3D's default one: at (0, 0, 10), looking along -z.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

constexpr char kHeadOn[] = "nodes { light { directional { direction { z: -1 } } } } ";

/// An 8-bit linear image called `name`; one level, filtered as `more` says.
std::string image(BlobStore& blobs, const std::string& name, int width, int height, int channels,
                  std::initializer_list<int> values, const std::string& more = "filter: NEAREST") {
  std::vector<std::byte> texels;
  for (const int value : values) texels.push_back(static_cast<std::byte>(value));
  return "textures { name: '" + name + "' image { texels { digest: '" +
         blobs.put(std::move(texels)).hex() + "' } width: " + std::to_string(width) +
         " height: " + std::to_string(height) + " channels: " + std::to_string(channels) +
         " bits: 8 encoding: ENCODING_LINEAR " + more + " } } ";
}

/// A square from (-size, -size) to (size, size) of material 'm', uv from its lower left corner.
std::string square(double size = 1, const std::string& more = "") {
  const auto number = [](double v) { return std::to_string(v); };
  return "nodes { " + more + " shape { materials: 'm' rectangle { corner { x: " + number(-size) +
         " y: " + number(-size) + " } edge_u { x: " + number(2 * size) +
         " } edge_v { y: " + number(2 * size) + " } } } } ";
}

std::string material(const std::string& fields) {
  return "materials { name: 'm' " + fields + " } ";
}

void expect_pixel(const std::string& scene, const BlobStore& blobs, double r, double g, double b) {
  const auto pixel = render_text(scene, 1, 1, blobs).values;
  EXPECT_NEAR(pixel[0], r, 1e-6) << scene;
  EXPECT_NEAR(pixel[1], g, 1e-6) << scene;
  EXPECT_NEAR(pixel[2], b, 1e-6) << scene;
}

TEST(Textured, rows_of_an_image_go_down_and_v_goes_up) {
  BlobStore blobs;
  const std::string scene =
      "cameras { orthographic {} world_from_camera { steps { translate { z: "
      "10 } } } } " +
      image(blobs, "t", 2, 2, 1, {51, 102, 153, 204}) +
      material("unlit { color { texture: 't' } }") + square();
  const auto tile = render_text(scene, 2, 2, blobs);
  EXPECT_FLOAT_EQ(tile.values[0], .2f);
  EXPECT_FLOAT_EQ(tile.values[3], .4f);
  EXPECT_FLOAT_EQ(tile.values[6], .6f);
  EXPECT_FLOAT_EQ(tile.values[9], .8f);
}

TEST(Textured, x3d_textures_replace_or_multiply) {
  BlobStore blobs;
  const std::string red = image(blobs, "red", 1, 1, 3, {255, 0, 0}),
                    grey = image(blobs, "grey", 1, 1, 1, {51});
  const auto scene = [&](const std::string& texture, const std::string& more) {
    return red + grey + kHeadOn + square() +
           material("classic { diffuse { value { g: 1 } texture: '" + texture + "' } " + more +
                    " }");
  };
  expect_pixel(scene("red", "texture_replaces_diffuse: true"), blobs, 1, 0, 0);
  expect_pixel(scene("red", ""), blobs, 0, 0, 0);
  expect_pixel(scene("grey", "texture_replaces_diffuse: true"), blobs, 0, .2, 0);
}

TEST(Textured, every_input_of_classic) {
  BlobStore blobs;
  const std::string half = image(blobs, "t", 1, 1, 3, {51, 102, 255}) + kHeadOn + square() +
                           "settings { integrator { ambient { r: 1 g: 1 b: 1 } } } background { "
                           "solid { r: 1 g: 1 b: 1 } } ";
  const std::string dark = "classic { diffuse { value {} } ";
  expect_pixel(half + material(dark + "ambient { texture: 't' } }"), blobs, .2, .4, 1);
  expect_pixel(half + material(dark + "emission { texture: 't' value { r: 2 } } }"), blobs, .4, 0,
               0);
  expect_pixel(half + material(dark + "specular { texture: 't' } }"), blobs, .2, .4, 1);
  expect_pixel(half + material(dark + "reflectivity { texture: 't' } }"), blobs, .2, .4, 1);
  expect_pixel(half + material(dark + "transparency { texture: 't' channel: GREEN } transmission: "
                                      "STRAIGHT }"),
               blobs, .4, .4, .4);
  expect_pixel(half + material("classic { diffuse { texture: 't' } ambient { value { r: .5 g: .5 "
                               "b: .5 } } ambient_times_diffuse: true }"),
               blobs, .3, .6, 1.5);
  // Highlights 20 degrees off: the exponent is 10 * .4.
  const std::string off = image(blobs, "t", 1, 1, 3, {51, 102, 255}) + square() +
                          "nodes { light { directional { direction { x: -0.6427876096865393 z: "
                          "-0.766044443118978 } } } } ";
  const double expected = std::pow(std::cos(20 * std::acos(-1) / 180), 4);
  expect_pixel(off + material(dark + "specular { value { r: 1 g: 1 b: 1 } } shininess { value: 10 "
                                     "texture: 't' channel: GREEN } }"),
               blobs, expected, expected, expected);
}

TEST(Textured, alpha_modes) {
  BlobStore blobs;
  const auto scene = [&](int alpha, const std::string& more) {
    return image(blobs, "t", 1, 1, 4, {255, 255, 255, alpha}) + square() +
           "background { solid { g: 1 } } " + material("unlit { color { texture: 't' } } " + more);
  };
  expect_pixel(scene(102, ""), blobs, .4, 1, .4);
  expect_pixel(scene(102, "alpha: ALPHA_OPAQUE"), blobs, 1, 1, 1);
  expect_pixel(scene(102, "alpha: ALPHA_MASK"), blobs, 0, 1, 0);
  expect_pixel(scene(128, "alpha: ALPHA_MASK"), blobs, 1, 1, 1);
  expect_pixel(scene(102, "alpha: ALPHA_MASK alpha_cutoff: .3"), blobs, 1, 1, 1);
  expect_pixel(scene(102, "opacity { value: .5 }"), blobs, .2, 1, .2);
  expect_pixel(scene(102, "opacity { texture: 't' channel: ALPHA }"), blobs, .16, 1, .16);
}

TEST(Textured, x3d_alpha_takes_the_place_of_transparency) {
  BlobStore blobs;
  const std::string scene = image(blobs, "t", 1, 1, 4, {255, 0, 0, 51}) + square() + kHeadOn +
                            "background { solid { g: 1 } } ";
  const std::string classic =
      "classic { diffuse { texture: 't' } transparency { value: .5 } transmission: STRAIGHT ";
  expect_pixel(scene + material(classic + "texture_replaces_diffuse: true }"), blobs, .2, .8, 0);
  expect_pixel(scene + material(classic + "}"), blobs, .1, .9, 0);
}

TEST(Textured, shadows_are_as_clear_as_the_texture) {
  BlobStore blobs;
  // The light comes from the viewer's side past a small half-transparent square that the camera
  // does not see.
  const auto scene = [&](int alpha, const std::string& more) {
    return image(blobs, "t", 1, 1, 2, {255, alpha}) +
           material("classic { diffuse { texture: 't' } } " + more) +
           "nodes { light { directional { direction { x: 1 z: -1 } } } } materials { name: 'wall' "
           "classic { diffuse { value { r: 1 g: 1 b: 1 } } } } nodes { shape { materials: 'wall' "
           "plane { normal { z: 1 } } } } " +
           square(.5, "transform { steps { translate { x: -3 z: 3 } } }");
  };
  const double lit = std::sqrt(.5);
  expect_pixel(scene(255, ""), blobs, 0, 0, 0);
  expect_pixel(scene(51, ""), blobs, lit * .8, lit * .8, lit * .8);
  expect_pixel(scene(51, "alpha: ALPHA_MASK"), blobs, lit, lit, lit);
  expect_pixel(scene(51, "alpha: ALPHA_OPAQUE"), blobs, 0, 0, 0);
}

TEST(Textured, vertex_colours_and_textures) {
  BlobStore blobs;
  const float rgba[] = {1, .5f, 0, 1, 1, .5f, 0, 1, 1, .5f, 0, 1};
  std::vector<std::byte> colors(sizeof rgba);
  std::memcpy(colors.data(), rgba, sizeof rgba);
  const std::string mesh =
      "nodes { shape { materials: 'm' mesh { inline_positions: [-9,-9,0, 9,-9,0, 0,9,0] "
      "inline_triangles: [0,1,2] inline_uvs: [0,0, 0,0, 0,0] colors { size: 48 digest: '" +
      blobs.put(std::move(colors)).hex() + "' } } } } ";
  const std::string base = mesh + kHeadOn + image(blobs, "grey", 1, 1, 1, {51}) +
                           image(blobs, "blue", 1, 1, 3, {0, 0, 255});
  const auto classic = [&](const std::string& fields) {
    return base + material("classic { diffuse { value { r: .5 g: .5 b: .5 } " + fields + " }");
  };
  expect_pixel(classic("}"), blobs, .5, .25, 0);
  expect_pixel(classic("} vertex_color_replaces_diffuse: true"), blobs, 1, .5, 0);
  expect_pixel(classic("texture: 'grey' }"), blobs, .1, .05, 0);
  expect_pixel(classic("texture: 'grey' } vertex_color_replaces_diffuse: true"), blobs, .2, .1, 0);
  expect_pixel(classic("texture: 'blue' } texture_replaces_diffuse: true"), blobs, 0, 0, 1);
  // Ambient light meets the same colour.
  expect_pixel(mesh + "settings { integrator { ambient { r: 1 g: 1 b: 1 } } } " +
                   material("classic { ambient { value { r: .2 g: .2 b: .2 } } "
                            "ambient_times_diffuse: true vertex_color_replaces_diffuse: true }"),
               blobs, .2, .1, 0);
}

TEST(Textured, mappings) {
  // The ramp's x coordinate becomes the colour; the square's middle is at the world's origin.
  const auto scene = [](const std::string& texture) {
    return "textures { name: 't' gradient { positions: 0 positions: 1 colors {} colors { r: 1 g: 1 "
           "b: 1 } } " +
           texture + " } " + material("unlit { color { texture: 't' } }") +
           square(1,
                  "transform { steps { translate { x: .25 } } steps { scale { x: .5 y: 1 z: 1 } } "
                  "}");
  };
  expect_pixel(scene(""), {}, .25, .25, .25);
  expect_pixel(scene("transform { steps { translate { x: .5 } } }"), {}, .75, .75, .75);
  expect_pixel(scene("mapping: WORLD transform { steps { translate { x: .125 } } }"), {}, .125,
               .125, .125);
  expect_pixel(scene("mapping: OBJECT transform { steps { translate { x: 1 } } }"), {}, .5, .5, .5);
  expect_pixel(scene("mapping: OBJECT_NORMAL"), {}, .5, .5, .5);
  expect_pixel(scene("mapping: VIEW_NORMAL"), {}, .5, .5, .5);
}

TEST(Textured, relief_turns_towards_the_light) {
  // Heights grow along x by .75: n = (-.6, 0, .8). From the back the same hill is a valley.
  const std::string ramp =
      "textures { name: 't' gradient { positions: 0 positions: 1 colors {} colors { r: 1 } } "
      "mapping: WORLD transform { steps { translate { x: .5 } } steps { scale { x: .05 } } } } " +
      material("classic { diffuse { value { r: 1 g: 1 b: 1 } } } bump { texture: 't' value: 15 }");
  expect_pixel(ramp + kHeadOn + square(), {}, .8, .8, .8);
  const std::string from_left = "nodes { light { directional { direction { x: .6 z: -.8 } } } } ";
  expect_pixel(ramp + from_left + square(), {}, 1, 1, 1);
  expect_pixel(
      ramp + from_left + square(1, "transform { steps { rotate { axis { y: 1 } angle: 180 } } }"),
      {}, .28, .28, .28);
  BlobStore blobs;
  // (1, .5, .5) points along +u; half of it and half of the normal make 45 degrees.
  const std::string map =
      image(blobs, "n", 1, 1, 3, {255, 128, 255}) +
      material("classic { diffuse { value { r: 1 g: 1 b: 1 } } } normal_map: 'n'");
  const auto pixel = render_text(map + kHeadOn + square(), 1, 1, blobs).values;
  EXPECT_NEAR(pixel[0], std::sqrt(.5), .001);
}

TEST(Textured, far_textures_are_filtered) {
  // A checker of 256 texels over 2 metres, seen in one pixel of 8 metres: its mean, with levels.
  BlobStore blobs;
  std::vector<std::byte> texels;
  for (int side = 256; side >= 1; side /= 2) {
    for (int i = 0; i < side * side; ++i) {
      texels.push_back(static_cast<std::byte>(side < 256 ? 100 : (i + i / side) % 2 ? 200 : 0));
    }
  }
  const std::string digest = blobs.put(std::move(texels)).hex();
  const auto scene = [&](const std::string& filter) {
    return "textures { name: 't' image { texels { digest: '" + digest +
           "' } width: 256 height: 256 channels: 1 bits: 8 levels: 9 encoding: ENCODING_LINEAR " +
           filter + " } } " + material("unlit { color { texture: 't' } }") + square(9);
  };
  EXPECT_NEAR(render_text(scene(""), 1, 1, blobs).values[0], 100. / 255, 1e-6);
  // By the nearest texel alone the pixel is one of the checker's two.
  const float nearest = render_text(scene("filter: NEAREST"), 1, 1, blobs).values[0];
  EXPECT_TRUE(nearest == 0 || std::abs(nearest - 200.f / 255) < 1e-6f) << nearest;
}

// Textures of all kinds, relief, masks and clear ones, in a scene of lights and mirrors.
std::string mixed(BlobStore& blobs) {
  return image(blobs, "photo", 4, 2, 4,
               {9,   80, 200, 255, 90, 8, 20, 0, 250, 99, 2,  90, 7,  77, 177, 200,
                100, 50, 150, 40,  1,  2, 3,  4, 50,  60, 70, 80, 90, 99, 11,  222},
               "") +
         "textures { name: 'marble' noise { kind: MARBLE octaves: 4 frequency: 2 } mapping: OBJECT "
         "} textures { name: 'tiles' checker { odd { texture: 'marble' } } mapping: WORLD } "
         "materials { name: 'floor' classic { diffuse { texture: 'tiles' } reflectivity { value { "
         "r: .2 g: .2 b: .2 } } } bump { texture: 'marble' value: .02 } } " +
         material("classic { diffuse { texture: 'photo' } } normal_map: 'photo'") +
         "materials { name: 'metal' physical { roughness { texture: 'marble' } } } nodes { shape { "
         "materials: 'floor' plane { offset: -1 } } } nodes { light { point { position { x: 2 y: 5 "
         "z: 6 } } intensity: 2 } } nodes { transform { steps { translate { x: 2 } } } shape { "
         "materials: 'metal' sphere {} } } background { solid { r: .5 g: .6 b: .9 } } " +
         square(1, "transform { steps { rotate { axis { y: 1 } angle: 60 } } }");
}

TEST(Textured, pixels_do_not_depend_on_how_the_frame_is_cut_or_traced) {
  BlobStore blobs;
  const v1::Scene scene = parse_scene(mixed(blobs));
  v1::FrameSettings frame = frame_of(29, 19);
  frame.set_samples_per_pixel(2);
  const auto renderer = make_tile_renderer(scene, blobs, frame, 1);
  const auto whole = render_rect(*renderer, {0, 0, 29, 19}, 2).values;
  frame.set_accelerator("bvh");
  const auto other = make_tile_renderer(scene, blobs, frame, 3);
  for (int y = 0; y < 19; ++y) {
    for (int x = 0; x < 29; ++x) {
      const auto one = render_rect(*other, {x, y, x + 1, y + 1}, 2).values;
      for (size_t c = 0; c < 3; ++c) {
        ASSERT_EQ(one[c], whole[static_cast<size_t>(3 * (29 * y + x)) + c]) << x << " " << y;
      }
    }
  }
}

TEST(Textured, counters_tell_what_is_used) {
  BlobStore blobs;
  const auto counters = [&](const std::string& text) {
    return make_tile_renderer(parse_scene(text), blobs, frame_of(1, 1), 1)->build_counters();
  };
  const std::string unused = image(blobs, "t", 2, 2, 1, {1, 2, 3, 4}) +
                             "nodes { shape { materials: 'm' mesh { inline_positions: [-9,-9,0, "
                             "9,-9,0, 0,9,0] inline_triangles: [0,1,2] inline_uvs: [0,0, 0,0, 0,0] "
                             "} } } ";
  CounterMap plain = counters(unused + material(""));
  EXPECT_EQ(plain["textures_total"], 1u);
  EXPECT_EQ(plain["textures_used"], 0u);
  EXPECT_EQ(plain["texture_bytes"], 0u);
  EXPECT_EQ(plain["attributes_dropped"], 1u);
  EXPECT_EQ(plain["mesh_bytes_dropped"], 24u);
  EXPECT_EQ(plain["mesh_bytes"], 48u);
  CounterMap used = counters(unused + material("unlit { color { texture: 't' } }"));
  EXPECT_EQ(used["textures_used"], 1u);
  EXPECT_EQ(used["texture_bytes"], 4u);
  EXPECT_EQ(used["attributes_dropped"], 0u);
  EXPECT_EQ(used["mesh_bytes"], 72u);
}

std::string floats(BlobStore& blobs, const std::string& field, const std::vector<float>& values) {
  std::vector<std::byte> bytes(values.size() * sizeof(float));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  const std::string size = std::to_string(bytes.size());
  return field + " { size: " + size + " digest: '" + blobs.put(std::move(bytes)).hex() + "' } ";
}

TEST(Textured, second_texture_coordinates) {
  BlobStore blobs;
  // By the first coordinates x leads to the right, by the second ones to the left.
  const std::string corners =
                        "inline_positions: [-9,-9,0, 9,-9,0, 0,9,0] inline_triangles: [0,1,2] ",
                    first = "inline_uvs: [0,0, 1,0, .5,.5] ",
                    second = floats(blobs, "second_uvs", {1, 0, 0, 0, 1, 1});
  const auto mesh = [&](const std::string& uvs, const std::string& placed = "") {
    return "nodes { " + placed + " shape { materials: 'm' mesh { " + corners + uvs + "} } } ";
  };
  const auto ramp = [](const std::string& mapping) {
    return "textures { name: 't' gradient { positions: 0 positions: 1 colors {} colors { r: 1 g: 1 "
           "b: 1 } } mapping: " +
           mapping + " } " + material("unlit { color { texture: 't' } }");
  };
  expect_pixel(ramp("UV") + mesh(first + second), blobs, .5, .5, .5);
  expect_pixel(ramp("SECOND_UV") + mesh(first + second), blobs, .75, .75, .75);
  expect_pixel(ramp("SECOND_UV") + mesh(first), blobs, .5, .5, .5);
  expect_pixel(ramp("SECOND_UV") + mesh(second), blobs, .75, .75, .75);

  // Relief leans as its own coordinates do, wherever the mesh is turned.
  const std::string from_left = "nodes { light { directional { direction { x: .6 z: -.8 } } } } ",
                    turned = "transform { steps { rotate { axis { z: 1 } angle: 180 } } }",
                    white = "classic { diffuse { value { r: 1 g: 1 b: 1 } } } ";
  const std::string map =
      image(blobs, "n", 1, 1, 3, {255, 128, 128}, "") + material(white + "normal_map: 'n'");
  const auto mapped = [&](const std::string& mapping) {
    std::string text = map;
    return text.insert(text.find("image {"), "mapping: " + mapping + " ") + from_left;
  };
  const auto shown = [&](const std::string& scene) {
    return render_text(scene, 1, 1, blobs).values[0];
  };
  EXPECT_NEAR(shown(mapped("UV") + mesh(first + second, turned)), .6, .01);
  EXPECT_NEAR(shown(mapped("UV") + mesh(first + second)), 0, .01);
  EXPECT_NEAR(shown(mapped("SECOND_UV") + mesh(first + second)), .6, .01);
  EXPECT_NEAR(shown(mapped("SECOND_UV") + mesh(first + second, turned)), 0, .01);
  EXPECT_NEAR(shown(mapped("SECOND_UV") + mesh(first, turned)), .6, .01);
  const auto bump = [&](const std::string& mapping) {
    return "textures { name: 't' gradient { positions: 0 positions: 1 colors {} colors { r: 1 } } "
           "mapping: " +
           mapping + " } " + material(white + "bump { texture: 't' value: 13.5 }") + from_left;
  };
  EXPECT_NEAR(shown(bump("UV") + mesh(first + second)), 1, .001) << "a slope of .75 to the left";
  EXPECT_NEAR(shown(bump("SECOND_UV") + mesh(first + second)),
              .35 / std::sqrt(1 + .75 * .75 + .375 * .375), .001)
      << "of .75 to the right and .375 down";

  const auto dropped = [&](const std::string& scene) {
    return make_tile_renderer(parse_scene(scene), blobs, frame_of(1, 1), 1)
        ->build_counters()["attributes_dropped"];
  };
  EXPECT_EQ(dropped(ramp("UV") + mesh(first + second)), 1u);
  EXPECT_EQ(dropped(ramp("SECOND_UV") + mesh(first + second)), 0u);
  const std::string tiles =
      "textures { name: 'tiles' checker { odd { texture: 't' } } mapping: UV } ";
  EXPECT_EQ(dropped(tiles + ramp("SECOND_UV") + "nodes { shape { materials: 'k' mesh { " + corners +
                    first + second +
                    "} } } materials { name: 'k' unlit { color { texture: 'tiles' } } }"),
            0u)
      << "a texture of a texture";
}

TEST(Textured, attributes_that_nothing_shows_are_left_out) {
  BlobStore blobs;
  const std::string bare =
      "nodes { shape { materials: 'm' mesh { inline_positions: [-1,-1,0, "
      "1,-1,0, 0,1,0] inline_triangles: [0,1,2] ";
  const std::string normals = "inline_normals: [1,0,1, 0,1,1, -1,0,1] ";
  const auto colors = [&](float alpha) {
    return floats(blobs, "colors", {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, alpha});
  };
  const auto check = [&](const std::string& look, const std::string& attributes, uint64_t dropped) {
    const std::string with = material(look) + kHeadOn + bare + attributes + "} } } ";
    const auto renderer = make_tile_renderer(parse_scene(with), blobs, frame_of(8, 8), 1);
    EXPECT_EQ(renderer->build_counters()["attributes_dropped"], dropped) << with;
    const auto without = render_text(material(look) + kHeadOn + bare + "} } } ", 8, 8).values;
    EXPECT_EQ(render_rect(*renderer, {0, 0, 8, 8}).values == without, dropped > 0) << with;
  };
  check("unlit {}", normals, 1);
  check("classic {}", normals, 0);
  check("unlit { transparency { value: .5 } }", normals, 1);
  check("classic { diffuse { value {} } emission { value { r: 1 } } }", colors(1), 1);
  check("classic { diffuse { value {} } emission { value { r: 1 } } }", colors(0.5f), 0);
  check("classic { diffuse { value {} } vertex_color_replaces_diffuse: true }", colors(1), 0);
  check("classic {}", colors(1), 0);
  check("unlit {}", colors(1), 0);
  check("unlit { color { value {} } }", normals + colors(1), 2);
  const std::string depth = "settings { integrator { kind: 'depth' } } ";
  check("classic {} } " + depth + "materials { name: 'other' classic {}", normals + colors(1), 2);
}

}  // namespace
}  // namespace tessera
