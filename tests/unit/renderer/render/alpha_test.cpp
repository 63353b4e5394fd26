#include <gtest/gtest.h>

#include <string>

#include "renderer/film/aov.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

constexpr int kAlphaSide = 24;
constexpr float kAlphaSolid[] = {.25f, .5f, 1};

// Seen along -z: a ball with another of glass, one that is half there and one that is cut out by
// alpha before it.
std::string scene_before(const std::string& background) {
  return R"(
    cameras { world_from_camera { steps { translate { z: 10 } } } orthographic { min_x: -2 min_y: -2 max_x: 2 max_y: 2 } }
    background { )" +
         background + R"( }
    materials { name: 'mirror' classic { diffuse { value { r: .75 g: .25 b: .125 } } reflectivity { value { r: .5 g: .5 b: .5 } } } }
    materials { name: 'half' classic { diffuse { value { g: 1 } } transparency { value: .5 } transmission: STRAIGHT } }
    materials { name: 'glass' classic { transparency { value: .9 } refractive_index: 1.5 } }
    nodes { light { directional { direction { z: -1 } } intensity: 1 } }
    nodes { shape { materials: 'mirror' sphere { center { x: -.8 y: .3 } } } }
    nodes { shape { materials: 'half' sphere { center { x: .6 z: 1 } } } }
    nodes { shape { materials: 'glass' sphere { center { x: -1.2 y: -1.2 } radius: .5 } } })";
}
const std::string kBeforeSolid = scene_before("solid { r: .25 g: .5 b: 1 }");

struct AlphaCase {
  const char* integrator;
  const char* filter;
  double target_error;
};
std::ostream& operator<<(std::ostream& out, const AlphaCase& c) {
  return out << c.integrator << ' ' << c.filter << ' ' << c.target_error;
}

v1::FrameSettings frame_of(const AlphaCase& how, AovSet aovs) {
  v1::FrameSettings frame = tessera::frame_of(kAlphaSide, kAlphaSide);
  frame.set_samples_per_pixel(32);
  frame.set_pattern("owen-sobol");
  frame.set_integrator(how.integrator);
  frame.set_pixel_filter(how.filter);
  frame.set_target_error(how.target_error);
  frame.set_min_samples(how.target_error > 0 ? 8 : 0);
  frame.set_aovs(aovs.bits());
  return frame;
}

TilePixels render(const std::string& scene, const v1::FrameSettings& frame) {
  const auto renderer = make_tile_renderer(parse_scene(scene), {}, frame, 1);
  return render_rect(*renderer, {0, 0, kAlphaSide, kAlphaSide}, frame.samples_per_pixel());
}

const AovSet kAlpha = AovSet().with(Aov::alpha);

const float* alpha_pixel(const TilePixels& tile, int x, int y) {
  return &tile.values[static_cast<size_t>((y * kAlphaSide + x) * tile.channels)];
}

class Alpha : public testing::TestWithParam<AlphaCase> {};

TEST_P(Alpha, over_the_background_it_is_the_picture_with_that) {
  const TilePixels with = render(kBeforeSolid, frame_of(GetParam(), {}));
  const TilePixels without = render(kBeforeSolid, frame_of(GetParam(), kAlpha));
  ASSERT_EQ(without.channels, 4);
  int edges = 0;
  for (int y = 0; y < kAlphaSide; ++y) {
    for (int x = 0; x < kAlphaSide; ++x) {
      const float *a = alpha_pixel(with, x, y), *b = alpha_pixel(without, x, y);
      const float alpha = b[3];
      edges += alpha > 0 && alpha < 1;
      for (size_t c = 0; c < 3; ++c) {
        ASSERT_NEAR(a[c], b[c] + (1 - alpha) * kAlphaSolid[c], 1e-6) << x << ' ' << y;
        if (alpha == 1) {
          ASSERT_EQ(a[c], b[c]) << "the same bits where nothing is seen of it";
        }
        if (alpha == 0) {
          ASSERT_EQ(b[c], 0);
        }
      }
    }
  }
  EXPECT_GT(edges, 40);
}

TEST_P(Alpha, is_a_share) {
  const TilePixels tile = render(kBeforeSolid, frame_of(GetParam(), kAlpha));
  EXPECT_EQ(alpha_pixel(tile, 23, 0)[3], 0) << "beside everything";
  EXPECT_EQ(alpha_pixel(tile, 7, 9)[3], 1) << "a mirror shows what it shows";
  EXPECT_EQ(alpha_pixel(tile, 5, 19)[3], 1) << "so does glass";
  // Both faces of the ball of half transparency: three quarters are there.
  const bool by_chance = std::string(GetParam().integrator) == "path";
  EXPECT_NEAR(alpha_pixel(tile, 17, 12)[3], .75, by_chance ? .3 : 1e-6);
}

INSTANTIATE_TEST_SUITE_P(
    Pictures, Alpha,
    testing::Values(AlphaCase{"whitted", "box", 0}, AlphaCase{"path", "box", 0},
                    AlphaCase{"whitted", "mitchell", 0}, AlphaCase{"path", "gaussian", 0},
                    AlphaCase{"whitted", "box", .02}, AlphaCase{"path", "tent", .05}));

TEST(AlphaOfPixels, counts_no_ray_where_nothing_is) {
  // A gradient is another colour in each pixel, but left out they are all alike.
  const v1::FrameSettings frame = frame_of(AlphaCase{"whitted", "box", 0}, kAlpha);
  const v1::Scene scene = parse_scene(scene_before("gradient { sky { b: 1 } ground { r: 1 } }"));
  const auto renderer = make_tile_renderer(scene, {}, frame, 1);
  const auto unseen = renderer->unseen(32);
  ASSERT_TRUE(unseen);
  EXPECT_EQ(unseen->one_pixel.values, (std::vector<float>{0, 0, 0, 0}));
  const TilePixels corner = render_rect(*renderer, {23, 0, 24, 1}, 32);
  EXPECT_EQ(corner.values, unseen->one_pixel.values);
  EXPECT_EQ(corner.counters.at("rays_aov"), 0u);
}

TEST(AlphaOfPixels, is_one_through_a_lens_inside_a_surface_and_a_share_at_its_edge) {
  v1::Scene scene = parse_scene(R"(
    cameras { world_from_camera { steps { translate { z: 10 } } }
              perspective { field_of_view: 20 }
              lens { radius_x: .5 radius_y: .5 focal_distance: 4 samples: 4 } }
    background { solid { r: .25 g: .5 b: 1 } }
    nodes { shape { sphere {} } })");
  for (const char* integrator : {"whitted", "path"}) {
    v1::FrameSettings frame = frame_of(AlphaCase{integrator, "box", 0}, {});
    frame.set_samples_per_pixel(4);
    const auto picture = [&](AovSet aovs) {
      frame.set_aovs(aovs.bits());
      return render_rect(*make_tile_renderer(scene, {}, frame, 1), {0, 0, kAlphaSide, kAlphaSide},
                         4);
    };
    const TilePixels with = picture({}), without = picture(kAlpha);
    EXPECT_EQ(alpha_pixel(without, 12, 12)[3], 1);
    for (int i = 0; i < kAlphaSide * kAlphaSide; ++i) {
      const float *a = alpha_pixel(with, i, 0), *b = alpha_pixel(without, i, 0);
      for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(a[c], b[c] + (1 - b[3]) * kAlphaSolid[c], 1e-6);
    }
  }
}

}  // namespace
}  // namespace tessera
