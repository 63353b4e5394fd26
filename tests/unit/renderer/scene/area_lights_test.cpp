#include "renderer/scene/area_lights.h"

#include <gtest/gtest.h>

#include "renderer/scene/scene_builder.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

AreaLight only_light(const std::string& text) {
  const auto scene = build_scene(parse_scene("settings { integrator { kind: 'path' } } " + text),
                                 {}, frame_of(8, 8), 1);
  EXPECT_EQ(scene->area_lights.size(), 1u);
  return scene->area_lights[0];
}

constexpr char kAreaLamp[] =
    "materials { name: 'off' } "
    "materials { name: 'on' classic { emission { value { r: 1 } } } sides: BACK_MATERIAL "
    "back: 'off' } ";
constexpr char kBoth[] = "materials { name: 'on' classic { emission { value { r: 1 } } } } ";

TEST(AreaLights, FlatOnesAreDarkBehind) {
  for (const std::string shape : {"rectangle { corner { y: 2 } edge_u { z: 1 } edge_v { x: 1 } }",
                                  "disc { center { y: 2 } normal { y: 1 } radius: 1 }"}) {
    const std::string node = "nodes { shape { materials: 'on' " + shape;
    const AreaLight up = only_light(kAreaLamp + node + " } }");
    EXPECT_TRUE(up.is_dark_from({0, 1, 0})) << shape;
    EXPECT_TRUE(up.is_dark_from({50, 1.999, 3})) << shape;
    EXPECT_FALSE(up.is_dark_from({0, 2, 0})) << shape;
    EXPECT_FALSE(up.is_dark_from({0, 2 - 1e-12, 0})) << "too near to tell";
    EXPECT_FALSE(up.is_dark_from({0, 3, 0})) << shape;
    const AreaLight down = only_light(kAreaLamp + node + " flip_normals: true } }");
    EXPECT_FALSE(down.is_dark_from({0, 1, 0})) << shape;
    EXPECT_TRUE(down.is_dark_from({0, 3, 0})) << shape;
    const AreaLight both = only_light(kBoth + node + " } }");
    EXPECT_FALSE(both.is_dark_from({0, 1, 0})) << shape;
    EXPECT_FALSE(both.is_dark_from({0, 3, 0})) << shape;
  }
}

TEST(AreaLights, OthersShineAllRound) {
  const AreaLight ball = only_light(std::string(kAreaLamp) +
                                    "nodes { shape { materials: 'on' sphere { radius: 1 } } }");
  EXPECT_FALSE(ball.is_dark_from({0, 3, 0}));
  EXPECT_FALSE(ball.is_dark_from({0, -3, 0}));
}

}  // namespace
}  // namespace tessera
