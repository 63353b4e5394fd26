// Every fault of a description is refused with a scene error that names the place, the value found
// and what was expected.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <string>

#include "base/error.h"
#include "tests/error_of.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

std::string message_of(const std::string& text, const BlobStore& blobs = {},
                       v1::FrameSettings frame = frame_of(1, 1)) {
  return error_of([&] { make_tile_renderer(parse_scene(text), blobs, frame, 2); });
}

void expect_error(const std::string& text, const std::string& part) {
  const std::string message = message_of(text);
  EXPECT_NE(message.find(part), std::string::npos) << text << "\n  -> " << message;
}

void expect_contains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

std::string material(const std::string& fields) {
  return "materials { name: 'm' " + fields + " } nodes { shape { materials: 'm' sphere {} } }";
}
std::string shape(const std::string& fields) {
  return "nodes { name: 'hall' children { shape { " + fields + " } } }";
}
std::string light(const std::string& fields) { return "nodes { light { " + fields + " } }"; }

TEST(Validation, materials) {
  expect_error(material("classic { diffuse { value { r: nan } } }"),
               "material 'm': diffuse is (nan, 0, 0); expected a number >= 0 in each channel");
  expect_error(material("classic { specular { value { g: inf } } }"), "specular is (0, inf, 0)");
  expect_error(material("classic { ambient { value { b: -1 } } }"), "ambient is (0, 0, -1)");
  expect_error(material("classic { emission { value { b: -1 } } }"), "emission is");
  expect_error(material("classic { reflectivity { value { b: -1 } } }"), "reflectivity is");
  expect_error(material("classic { absorption { b: -1 } }"), "absorption is");
  expect_error(material("classic { shininess { value: -1 } }"), "shininess is -1");
  expect_error(material("classic { transparency { value: 1.5 } }"),
               "transparency is 1.5; expected a number in [0, 1]");
  expect_error(material("classic { refractive_index: 0 }"),
               "refractive_index is 0; expected a number > 0");
  expect_error(material("classic { diffuse_exponent: -1 }"), "diffuse_exponent is -1");
  expect_error(material("classic { grain: nan }"), "grain is nan");
  expect_error(material("unlit { transparency { value: 2 } }"), "transparency is 2");
  expect_error(material("alpha: ALPHA_MASK alpha_cutoff: 2"), "alpha_cutoff is 2");
  expect_error(material("sides: BACK_MATERIAL back: 'n'"),
               "material 'm': material 'n' is not defined");
}

TEST(Validation, what_is_not_there_yet_is_named) {
  expect_error("background { sun_and_sky {} }", "sun_and_sky");
  expect_error("settings { sampling { target_error: -.1 } }", "target_error is -0.1");
  expect_error("settings { sampling { target_error: nan } }", "target_error");
}

TEST(Validation, lenses) {
  const auto lens = [](const std::string& fields) {
    return "cameras { name: 'c' lens { " + fields + " } }";
  };
  expect_error(lens("radius_x: -1"), "camera 'c': lens.radius_x is -1");
  expect_error(lens("radius_x: 1"), "lens.focal_distance is 0; expected a number > 0");
  expect_error(lens("radius_y: 1 focal_distance: 1 shape: POLYGON blades: 2"), "lens.blades is 2");
  expect_error(lens("radius_y: 1 focal_distance: 1 samples: 9999999"), "lens.samples is 9999999");
  expect_error("cameras { spherical {} lens { radius_x: 1 focal_distance: 1 } }",
               "lens.focal_surface is PLANE; expected SPHERE");
}

std::string texture(const std::string& fields) {
  return "textures { name: 't' " + fields + " } " +
         material("classic { diffuse { texture: 't' } }");
}

TEST(Validation, textures) {
  expect_error(material("classic { diffuse { texture: 'wod' } }") + "textures { name: 'wood' }",
               "material 'm': diffuse.texture is 'wod'; expected the name of a texture; did you "
               "mean 'wood'?");
  expect_error(material("normal_map: 'x'"), "normal_map is 'x'; expected the name of a texture");
  expect_error(material("bump { texture: 'x' }"), "material 'm': bump.texture is 'x'");
  expect_error(texture("checker { even { texture: 'x' } }"),
               "texture 't': checker.even.texture is 'x'");
  expect_error(texture(""), "texture 't': its kind is missing");
  expect_error("textures {}", "name is empty");
  expect_error("textures { name: 'a' } textures { name: 'a' }", "texture 'a': name is used twice");
  expect_error(texture("checker { odd { texture: 't' } }"),
               "texture 't': checker is made of itself");
  expect_error(texture("checker { even { value { r: -1 } } }"), "checker.even is (-1, 0, 0)");
  expect_error(texture("noise { octaves: 17 }"), "noise.octaves is 17; expected 1 to 16");
  expect_error(texture("noise { frequency: 0 }"), "noise.frequency is 0");
  expect_error(texture("gradient {}"), "the number of gradient.positions is 0");
  expect_error(texture("gradient { positions: .5 positions: .4 colors {} colors {} }"),
               "gradient.positions is 0.4; expected a number in (0.5, 1]");
  expect_error(texture("noise {} transform { steps { rotate { angle: 5 } } }"), "rotate.axis");
  // What nothing uses is not looked at.
  EXPECT_EQ(message_of("textures { name: 'unused' image { width: 99 } }"), "no error");
  std::string nest = "textures { name: 'n0' checker {} } ";
  for (int i = 1; i < 9; ++i) {
    nest += "textures { name: 'n" + std::to_string(i) + "' checker { odd { texture: 'n" +
            std::to_string(i - 1) + "' } } } ";
  }
  expect_error(nest + material("classic { diffuse { texture: 'n8' } }"),
               "checkers in checkers is 9 deep; expected at most 8");
}

TEST(Validation, images) {
  BlobStore blobs;
  const auto image = [&](const std::string& fields, size_t bytes, std::byte fill = {}) {
    const std::string digest = blobs.put(std::vector<std::byte>(bytes, fill)).hex();
    return message_of(texture("image { texels { digest: '" + digest + "' } " + fields + " }"),
                      blobs);
  };
  EXPECT_EQ(image("width: 4 height: 2 channels: 3 bits: 8", 24), "no error");
  EXPECT_EQ(image("width: 5 height: 2 channels: 1 bits: 8 levels: 4", 10 + 3 + 2 + 1), "no error");
  expect_contains(image("width: 4 height: 2 channels: 3 bits: 8", 23),
                  "texture 't': image.texels is 23 bytes; expected 24");
  expect_contains(image("width: 0 height: 2 channels: 3 bits: 8", 24), "image.width is 0");
  expect_contains(image("width: 1 height: 4000000000 channels: 3 bits: 8", 24), "image.height is");
  expect_contains(image("width: 4 height: 2 channels: 5 bits: 8", 40), "image.channels is 5");
  expect_contains(image("width: 4 height: 2 channels: 3 bits: 12", 40), "image.bits is 12");
  expect_contains(image("width: 4 height: 2 channels: 3 bits: 8 levels: 4", 40),
                  "image.levels is 4; expected 1 to 3");
  const auto all_ones = std::byte{0xff};
  expect_contains(image("width: 1 height: 1 channels: 1 bits: 32", 4, all_ones), "infinite or no");
  expect_contains(image("width: 1 height: 1 channels: 1 bits: 16", 2, all_ones), "infinite or no");
  expect_contains(message_of(texture("image { width: 1 height: 1 channels: 1 bits: 8 file: 'x' }")),
                  "image.texels is not read from 'x'");
  expect_error("background { panorama {} }", "background: panorama.texture is ''");
  expect_error("textures { name: 'n' noise {} } background { panorama { texture: 'n' } }",
               "panorama.texture is 'n'; expected a texture with an image");
  expect_error("textures { name: 'n' noise {} } background { cube { top: 'n' } }",
               "background: cube.top is 'n'; expected a texture with an image");
}

TEST(Validation, other_materials) {
  expect_error(material("physical { metallic { value: 2 } }"), "metallic is 2");
  expect_error(material("physical { roughness { value: -1 } }"), "roughness is -1");
  expect_error(material("physical { refractive_index: 0 }"), "refractive_index is 0");
  expect_error(material("physical { transparency { texture: 'x' } }"),
               "transparency is a texture; expected a number; opacity takes a texture");
  expect_error(material("conductor { k { g: -1 } }"), "k is (0, -1, 0)");
  expect_error(material("dielectric { roughness { value: 2 } }"), "roughness is 2");
  expect_error(material("opacity { value: 2 }"), "opacity is 2");
  expect_error(material("normal_scale: inf"), "normal_scale is inf");
  expect_error("nodes { billboard_axis { x: inf } shape { sphere {} } }", "billboard_axis is (inf");
}

TEST(Validation, round_and_flat_shapes) {
  expect_error(shape("cylinder { radius: 0 }"), "cylinder.radius is 0");
  expect_error(shape("cone { height: -1 }"), "cone.height is -1");
  expect_error(shape("torus { minor_radius: nan }"), "torus.minor_radius is nan");
  expect_error(shape("disc { inner_radius: 1 }"), "disc.inner_radius is 1");
  expect_error(shape("half_plane { normal { x: 1 } }"), "half_plane.edge_normal is (0, 0, 0)");
  expect_error(shape("half_plane { normal { x: 1 } edge_normal { x: 2 } }"),
               "node 'hall' > node 1 > shape: ");
  expect_error(shape("rectangle {}"), "node 'hall' > node 1 > shape: ");
  expect_error(shape("polygon { points {} }"), "node 'hall' > node 1 > shape: ");
}

TEST(Validation, shapes) {
  expect_error(shape("sphere { radius: 0 }"),
               "sphere.radius is 0; expected a number in (0, 1e+150]");
  expect_error(shape("sphere { radius: 1e160 }"), "sphere.radius is 1e+160");
  expect_error(shape("sphere { radius: -1 }"), "sphere.radius is -1");
  expect_error(shape("sphere { center { y: nan } }"), "sphere.center is (0, nan, 0)");
  expect_error(shape("plane { normal {} }"), "plane.normal is (0, 0, 0); expected a vector");
  expect_error(shape("plane { offset: inf }"), "plane.offset is inf");
  expect_error(shape("box { min { x: 2 y: -1 z: -1 } }"), "box.min is 2 on axis 0");
  expect_error("nodes { shape { name: 's' } }", "node 1 > shape 's': its kind is missing");
  expect_error(
      shape("materials: 'grean' sphere {}") + "materials { name: 'green' }",
      "node 'hall' > node 1 > shape: material 'grean' is not defined; did you mean 'green'?");
  expect_error("materials { name: 'a' } materials { name: 'a' }",
               "material 'a': name is used twice");
  expect_error("materials {}", "name is empty");
}

TEST(Validation, meshes_in_line) {
  const std::string three = "inline_positions: [0,0,0, 1,0,0, 0,1,0] ";
  const std::string one = "inline_triangles: [0,1,2] ";
  EXPECT_EQ(message_of(shape("mesh { " + three + one + " }")), "no error");
  expect_error(shape("mesh { " + three + " inline_triangles: [0,1,3] }"),
               "triangles[0] is a reference to vertex 3; expected an index below 3");
  expect_error(shape("mesh { " + three + " inline_triangles: [0,1] }"),
               "inline_triangles is 2 numbers; expected a multiple of 3");
  expect_error(shape("mesh { inline_positions: [0,0] }"), "inline_positions is 2 numbers");
  expect_error(shape("mesh { inline_positions: [0,0,nan] }"), "positions[0] is nan");
  expect_error(shape("mesh { " + three + one + "inline_normals: [0,0,1] }"),
               "the number of normals is 1; expected 3, one a vertex");
  expect_error(shape("mesh { " + three + one + "inline_uvs: [0,0] }"), "the number of uvs is 1");
}

v1::BlobRef put(BlobStore& blobs, const void* data, size_t size) {
  std::vector<std::byte> bytes(size);
  if (size > 0) std::memcpy(bytes.data(), data, size);
  v1::BlobRef ref;
  ref.set_digest(blobs.put(std::move(bytes)).hex());
  ref.set_size(size);
  return ref;
}

TEST(Validation, meshes_in_blobs) {
  BlobStore blobs;
  const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const uint32_t triangles[] = {0, 1, 2}, materials[] = {1};
  v1::Scene good;
  v1::TriangleMesh& mesh = *good.add_nodes()->mutable_shape()->mutable_mesh();
  *mesh.mutable_positions() = put(blobs, positions, sizeof positions);
  *mesh.mutable_triangles() = put(blobs, triangles, sizeof triangles);
  const auto check = [&](const v1::Scene& scene) {
    return error_of([&] { make_tile_renderer(scene, blobs, frame_of(1, 1), 1); });
  };
  const auto broken = [&](const std::function<void(v1::TriangleMesh&)>& change) {
    v1::Scene scene = good;
    change(*scene.mutable_nodes(0)->mutable_shape()->mutable_mesh());
    return check(scene);
  };
  EXPECT_EQ(check(good), "no error");
  expect_contains(broken([](auto& m) { m.mutable_positions()->set_digest("zz"); }),
                  "positions is named 'zz'; expected a digest");
  expect_contains(
      broken([](auto& m) { m.mutable_positions()->set_digest(Digest::of("none").hex()); }),
      "positions is missing: blob");
  expect_contains(broken([](auto& m) { m.mutable_positions()->set_size(12); }),
                  "positions is 36 bytes long; expected 12 as the scene says");
  expect_contains(broken([&](auto& m) { *m.mutable_positions() = put(blobs, positions, 35); }),
                  "positions is 35 bytes long; expected a multiple of 12");
  expect_contains(broken([&](auto& m) { *m.mutable_face_materials() = put(blobs, materials, 4); }),
                  "face_materials[0] is 1; expected an index below");
  expect_contains(broken([&](auto& m) { *m.mutable_colors() = put(blobs, positions, 16); }),
                  "the number of colors is 1; expected 3");
  expect_contains(broken([](auto& m) { m.add_inline_positions(1); }),
                  "positions is given both as a blob and in line");
}

TEST(Validation, lights) {
  expect_error("nodes { name: 'n' light { name: 'lamp' } }",
               "node 'n' > light 'lamp': its kind is missing");
  expect_error(light("directional {}"), "directional.direction is (0, 0, 0)");
  expect_error(light("point { position { x: nan } }"), "point.position is (nan, 0, 0)");
  expect_error(light("spot { direction { y: 1 } beam_width: -1 }"), "spot.beam_width is -1");
  expect_error(light("spot { direction { y: 1 } cut_off: 181 }"), "spot.cut_off is 181");
  expect_error(light("point {} color { r: -1 }"), "color is (-1, 0, 0)");
  expect_error(light("point {} intensity: inf"), "intensity is inf");
  expect_error(light("point {} ambient_intensity: -1"), "ambient_intensity is -1");
  expect_error(light("point {} radius: -1"), "radius is -1");
  expect_error(light("point {} shadow_intensity: 2"), "shadow_intensity is 2");
  expect_error(light("point {} shadow_distance: -2"), "shadow_distance is -2");
  expect_error(light("point {} attenuation { quadratic: -1 }"), "attenuation.quadratic is -1");
  expect_error(light("cylinder { direction { y: 1 } beam_radius: -1 }"), "beam_radius is -1");
}

TEST(Validation, cameras) {
  expect_error("cameras { name: 'c' perspective { field_of_view: 180 } }",
               "camera 'c': perspective.field_of_view is 180; expected a number in (0, 180)");
  expect_error("cameras { orthographic { min_x: 2 } }", "orthographic is empty");
  expect_error("cameras { spherical { field_of_view: 0 } }", "field_of_view is 0");
  expect_error("cameras { near_distance: -1 }", "near_distance is -1");
  expect_error("cameras { near_distance: 3 far_distance: 2 }", "far_distance is 2");
  expect_error("cameras { world_from_camera { steps { scale { x: 1 y: 1 } } } }",
               "world_from_camera is flat");
  v1::FrameSettings frame = frame_of(1, 1);
  frame.set_camera("frnt");
  EXPECT_NE(message_of("cameras { name: 'front' }", {}, frame).find("did you mean 'front'"),
            std::string::npos);
  frame.set_camera("2");
  EXPECT_EQ(message_of("cameras { name: 'a' } cameras { name: 'b' }", {}, frame), "no error");
  EXPECT_NE(message_of("cameras { name: 'a' }", {}, frame), "no error");
}

TEST(Validation, settings) {
  const auto with = [](const std::function<void(v1::FrameSettings&)>& change,
                       const std::string& text = "") {
    v1::FrameSettings frame = frame_of(1, 1);
    change(frame);
    return message_of(text, {}, frame);
  };
  EXPECT_NE(with([](auto& f) { f.set_width(70000); }).find("width is 70000"), std::string::npos);
  EXPECT_NE(with([](auto& f) { f.set_width(65536), f.set_height(65536); }).find("65536x65536"),
            std::string::npos);
  EXPECT_NE(with([](auto& f) { f.set_samples_per_pixel(2000000); }).find("2000000"),
            std::string::npos);
  EXPECT_NE(with([](auto& f) { f.set_samples_per_pixel(10); },
                 "settings { sampling { pattern: CORNER_GRID } }")
                .find("a square number"),
            std::string::npos);
  EXPECT_NE(with([](auto& f) { f.set_accelerator("bhv"); }).find("expected one of bvh"),
            std::string::npos);
  expect_error("settings { integrator { max_depth: 10001 } }", "max_depth is 10001");
  expect_error("settings { integrator { ambient { r: nan } } }", "integrator.ambient");
  expect_error("settings { sampling { filter_radius: 0 } }", "filter_radius is 0");
  expect_error("settings { sampling { filter: 77 } }", "one of box, tent, gaussian");
  expect_error("settings { sampling { pattern: -1 } }", "one of center, owen-sobol");
  expect_error("settings { sampling { min_samples: 2000000 } }", "min_samples is 2000000");
  EXPECT_NE(with([](auto& f) { f.set_pixel_filter("gausian"); }).find("did you mean 'gaussian'"),
            std::string::npos);
  EXPECT_NE(with([](auto& f) { f.set_pattern("blue"); }).find("pattern is 'blue'"),
            std::string::npos);
  expect_error("includes { file: 'x' }", "includes other files");
}

TEST(Validation, backgrounds_and_fog) {
  expect_error("background { solid { r: nan } }", "background: solid is (nan, 0, 0)");
  expect_error("background { rings { sky { r: 1 } sky_angles: 3 } }",
               "the number of sky angles is 1; expected one fewer");
  expect_error("background { rings { sky {} sky {} sky {} sky_angles: 5 sky_angles: 4 } }",
               "sky_angles is 4; expected a number in (5, 180]");
  expect_error("background { rings { ground {} ground {} ground_angles: 91 } }",
               "ground_angles is 91");
  expect_error("background { glow: -1 }", "glow is -1");
  expect_error("background { orientation { steps { scale {} } } }", "orientation is flat");
  expect_error("fog { visibility_range: -1 }", "fog: visibility_range is -1");
}

TEST(Validation, transforms) {
  const auto node = [](const std::string& step) {
    return "nodes { transform { steps { " + step + " } } shape { sphere {} } }";
  };
  expect_error(node("translate { x: inf }"), "node 1: translate is (inf, 0, 0)");
  expect_error(node("rotate { angle: 5 }"), "rotate.axis is (0, 0, 0)");
  expect_error(node("matrix { rows: 1 }"), "matrix.rows is 1 numbers; expected 12 numbers");
  expect_error(node("look_at {}"), "look_at.target is the eye itself");
  expect_error(node(""), "a transform step is empty");
  expect_error(node("scale { x: 1e300 y: 1 z: 1 } } steps { scale { x: 1e300 y: 1 z: 1 }"),
               "transform is too large");
  expect_error("nodes { shape { sphere {} } keys { time: 2 } keys { time: 2 } }",
               "keys.time is 2 after 2");
  expect_error(
      "nodes { shape { sphere {} } keys { time: -1 transform { steps { translate {} } } } "
      "keys { time: 2 } }",
      "the same kinds of steps");
  // Before the first frame, whose time is 0.
  expect_error(
      "nodes { name: 'n' shape { sphere {} } keys { transform { steps { translate {} } } } "
      "keys { time: 5 transform { steps { rotate { axis { y: 1 } } } } } }",
      "node 'n': keys is of different steps at 0 s and 5 s; expected the same kinds of steps");
  expect_error(
      "cameras { keys { transform { steps { look_at { target { z: -1 } } } } } "
      "keys { time: 5 transform { steps { look_at { } } } } }",
      "look_at.target is the eye itself");
}

TEST(Validation, the_graph) {
  expect_error(
      "objects { name: 'house' } nodes { name: 'n' instance_of: 'hose' }",
      "node 'n': instance_of names object 'hose', which is not defined; did you mean 'house'?");
  expect_error(
      "objects { name: 'a' nodes { instance_of: 'b' } } "
      "objects { name: 'b' nodes { instance_of: 'a' } } nodes { instance_of: 'a' }",
      "instance_of is 'a', which it is itself a part of");
  expect_error("objects { name: 'a' } objects { name: 'a' }", "object 'a': name is used twice");
  // Ten instances of ten instances of ... : 10^9 spheres.
  std::string bomb = "objects { name: 'o0' nodes { shape { sphere {} } } }";
  for (int level = 1; level <= 9; ++level) {
    bomb += "objects { name: 'o" + std::to_string(level) + "' ";
    for (int i = 0; i < 10; ++i)
      bomb += "nodes { instance_of: 'o" + std::to_string(level - 1) + "' } ";
    bomb += "} ";
  }
  // Found before it unfolds, and so without the way to the one too many.
  expect_error(bomb + "nodes { name: 'n' instance_of: 'o9' }",
               "node 'n': the scene is more than 4194304 instances; expected fewer");
  std::string empty = bomb;
  const std::string sphere = "nodes { shape { sphere {} } }";
  empty.replace(empty.find(sphere), sphere.size(), "nodes { } nodes { }");
  expect_error(empty + "nodes { name: 'n' instance_of: 'o9' }",
               "node 'n': the scene is more than 16777216 nodes once unfolded; expected fewer");
}

TEST(Validation, nesting_has_a_limit) {
  v1::Scene scene;
  v1::Object* object = nullptr;
  for (int i = 0; i < 1000; ++i) {
    object = scene.add_objects();
    object->set_name("o" + std::to_string(i));
    object->add_nodes()->set_instance_of("o" + std::to_string(i + 1));
  }
  scene.add_objects()->set_name("o1000");
  scene.add_nodes()->set_instance_of("o0");
  try {
    make_tile_renderer(scene, {}, frame_of(1, 1), 1);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::bad_scene);
    EXPECT_NE(std::string(error.what()).find("nesting is deeper than"), std::string::npos);
  }
}

}  // namespace
}  // namespace tessera
