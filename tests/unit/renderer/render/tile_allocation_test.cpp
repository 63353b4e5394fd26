// A tile allocates its pixels and counters; its rays allocate nothing.
#include <gtest/gtest.h>

#include "renderer/render/tile_renderer.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

constexpr char kMixed[] = R"(
  cameras { world_from_camera { steps { look_at { eye { x: 1 y: 2 z: 6 } target { y: .5 } } } } }
  background { gradient { sky { r: .2 g: .4 b: 1 } ground { r: .5 g: .5 b: .4 } } }
  materials { name: 'glass' classic { transparency { value: .9 } refractive_index: 1.5
              reflectivity { value { r: .1 g: .1 b: .1 } } absorption { r: 1 g: .2 b: .1 } } }
  materials { name: 'veil' classic { transparency { value: .5 } transmission: STRAIGHT } }
  nodes { light { directional { direction { x: -1 y: -2 z: -1 } } } }
  nodes { light { point { position { x: 2 y: 3 } } intensity: 8 } }
  nodes { transform { steps { translate { y: 1 } } } shape { materials: 'glass' sphere {} } }
  nodes { shape { materials: 'veil' box { min { x: 1.2 z: -1 } max { x: 1.8 y: 1.5 z: 1 } } } }
  nodes { shape { mesh { inline_positions: [-3, 0, -1, -1, 0, -1, -2, 2, -1]
                         inline_triangles: [0, 1, 2] } } }
  nodes { shape { plane {} } })";

TEST(TileAllocation, DoesNotGrowWithRays) {
  const auto allocations = [](uint32_t samples) {
    v1::FrameSettings frame = frame_of(24, 24);
    frame.set_samples_per_pixel(samples);
    frame.set_accelerator("bvh");
    const auto renderer = make_tile_renderer(parse_scene(kMixed), {}, frame, 1);
    const PixelRect rect{0, 0, 24, 24};
    render_rect(*renderer, rect, samples);  // the thread's scratch space grows
    const size_t before = allocation_count();
    const TilePixels tile = render_rect(*renderer, rect, samples);
    const size_t after = allocation_count();
    EXPECT_GT(tile.counters.at("rays_refraction"), 100 * samples);
    return after - before;
  };
  const size_t few = allocations(2);  // of one sample, a list of squares is made, too
  EXPECT_GT(few, 0u);
  EXPECT_EQ(allocations(64), few);
}

}  // namespace
}  // namespace tessera
