#include "renderer/render/tile_renderer.h"

#include <gtest/gtest.h>

#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

// X3D's default camera looks at a sphere of its default material, with a headlight.
constexpr char kSphere[] = R"(
  cameras { world_from_camera { steps { translate { z: 10 } } }
            headlight { directional { direction { z: -1 } } } }
  background { solid { r: .25 g: .5 b: 1 } }
  nodes { shape { sphere {} } })";

TEST(TileRenderer, shows_a_lit_sphere_before_its_background) {
  const TilePixels tile = render_text(kSphere, 33, 33);
  const size_t middle = 3 * (16 * 33 + 16);
  EXPECT_FLOAT_EQ(tile.values[middle], 0.8f);
  EXPECT_FLOAT_EQ(tile.values[middle + 2], 0.8f);
  EXPECT_EQ(tile.values[0], 0.25f);
  EXPECT_EQ(tile.values[1], 0.5f);
  EXPECT_EQ(tile.values[2], 1.0f);
  EXPECT_EQ(tile.counters.at("rays_primary"), 33u * 33u);
  EXPECT_EQ(tile.counters.at("nan_samples"), 0u);
}

}  // namespace
}  // namespace tessera
