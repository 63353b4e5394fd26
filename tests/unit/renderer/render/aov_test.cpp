#include <gtest/gtest.h>

#include <cmath>

#include "renderer/film/aov.h"
#include "renderer/render/sample_sum.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

// A unit sphere 10 m before a camera that looks along -z, on the left of a plane's edge.
constexpr char kAovBall[] = R"(
  cameras { world_from_camera { steps { translate { z: 10 } } } orthographic { min_x: -2 min_y: -2 max_x: 2 max_y: 2 } }
  background { solid { r: .25 g: .5 b: 1 } }
  materials { name: 'red' classic { diffuse { value { r: .75 g: .25 b: .125 } } } }
  nodes { light { directional { direction { z: -1 } } intensity: 1 } }
  nodes { transform { steps { translate { x: 9 } } } shape { sphere { radius: .1 } } }
  nodes { shape { materials: 'red' sphere {} } })";

v1::FrameSettings frame_with(AovSet aovs, uint32_t samples = 1) {
  v1::FrameSettings frame = frame_of(40, 40);
  frame.set_samples_per_pixel(samples);
  frame.set_aovs(aovs.bits());
  return frame;
}

TilePixels render(const v1::FrameSettings& frame, const char* text = kAovBall) {
  const auto renderer = make_tile_renderer(parse_scene(text), {}, frame, 1);
  return render_rect(*renderer, {0, 0, 40, 40}, frame.samples_per_pixel());
}

/// The numbers of one AOV of one pixel.
std::vector<float> at(const TilePixels& tile, AovSet aovs, Aov aov, int x, int y) {
  const int count = AovSet().with(aov).channels() - kFilmChannels;
  const auto first = tile.values.begin() + int64_t{y * 40 + x} * tile.channels;
  const auto begin = first + aovs.first_channel(aov);
  return {begin, begin + count};
}

TEST(AovSet, channels_are_in_one_order_whoever_asks) {
  const AovSet some = AovSet().with(Aov::samples).with(Aov::depth).with(Aov::albedo);
  EXPECT_EQ(some, AovSet().with(Aov::albedo).with(Aov::depth).with(Aov::samples));
  EXPECT_EQ(some.channel_names(), (std::vector<std::string>{"R", "G", "B", "albedo.R", "albedo.G",
                                                            "albedo.B", "Z", "samples"}));
  EXPECT_EQ(some.first_channel(Aov::depth), 6);
  EXPECT_EQ(some.channels(), 8);
  EXPECT_EQ(AovSet::all().channels(), 27);
  EXPECT_EQ(AovSet().channels(), kFilmChannels);
  EXPECT_FALSE(AovSet::knows(1u << 10));
  EXPECT_TRUE(AovSet::knows((1u << 10) - 1));
}

TEST(Aovs, a_sphere_is_where_it_is) {
  const AovSet all = AovSet::all();
  const TilePixels tile = render(frame_with(all));
  int on_ball = 0;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      // Pixel centres; 10 pixels a metre.
      const double px = (x + 0.5 - 20) / 10, py = (20 - y - 0.5) / 10;
      const double inside = 1 - px * px - py * py;
      const auto albedo = at(tile, all, Aov::albedo, x, y);
      const auto normal = at(tile, all, Aov::normal, x, y);
      const auto position = at(tile, all, Aov::position, x, y);
      const auto depth = at(tile, all, Aov::depth, x, y)[0];
      const auto id = at(tile, all, Aov::id, x, y)[0];
      EXPECT_EQ(at(tile, all, Aov::samples, x, y)[0], 1);
      EXPECT_EQ(at(tile, all, Aov::variance, x, y), (std::vector<float>{0, 0, 0}));
      if (inside <= 0) {
        EXPECT_EQ(id, 0);
        EXPECT_EQ(depth, 0);
        EXPECT_EQ(albedo, (std::vector<float>{0, 0, 0}));
        EXPECT_EQ(normal, (std::vector<float>{0, 0, 0}));
        continue;
      }
      ++on_ball;
      const double pz = std::sqrt(inside);
      EXPECT_EQ(id, 2) << "the second object";
      EXPECT_EQ(albedo, (std::vector<float>{.75f, .25f, .125f}));
      EXPECT_NEAR(depth, 10 - pz, 1e-6);
      for (const auto& found : {normal, position}) {
        EXPECT_NEAR(found[0], px, 1e-6);
        EXPECT_NEAR(found[1], py, 1e-6);
        EXPECT_NEAR(found[2], pz, 1e-6);
      }
    }
  }
  EXPECT_NEAR(on_ball, 100 * M_PI, 6);
}

TEST(Aovs, means_are_of_the_samples_that_light_came_by) {
  // Emitted white before black: light and albedo are both the share of the pixel that is
  // covered.
  constexpr char kFlat[] = R"(
    cameras { world_from_camera { steps { translate { z: 10 } } } orthographic { min_x: -2 min_y: -2 max_x: 2 max_y: 2 } }
    materials { name: 'b' classic { diffuse { value { r: 1 g: 1 b: 1 } } emission { value { r: 1 g: 1 b: 1 } } } }
    nodes { shape { materials: 'b' sphere {} } })";
  const AovSet aovs = AovSet().with(Aov::albedo).with(Aov::variance).with(Aov::samples);
  for (const char* filter : {"box", "gaussian", "mitchell"}) {
    v1::FrameSettings frame = frame_with(aovs, 13);
    frame.set_pixel_filter(filter);
    frame.set_pattern("owen-sobol");
    const TilePixels tile = render(frame, kFlat);
    int edges = 0;
    for (int i = 0; i < 1600; ++i) {
      const float* pixel = &tile.values[static_cast<size_t>(i * tile.channels)];
      EXPECT_EQ(pixel[0], pixel[3]) << filter;
      EXPECT_EQ(pixel[9], 13);
      // Of n samples k are 1 and the others 0.
      if (std::string_view(filter) != "box") continue;
      const double p = pixel[0];
      EXPECT_NEAR(pixel[6], p * (1 - p) / 12, 1e-7);
      edges += p > 0 && p < 1;
    }
    if (std::string_view(filter) == "box") {
      EXPECT_GT(edges, 50);
    }
  }
}

TEST(Aovs, light_and_its_counters_are_as_without) {
  v1::FrameSettings frame = frame_with(AovSet::all(), 4);
  frame.set_pattern("owen-sobol");
  const TilePixels with = render(frame);
  frame.clear_aovs();
  const TilePixels without = render(frame);
  ASSERT_EQ(without.channels, kFilmChannels);
  for (size_t i = 0; i < 1600; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      ASSERT_EQ(with.values[i * static_cast<size_t>(with.channels) + c], without.values[i * 3 + c]);
    }
  }
  CounterMap counters = with.counters;
  EXPECT_GT(counters.at("rays_aov"), 0u);
  counters.erase("rays_aov");
  EXPECT_EQ(counters, without.counters);
}

TEST(Aovs, what_is_of_one_ray_costs_one_ray) {
  const auto rays = [](AovSet aovs) {
    v1::FrameSettings frame = frame_with(aovs, 16);
    frame.set_pattern("owen-sobol");
    return render(frame).counters.at("rays_aov");
  };
  const uint64_t one = rays(AovSet().with(Aov::depth).with(Aov::id).with(Aov::position));
  EXPECT_GT(one, 300u);
  EXPECT_EQ(rays(AovSet().with(Aov::albedo)), 16 * one);
  EXPECT_EQ(rays(AovSet().with(Aov::variance).with(Aov::samples)), 0u);
}

// From left to right: a ball with a bite of another, a box that an object is, and one of two
// triangles, before which one without an area stands. The numbers of nodes are behind them.
constexpr char kOrigins[] = R"(
  cameras { world_from_camera { steps { translate { z: 10 } } } orthographic { min_x: -2 min_y: -2 max_x: 2 max_y: 2 } }
  nodes { hidden: true }                                                                        # 1
  nodes {                                                                                       # 2
    transform { steps { translate { x: -1 } } }
    children {                                                                                  # 3
      shape { csg { operation: DIFFERENCE
        operands { shape { sphere { radius: .5 } } }                                            # 4
        operands { children { transform { steps { translate { z: .5 } } }                       # 5, 6
                              shape { sphere { radius: .25 } } } } } }
      children { transform { steps { translate { z: -9 } } } shape { sphere { radius: .1 } } }  # 7
    } }
  nodes { transform { steps { translate { x: 1 } } } instance_of: 'pair' }                      # 8
  nodes { shape { mesh {                                                                        # 9
    inline_positions: [-.5, -2, 0, .5, -2, 0, .5, -1, 0, -.5, -1, 0]
    inline_triangles: [0, 0, 1, 0, 1, 2, 0, 2, 3] } } }
  objects { name: 'pair' nodes { children { shape { box { min { x: -.5 y: -.5 z: -.5 } max { x: .5 y: .5 z: .5 } } } } } }
)";

TEST(Aovs, an_origin_is_the_way_through_the_nodes_of_the_description) {
  const AovSet aovs = AovSet().with(Aov::origin).with(Aov::primitive).with(Aov::id);
  v1::FrameSettings frame = frame_with(aovs);
  using Numbers = std::vector<float>;
  for (const char* accelerator : {"bvh", "octree", "linear"}) {
    frame.set_accelerator(accelerator);
    const TilePixels tile = render(frame, kOrigins);
    const auto origin = [&](int x, int y) { return at(tile, aovs, Aov::origin, x, y); };
    const auto primitive = [&](int x, int y) { return at(tile, aovs, Aov::primitive, x, y)[0]; };
    EXPECT_EQ(origin(6, 20), (Numbers{4, 3, 2, 0, 0, 0, 0, 0})) << "the ball";
    EXPECT_EQ(primitive(6, 20), 1);
    EXPECT_EQ(origin(10, 20), (Numbers{6, 5, 3, 2, 0, 0, 0, 0})) << "the bite";
    EXPECT_EQ(primitive(10, 20), 2);
    EXPECT_EQ(origin(30, 20), (Numbers{11, 10, 8, 0, 0, 0, 0, 0})) << "through an instance";
    EXPECT_EQ(origin(22, 38), (Numbers{9, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(primitive(22, 38), 2) << "its row in the description";
    EXPECT_EQ(primitive(18, 31), 3);
    EXPECT_EQ(origin(0, 0), Numbers(8)) << "nothing";
    EXPECT_EQ(primitive(0, 0), 0);
  }
}

TEST(Aovs, an_origin_ends_with_the_eighth_node) {
  std::string text = "shape { sphere {} }";
  for (int i = 0; i < 10; ++i) text = "children { " + text + " }";
  text = "cameras { world_from_camera { steps { translate { z: 10 } } } } nodes { " + text + " }";
  const AovSet aovs = AovSet().with(Aov::origin);
  const TilePixels tile = render(frame_with(aovs), text.c_str());
  EXPECT_EQ(at(tile, aovs, Aov::origin, 20, 20), (std::vector<float>{11, 10, 9, 8, 7, 6, 5, 4}));
}

TEST(Aovs, depth_position_and_id_are_those_of_the_first_sample) {
  const AovSet all = AovSet::all();
  v1::FrameSettings frame = frame_with(all, 1);
  frame.set_pattern("owen-sobol");
  const TilePixels one = render(frame);
  frame.set_samples_per_pixel(16);
  const TilePixels many = render(frame);
  int edges = 0;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      for (const Aov aov : {Aov::depth, Aov::position, Aov::id, Aov::origin, Aov::primitive}) {
        ASSERT_EQ(at(one, all, aov, x, y), at(many, all, aov, x, y)) << x << ' ' << y;
      }
      edges += at(one, all, Aov::albedo, x, y) != at(many, all, Aov::albedo, x, y);
    }
  }
  EXPECT_GT(edges, 50) << "their samples differ";
}

TEST(Aovs, pixels_past_everything_are_as_the_renderer_says_of_them) {
  const v1::FrameSettings frame = frame_with(AovSet::all(), 4);
  const auto renderer = make_tile_renderer(parse_scene(kAovBall), {}, frame, 1);
  const auto unseen = renderer->unseen(4);
  ASSERT_TRUE(unseen);
  EXPECT_EQ(render_rect(*renderer, {0, 0, 1, 1}, 4).values, unseen->one_pixel.values);
  EXPECT_EQ(unseen->one_pixel.values.size(), 27u);
}

TEST(SampleSum, variance_is_that_of_a_mean) {
  SampleSum sum(1, true);
  sum.add({{1, 5, 1e8}});
  EXPECT_EQ(sum.variance(), kBlack) << "one sample tells nothing";
  for (const double value : {2.0, 3.0, 4.0}) sum.add({{value, 5, 1e8 + value}});
  // Of 1, 2, 3, 4: 5/3, over 4 samples.
  EXPECT_DOUBLE_EQ(sum.variance().r, 5.0 / 12);
  EXPECT_EQ(sum.variance().g, 0);
  // Of 0, 2, 3, 4: 35/12.
  EXPECT_DOUBLE_EQ(sum.variance().b, 35.0 / 48) << "however far from 0";
  EXPECT_EQ(sum.count(), 4u);
}

}  // namespace
}  // namespace tessera
