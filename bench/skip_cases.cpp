#include <fmt/format.h>

#include "bench/skip.h"
#include "proto/wire/scene_codec.h"
#include "scenes/generate/generate_scene.h"
#include "scenes/mesh/mesh_data.h"

namespace tessera {
namespace {

// Text form of proto/tessera/v1/scene.proto. Sizes are such that a picture takes tenths of a
// second.

LoadedScene scene_of(const std::string& text) {
  SceneWithBlobs read = decode_scene(text, SceneEncoding::text, "bench skip");
  return {std::move(read.scene), std::move(read.blobs)};
}

std::string settings(int width, int height, std::string_view rest = "") {
  return fmt::format("settings {{ width: {} height: {} {} }}\n", width, height, rest);
}

std::string camera(double x, double y, double z, double field_of_view = 40) {
  return fmt::format(
      "cameras {{ world_from_camera {{ steps {{ look_at {{ eye {{ x: {} y: {} z: {} }} }} }} }}"
      " perspective {{ field_of_view: {} }} }}\n",
      x, y, z, field_of_view);
}

std::string sphere(double x, double y, double z, double radius, std::string_view material = "") {
  const std::string named = material.empty() ? "" : fmt::format("materials: '{}' ", material);
  return fmt::format(
      "nodes {{ shape {{ {}sphere {{ center {{ x: {} y: {} z: {} }} radius: {} }} }} }}\n", named,
      x, y, z, radius);
}

std::string lamp(double x, double y, double z, std::string_view rest = "") {
  return fmt::format("nodes {{ light {{ point {{ position {{ x: {} y: {} z: {} }} }} {} }} }}\n", x,
                     y, z, rest);
}

constexpr char kGround[] =
    "materials { name: 'ground' sides: FRONT_ONLY classic { } }\n"
    "nodes { shape { materials: 'ground' plane { offset: -1 } } }\n";
constexpr char kSun[] = "nodes { light { directional { direction { x: -1 y: -2 z: -1 } } } }\n";

/// 6 x 6 x 6 spheres about the origin.
std::string many_spheres(std::string_view material = "") {
  std::string text;
  for (int z = 0; z < 6; ++z)
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 6; ++x)
        text += sphere(-1 + .4 * x, -1 + .4 * y, -1 + .4 * z, .15, material);
  return text;
}

void add_mesh(LoadedScene& out, MeshData mesh, double z) {
  v1::Node& node = *out.scene.add_nodes();
  node.mutable_transform()->add_steps()->mutable_translate()->set_z(z);
  *node.mutable_shape()->mutable_mesh() = store_mesh(std::move(mesh), out.blobs);
}

LoadedScene one_sphere() {
  return scene_of(settings(640, 480) + camera(0, 0, 3) + kSun + sphere(0, 0, 0, 1));
}

LoadedScene meshes_behind() {
  LoadedScene out = scene_of(settings(160, 120) + camera(2, 1.5, 3) + kSun);
  for (int i = 0; i < 4; ++i) add_mesh(out, icosphere(5, false), 100.0 * i);
  return out;
}

/// A triangle that fills the picture, with normals, texture coordinates and colours, of which its
/// material shows none.
LoadedScene bare_triangle() {
  LoadedScene out = scene_of(settings(640, 480) +
                             "cameras { orthographic { } world_from_camera { steps { "
                             "translate { z: 2 } } } }\n"
                             "materials { name: 'bare' unlit { color { value { } } } }\n");
  MeshData mesh;
  mesh.positions = {-9, -9, 0, 9, -9, 0, 0, 18, 0};
  mesh.triangles = {0, 1, 2};
  mesh.normals = {0, 0, 1, 0, 0, 1, 0, 0, 1};
  mesh.uvs = {0, 0, 1, 0, 1, 1};
  mesh.colors.assign(4 * mesh.vertex_count(), 1.F);
  add_mesh(out, std::move(mesh), 0);
  out.scene.mutable_nodes(0)->mutable_shape()->add_materials("bare");
  return out;
}

LoadedScene unused_pictures() {
  LoadedScene out = one_sphere();
  out.scene.mutable_settings()->set_width(160);
  out.scene.mutable_settings()->set_height(120);
  for (int i = 0; i < 20'000; ++i) {
    v1::Texture& texture = *out.scene.add_textures();
    texture.set_name(fmt::format("unused{}", i));
    texture.mutable_noise()->set_octaves(4);
  }
  return out;
}

LoadedScene black_lamps() {
  std::string text = settings(320, 240) + camera(2, 1.5, 3) + kSun + kGround + many_spheres();
  for (int i = 0; i < 32; ++i) text += lamp(.1 * i, 3, 2, "intensity: 0");
  return scene_of(text);
}

LoadedScene room_with_lamps() {
  std::string text = settings(400, 300) + camera(2, 1.5, 3) + kGround + sphere(0, 0, 0, .3);
  for (const char* wall : {"x: 1 } offset: -1", "z: 1 } offset: -1", "x: -1 } offset: -5",
                           "y: -1 } offset: -5", "z: -1 } offset: -5"})
    text +=
        fmt::format("nodes {{ shape {{ materials: 'ground' plane {{ normal {{ {} }} }} }}\n", wall);
  for (int i = 0; i < 8; ++i) text += lamp(-.8 + .5 * i, 3, 2, "intensity: .2");
  return scene_of(text);
}

LoadedScene opaque_spheres() {
  return scene_of(settings(320, 240) + camera(2, 1.5, 3) + kGround + many_spheres() +
                  lamp(3, 3, 3) + lamp(-3, 3, 3) + lamp(0, 4, 0));
}

LoadedScene plain_ball() {
  return scene_of(settings(640, 480) + camera(1, .8, 1.6) + kSun +
                  "nodes { casts_no_shadow: true shape { sphere { radius: 1 } } }\n");
}

LoadedScene small_ball() {
  return scene_of(settings(800, 600, "sampling { samples_per_pixel: 4 }") + camera(0, 0, 12) +
                  kSun + "background { solid { r: .2 g: .4 b: .8 } }\n" + sphere(0, 0, 0, 1));
}

LoadedScene centred_samples() {
  return scene_of(settings(200, 150, "sampling { samples_per_pixel: 16 pattern: CENTER }") +
                  camera(2, 1.5, 3) + kSun + kGround + many_spheres());
}

LoadedScene smooth_walls() {
  return scene_of(settings(96, 72, "sampling { samples_per_pixel: 256 target_error: .01 }") +
                  camera(2, 1.5, 3) + kSun + kGround + sphere(0, 0, 0, 1) +
                  "background { gradient { sky { r: .2 g: .4 b: .8 } } }\n");
}

LoadedScene lamps_all_around() {
  std::string text = settings(320, 240) + camera(2, 1.5, 3) + many_spheres();
  for (int i = 0; i < 8; ++i)
    text += lamp((i & 1) * 8 - 4, (i >> 1 & 1) * 8 - 4, (i >> 2 & 1) * 8 - 4, "intensity: .3");
  return scene_of(text);
}

LoadedScene short_lamps() {
  std::string text = settings(320, 240) + camera(2, 1.5, 3) + kSun + kGround + many_spheres();
  for (int i = 0; i < 3; ++i) text += lamp(-1 + i, 0, 1.2, "radius: .4");
  return scene_of(text);
}

/// A floor under leaning poles, under a roof that all shadow rays end at or would.
LoadedScene poles_under_a_roof() {
  std::string text = settings(320, 240) + camera(0, 1, .5) + kGround +
                     "nodes { shape { rectangle { corner { x: -9 y: 4 z: -9 } edge_u { x: 18 } "
                     "edge_v { z: 18 } } } }\n";
  for (int i = 0; i < 4; ++i) text += lamp(i - 1.5, 6, 0, "intensity: .3");
  for (int z = 0; z < 20; ++z)
    for (int x = 0; x < 20; ++x)
      text += fmt::format(
          "nodes {{ transform {{ steps {{ translate {{ x: {} y: 2.5 z: {} }} }} steps {{ rotate {{ "
          "axis {{ x: {} z: 1 }} angle: .7 }} }} }} shape {{ cylinder {{ radius: .02 height: 3 }} "
          "}} }}\n",
          -3 + .3 * x, -3 + .3 * z, (x * 7 + z * 5) % 16 - 8);
  return scene_of(text);
}

LoadedScene thousand_lamps() {
  std::string text = settings(160, 120) + camera(2, 1.5, 3) + kGround + many_spheres();
  for (int z = 0; z < 32; ++z)
    for (int x = 0; x < 32; ++x)
      text += lamp(-4 + .25 * x, 0, -4 + .25 * z, "radius: 1.2 intensity: .1");
  return scene_of(text);
}

LoadedScene shining_spheres() {
  return scene_of(
      settings(480, 360, "integrator { kind: 'path' } sampling { samples_per_pixel: 2 }") +
      camera(2, 1.5, 3) + "materials { name: 'flat' unlit { } }\n" + sphere(0, 0, 0, 1, "flat") +
      sphere(1, 0, 0, .8, "flat"));
}

LoadedScene half_textured() {
  return scene_of(settings(640, 480) + camera(1, .8, 1.6) +
                  "textures { name: 'tiles' mapping: OBJECT checker { } }\n"
                  "materials { name: 'tiled' classic { diffuse { texture: 'tiles' } } }\n"
                  "materials { name: 'plain' unlit { } }\n" +
                  sphere(0, 0, 0, 1, "plain") + sphere(0, 1.2, 0, .1, "tiled"));
}

LoadedScene glass_balls() {
  std::string text =
      settings(120, 90, "integrator { max_depth: 20 }") + camera(0, .3, 6) + kSun +
      "background { gradient { sky { r: .2 g: .4 b: .8 } ground { r: .5 g: .4 b: .3 } } }\n"
      "materials { name: 'glass' classic { diffuse { value { } } transparency { value: 1 }"
      " refractive_index: 1.5 } }\n";
  for (int i = 0; i < 3; ++i) text += sphere(0, 0, -2.2 * i, 1, "glass");
  return scene_of(text);
}

}  // namespace

const std::vector<SkipCase>& skip_cases() {
  static const std::vector<SkipCase> cases{
      {"small-trees",
       "one sphere in the sun",
       &Skips::small_trees,
       one_sphere,
       {"small_trees_skipped"},
       {"small_trees_skipped"}},
      {"unhit-meshes",
       "four meshes, three out of sight",
       &Skips::unhit_meshes,
       meshes_behind,
       {"mesh_builds_deferred", "-meshes_built_when_hit"},
       {"mesh_builds_deferred"}},
      {"unused-attributes",
       "a black triangle with normals, uvs, colours",
       &Skips::unused_attributes,
       bare_triangle,
       {"attributes_dropped"},
       {"attributes_dropped"}},
      {"unused-textures",
       "20,000 textures that nothing shows",
       &Skips::unused_textures,
       unused_pictures,
       {"textures_skipped"},
       {"textures_total"}},
      {"dark-lights",
       "32 black lamps",
       &Skips::dark_lights,
       black_lamps,
       {"lights_dark"},
       {"lights_used"}},
      {"distant-lights",
       "1024 lamps of short reach",
       &Skips::distant_lights,
       thousand_lamps,
       {"lights_culled"},
       {"lights_culled", "shadow_rays_skipped", "rays_shadow"}},
      {"shadowless-planes",
       "a room of six walls, eight lamps",
       &Skips::shadowless_planes,
       room_with_lamps,
       {"planes_without_shadow"},
       {"instances"}},
      {"opaque-as-clear",
       "216 spheres, three lamps",
       &Skips::opaque_as_clear,
       opaque_spheres,
       {"instances_opaque"},
       {"instances"}},
      {"absent-features",
       "a ball in the sun, without shadows",
       &Skips::absent_features,
       plain_ball,
       {"features_absent"},
       {"features_absent"}},
      {"background-pixels",
       "a small ball",
       &Skips::background_pixels,
       small_ball,
       {"rays_background_skipped"},
       {"samples"}},
      {"equal-samples",
       "16 samples in the pixel's centre",
       &Skips::equal_samples,
       centred_samples,
       {"samples_skipped"},
       {"samples_skipped", "samples"},
       SkipBound::largest,
       1.2e-7},
      {"converged-blocks",
       "a ball, 256 samples or an error of .01",
       &Skips::converged_blocks,
       smooth_walls,
       {"samples_saved"},
       {"samples_saved", "samples"},
       SkipBound::rms,
       .01},
      {"dark-shadow-rays",
       "216 spheres, lamps on all sides",
       &Skips::dark_shadow_rays,
       lamps_all_around,
       {"shadow_rays_skipped"},
       {"shadow_rays_skipped", "rays_shadow"}},
      {"unreached-lights",
       "three lamps of short reach",
       &Skips::unreached_lights,
       short_lamps,
       {"shadow_rays_skipped"},
       {"shadow_rays_skipped", "rays_shadow"}},
      {"last-occluder",
       "a floor under 400 poles and a roof",
       &Skips::last_occluder,
       poles_under_a_roof,
       {"occluders_met_again"},
       {"rays_shadow"}},
      {"unread-numbers",
       "path traced: what only shines",
       &Skips::unread_numbers,
       shining_spheres,
       {"numbers_skipped"},
       {"numbers_skipped"}},
      {"texture-points",
       "a plain ball beside a textured one",
       &Skips::texture_points,
       half_textured,
       {"texture_points_skipped"},
       {"hits"}},
      {"faint-branches",
       "three glass balls, 20 deep",
       &Skips::faint_branches,
       glass_balls,
       {"branches_skipped"},
       {"branches_skipped", "rays_reflection", "rays_refraction"},
       SkipBound::largest,
       1e-6}};
  return cases;
}

}  // namespace tessera
