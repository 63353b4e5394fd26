// Descriptions damaged at random either build and trace or are refused: they never crash or hang.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/error.h"
#include "tests/error_of.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

constexpr char kSeed[] = R"(
  settings { sampling { samples_per_pixel: 2 pattern: OWEN_SOBOL filter: TENT } integrator { max_depth: 4 } }
  cameras { world_from_camera { steps { look_at { eye { x: 1 y: 2 z: 6 } target { y: .5 } } } }
            headlight { directional { direction { z: -1 } } } near_distance: .1 far_distance: 100 }
  background { rings { sky { r: 1 } sky { b: 1 } sky_angles: 90 } glow: .5 }
  fog { visibility_range: 40 kind: EXPONENTIAL }
  materials { name: 'glass' classic { transparency { value: .9 } refractive_index: 1.5
              reflectivity { value { r: .1 } } absorption { r: 1 } grain: .1 } }
  materials { name: 'b' classic { diffuse_model: HALF_LAMBERT specular { value { g: 1 } } } sides: BACK_MATERIAL back: 'glass' }
  objects { name: 'o' nodes { shape { materials: 'b' box {} } transform { steps { rotate { axis { x: 1 } angle: 20 } } } } }
  nodes { light { spot { position { y: 4 } direction { y: -1 } beam_width: 10 cut_off: 40 }
          attenuation { quadratic: 1 at_most_one: true } radius: 50 scoped: true } }
  nodes { light { point { position { x: 3 y: 3 } } shadow_intensity: .5 shadow_distance: 30 } }
  nodes { instance_of: 'o' keys { time: 0 transform { steps { scale { x: 1 y: 2 z: 1 } } } }
          keys { time: 1 transform { steps { scale { x: 2 y: 2 z: 1 } } } } }
  nodes { shape { materials: 'glass' sphere { radius: .5 } } transform { steps { translate { x: 1 } } } }
  nodes { shape { mesh { inline_positions: [0,0,0, 1,0,0, 0,1,0, 1,1,1] inline_triangles: [0,1,2, 1,3,2] } } }
  nodes { shape { plane {} } })";

std::string complaint(const std::string& text) {
  return error_of([&] { make_tile_renderer(parse_scene(text), {}, frame_of(2, 2), 1); });
}

TEST(Hostile, endless_chains_are_refused_before_they_fill_the_stack) {
  std::string textures = "textures { name: 't0' checker {} }\n";
  std::string materials = "materials { name: 'm0' unlit {} }\n";
  for (int i = 1; i < 50000; ++i) {
    textures += "textures { name: 't" + std::to_string(i) + "' checker { odd { texture: 't" +
                std::to_string(i - 1) + "' } } }\n";
    materials += "materials { name: 'm" + std::to_string(i) +
                 "' unlit {} sides: BACK_MATERIAL back: 'm" + std::to_string(i - 1) + "' }\n";
  }
  EXPECT_NE(complaint(textures + "materials { name: 'a' unlit { color { texture: 't49999' } } }"
                                 "nodes { shape { materials: 'a' sphere {} } }")
                .find("at most 8"),
            std::string::npos);
  EXPECT_NE(
      complaint(materials + "nodes { shape { materials: 'm49999' sphere {} } }").find("at most 64"),
      std::string::npos);
}

TEST(Hostile, damaged_descriptions_are_refused_or_traced) {
  const std::string good = parse_scene(kSeed).SerializeAsString();
  std::mt19937 random(1);
  int traced = 0, refused = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string bytes = good;
    const int changes = 1 + static_cast<int>(random() % 4);
    for (int i = 0; i < changes; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
    v1::Scene scene;
    if (!scene.ParseFromString(bytes)) continue;
    scene.mutable_settings()->mutable_integrator()->set_max_depth(4);
    v1::FrameSettings frame = frame_of(3, 2);
    frame.set_samples_per_pixel(1);
    frame.set_time(0.5);
    try {
      const auto renderer = make_tile_renderer(scene, {}, frame, 1);
      for (const float value : render_rect(*renderer, {0, 0, 3, 2}).values) {
        ASSERT_TRUE(std::isfinite(value));
      }
      ++traced;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(traced, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace tessera
