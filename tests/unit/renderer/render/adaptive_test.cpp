#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/film/block.h"
#include "renderer/render/sample_sum.h"
#include "renderer/sampler/sampler.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

// A glass ball, a mirror and a light's shadow on a ground before the sky.
constexpr char kScene[] = R"(
  cameras { world_from_camera { steps { look_at { eye { x: 1 y: 2 z: 6 } target { y: .5 } } } } }
  background { gradient { sky { r: .2 g: .4 b: 1 } ground { r: .5 g: .5 b: .4 } } }
  materials { name: 'glass' classic { transparency { value: .9 } refractive_index: 1.5 } }
  materials { name: 'mirror' classic { reflectivity { value { r: .8 g: .7 b: .6 } } } }
  nodes { light { point { position { x: 2 y: 3 } } intensity: 3 } }
  nodes { transform { steps { translate { y: 1 } } } shape { materials: 'glass' sphere {} } }
  nodes { shape { materials: 'mirror' box { min { x: -3 z: -2 } max { x: -1.5 y: 2 z: -1 } } } })";

// The same before a background of one colour.
constexpr char kBall[] = R"(
  cameras { world_from_camera { steps { translate { z: 10 } } }
            headlight { directional { direction { z: -1 } } } }
  background { solid { r: .25 g: .5 b: 1 } }
  nodes { shape { sphere {} } })";

// A checked ground to the horizon, in daylight.
constexpr char kTiles[] = R"(
  cameras { world_from_camera { steps { look_at { eye { y: 1 } target { x: .3 y: .8 z: -1 } } } } }
  background { gradient { sky { r: .2 g: .4 b: 1 } ground { r: .5 g: .5 b: .4 } } }
  materials { name: 'floor' classic { diffuse { texture: 'tiles' } } }
  textures { name: 'tiles' checker {} mapping: WORLD }
  nodes { shape { materials: 'floor' plane {} } }
  nodes { light { directional { direction { y: -1 } } } })";

v1::FrameSettings adaptive_frame(int width, int height, uint32_t most, double error) {
  v1::FrameSettings frame = frame_of(width, height);
  frame.set_samples_per_pixel(most);
  frame.set_target_error(error);
  return frame;
}

/// The pixels of `part` in a picture of the frame.
std::vector<float> part_of(const TilePixels& whole, const PixelRect& part) {
  std::vector<float> values;
  for (int y = part.y0; y < part.y1; ++y) {
    const auto row = whole.values.begin() + 3 * (int64_t{y} * whole.rect.width() + part.x0);
    values.insert(values.end(), row, row + 3 * part.width());
  }
  return values;
}

TEST(Adaptive, pixels_and_counters_do_not_depend_on_how_the_frame_is_cut) {
  constexpr int kWidth = 70, kHeight = 45;
  constexpr uint32_t kMost = 100;
  for (const char* text : {kScene, kBall, kTiles}) {
    const auto renderer =
        make_tile_renderer(parse_scene(text), {}, adaptive_frame(kWidth, kHeight, kMost, 0.01), 1);
    const TilePixels whole = render_rect(*renderer, {0, 0, kWidth, kHeight}, kMost);
    EXPECT_EQ(whole.counters.at("samples_beside_the_tile"), 0u);
    EXPECT_GT(whole.counters.at("samples_saved"), 0u);
    EXPECT_GT(whole.counters.at("blocks_stopped_early"), 8u);
    for (const int side : {5, 8, 16, 48, 64}) {
      CounterMap sums;
      for (int y = 0; y < kHeight; y += side) {
        for (int x = 0; x < kWidth; x += side) {
          const PixelRect rect{x, y, std::min(x + side, kWidth), std::min(y + side, kHeight)};
          const TilePixels tile = render_rect(*renderer, rect, kMost);
          ASSERT_EQ(tile.values, part_of(whole, rect)) << side << " " << x << " " << y;
          for (const auto& [name, value] : tile.counters) sums[name] += value;
        }
      }
      for (const auto& [name, value] : whole.counters) {
        if (name == "tiles_background") continue;
        EXPECT_EQ(sums[name] == value, name != "samples_beside_the_tile" || side % kBlockSide == 0)
            << side << " " << name;
      }
      EXPECT_EQ(whole.counters.at("samples") + whole.counters.at("samples_saved"),
                uint64_t{kMost} * kWidth * kHeight);
    }
    const PixelRect crop{13, 9, 50, 30};
    EXPECT_EQ(render_rect(*renderer, crop, kMost).values, part_of(whole, crop));
  }
}

// A coordinator fills whole tiles with what looks past everything; other tiles trace their blocks.
TEST(Adaptive, pixels_past_everything_are_those_that_a_coordinator_fills_in) {
  constexpr uint32_t kMost = 100;
  const auto renderer =
      make_tile_renderer(parse_scene(kBall), {}, adaptive_frame(64, 64, kMost, 0.01), 1);
  const auto unseen = renderer->unseen(kMost);
  ASSERT_TRUE(unseen);
  ASSERT_NE(unseen->seen.x0 % kBlockSide, 0) << "the edge is to cut a block";
  const int x = unseen->seen.x0 - 1, y = 32;
  const TilePixels pixel = render_rect(*renderer, {x, y, x + 1, y + 1}, kMost);
  EXPECT_EQ(pixel.values, unseen->one_pixel.values);
  for (const auto& [name, value] : unseen->one_pixel.counters) {
    EXPECT_EQ(pixel.counters.at(name), value) << name;
  }
}

uint64_t samples_of(const char* text, uint32_t most, double error, uint32_t least = 0) {
  v1::FrameSettings frame = adaptive_frame(16, 16, most, error);
  frame.set_min_samples(least);
  const auto renderer = make_tile_renderer(parse_scene(text), {}, frame, 1);
  return render_rect(*renderer, {0, 0, 16, 16}, most).counters.at("samples") / 256;
}

TEST(Adaptive, blocks_of_one_colour_are_not_believed_at_once) {
  constexpr char kFlat[] = "background { gradient { sky { r: .5 } ground { r: .5 } } }";
  EXPECT_EQ(samples_of(kFlat, 1000, 0.5), 16u);
  EXPECT_EQ(samples_of(kFlat, 1000, 0.5, 100), 128u);
  // A feature of display white that 16 n samples miss with chance 1/e errs by 1 / (4 n); of 64 such
  // blocks one is to have it. It may err by .001 * sqrt(n / 1000).
  EXPECT_EQ(samples_of(kFlat, 1000, 0.001), 128u);
  EXPECT_EQ(samples_of(kFlat, 1000, 0.00003), 1000u);
  EXPECT_EQ(samples_of(kFlat, 100, 0.00003), 100u);
  EXPECT_EQ(samples_of(kFlat, 3, 0.5), 3u);
  EXPECT_EQ(samples_of(kFlat, 1, 0.5), 1u);
}

TEST(Adaptive, without_stopping_it_has_the_bits_of_all_samples) {
  for (const uint32_t samples : {1u, 2u, 37u}) {
    const PixelRect rect{0, 0, 20, 12};
    v1::FrameSettings frame = adaptive_frame(20, 12, samples, 1e-9);
    const auto with = make_tile_renderer(parse_scene(kScene), {}, frame, 1);
    frame.set_target_error(0);
    const auto without = make_tile_renderer(parse_scene(kScene), {}, frame, 1);
    EXPECT_EQ(render_rect(*with, rect, samples).values,
              render_rect(*without, rect, samples).values);
  }
}

// Where all blocks stop at once, 16 samples are those that the first 16 of 32 everywhere are: they
// are filtered for twice their number. Those behind them are filtered for more.
TEST(Adaptive, textures_are_filtered_for_the_samples_that_blocks_have) {
  const PixelRect rect{0, 0, 24, 16};
  const v1::Scene scene = parse_scene(kTiles);
  const auto first_of = [&](uint32_t samples, uint32_t most, double error) {
    const auto renderer = make_tile_renderer(scene, {}, adaptive_frame(24, 16, most, error), 1);
    return render_rect(*renderer, rect, samples).values;
  };
  EXPECT_EQ(first_of(1024, 1024, 1000), first_of(16, 32, 0));
  EXPECT_NE(first_of(1024, 1024, 1000), first_of(16, 16, 0));
  EXPECT_NE(first_of(32, 1024, 1e-9), first_of(32, 32, 0));
}

// The picture's error against one of 4096 samples keeps what was asked for.
TEST(Adaptive, keeps_its_target) {
  const PixelRect rect{0, 0, 40, 32};
  const v1::Scene scene = parse_scene(kScene);
  v1::FrameSettings frame = adaptive_frame(40, 32, 2048, 0);
  frame.set_seed(99);
  const auto truth = render_rect(*make_tile_renderer(scene, {}, frame, 1), rect, 2048).values;
  double last = 1;
  for (const double target : {0.02, 0.005}) {
    const auto tile = render_rect(
        *make_tile_renderer(scene, {}, adaptive_frame(40, 32, 2048, target), 1), rect, 2048);
    double squares = 0;
    for (size_t i = 0; i < truth.size(); ++i) {
      squares += (tile.values[i] - truth[i]) * (tile.values[i] - truth[i]);
    }
    const double error = std::sqrt(squares / static_cast<double>(truth.size()));
    EXPECT_LT(error, target);
    EXPECT_LT(error, last);
    EXPECT_LT(tile.counters.at("samples"), 500u * 40 * 32);
    last = error;
  }
}

// A closed box under a bright sky, which light enters by a slit, and a ball in it.
constexpr char kSlit[] = R"(
  settings { integrator { kind: 'path' max_depth: 16 } }
  cameras { world_from_camera { steps { look_at { eye { x: -1.6 y: 1.3 z: 1.6 } target { x: .3 y: .7 z: -.5 } } } }
            perspective { field_of_view: 60 } }
  background { solid { r: 40 g: 40 b: 40 } }
  materials { name: 'm' classic { diffuse { value { r: .75 g: .75 b: .75 } } } }
  nodes { shape { materials: 'm' csg { operation: DIFFERENCE
    operands { shape { box { min { x: -2.1 y: -.1 z: -2.1 } max { x: 2.1 y: 2.6 z: 2.1 } } } }
    operands { shape { box { min { x: -2 y: 0 z: -2 } max { x: 2 y: 2.5 z: 2 } } } }
    operands { shape { box { min { x: 1.9 y: 1.5 z: -.06 } max { x: 2.3 y: 2.2 z: .06 } } } } } } }
  nodes { shape { materials: 'm' sphere { center { x: .3 y: .5 z: -.5 } radius: .5 } } })";

/// Bright balls that each cover a hundredth of a pixel, every other one behind a wall, and a large
/// one.
std::string specks() {
  std::string text = R"(
    settings { integrator { kind: 'path' } }
    cameras { world_from_camera { steps { translate { z: 10 } } } orthographic { min_x: -16 min_y: -12 max_x: 16 max_y: 12 } }
    materials { name: 'bright' classic { diffuse { value {} } emission { value { r: 300 g: 300 b: 300 } } } }
    materials { name: 'dim' classic { diffuse { value {} } emission { value { r: .5 g: .5 b: .5 } } } }
    materials { name: 'wall' classic { diffuse { value {} } } }
    nodes { shape { materials: 'wall' box { min { x: -16 y: -12 } max { x: 0 y: 12 z: 1 } } } }
    nodes { shape { materials: 'dim' sphere { center { x: 8 y: 2 } radius: 3 } } })";
  for (int i = 0; i < 24; ++i) {
    text += fmt::format(
        "nodes {{ shape {{ materials: 'bright' sphere {{ center {{ x: {} y: {} z: -4 }} radius: "
        ".056 }} }} }}",
        i % 2 == 0 ? 1 + i / 2 : -1 - i / 2, -11.3 + .7 * i);
  }
  return text;
}

TEST(Adaptive, loses_no_light_that_few_samples_meet) {
  constexpr int kWidth = 32, kHeight = 24;
  constexpr uint32_t kMost = 256;
  struct Case {
    std::string text;
    double target;
  };
  for (const Case& each : {Case{kSlit, 0.2}, Case{specks(), 0.1}}) {
    const auto render = [&](double target) {
      const auto frame = adaptive_frame(kWidth, kHeight, kMost, target);
      return render_rect(*make_tile_renderer(parse_scene(each.text), {}, frame, 1),
                         {0, 0, kWidth, kHeight}, kMost);
    };
    const auto mean = [](const TilePixels& tile) {
      return std::accumulate(tile.values.begin(), tile.values.end(), 0.0) /
             static_cast<double>(tile.values.size());
    };
    const double all = mean(render(0));
    const TilePixels tile = render(each.target);
    EXPECT_NEAR(mean(tile), all, 0.03 * all);
    EXPECT_GT(tile.counters.at("samples_saved"), kWidth * kHeight * kMost / 16) << "it stops";
  }
}

// 1.96 times what the error view shows covers what the picture errs by, and not by showing too much
// as the spread of the samples alone would. Also where the last samples are behind the last look.
TEST(Adaptive, shows_the_error_that_its_picture_has) {
  const PixelRect rect{0, 0, 40, 32};
  const std::string view = std::string("settings { integrator { kind: 'error' } }") + kScene;
  const auto values = [&](const std::string& text, uint32_t most, double target, uint64_t seed) {
    v1::FrameSettings frame = adaptive_frame(40, 32, most, target);
    frame.set_seed(seed);
    const auto renderer = make_tile_renderer(parse_scene(text), {}, frame, 1);
    // By tiles that cut blocks.
    const auto left = render_rect(*renderer, {0, 0, 18, 32}, most).values;
    const auto whole = render_rect(*renderer, rect, most);
    EXPECT_EQ(left, part_of(whole, {0, 0, 18, 32}));
    return whole.values;
  };
  const auto truth = values(kScene, 2048, 0, 99);
  const auto mean_square = [](const std::vector<float>& of, const std::vector<float>& less) {
    double squares = 0;
    for (size_t i = 0; i < of.size(); ++i) squares += (of[i] - less[i]) * (of[i] - less[i]);
    return std::sqrt(squares / static_cast<double>(of.size()));
  };
  const std::vector<float> none(truth.size());
  for (const uint32_t most : {16u, 100u, 1000u}) {
    const auto light = values(kScene, most, 0.01, 0), error = values(view, most, 0.01, 0);
    const double claimed = mean_square(error, none), real = mean_square(light, truth);
    EXPECT_GT(claimed, 0.8 * real) << most;
    EXPECT_LT(claimed, 1.5 * real) << most;
    size_t covered = 0;
    for (size_t i = 0; i < error.size(); ++i) {
      if (std::abs(light[i] - truth[i]) <= 1.96 * error[i]) ++covered;
    }
    EXPECT_GT(covered, error.size() * 93 / 100) << most;
  }
  // Without a look there is but the spread.
  EXPECT_EQ(values(view, 8, 0.01, 0), values(view, 8, 0, 0));
  EXPECT_GT(mean_square(values(view, 64, 0, 0), none),
            1.5 * mean_square(values(view, 64, 1e-9, 0), none));
}

TEST(Adaptive, refuses_patterns_whose_first_samples_are_not_spread) {
  v1::FrameSettings frame = adaptive_frame(4, 4, 16, 0.1);
  for (const char* pattern : {"corner-grid", "centered-grid"}) {
    frame.set_pattern(pattern);
    EXPECT_THROW(make_tile_renderer({}, {}, frame, 1), Error);
  }
  for (const char* pattern : {"center", "owen-sobol", "independent", "blue-noise"}) {
    frame.set_pattern(pattern);
    EXPECT_NO_THROW(make_tile_renderer({}, {}, frame, 1));
  }
}

TEST(SampleSum, a_constant_keeps_its_bits_whatever_the_signs) {
  const Color c{0.1, 1.0 / 3, 7e9};
  SampleSum sum(1.17);
  for (const bool negative : {true, false, false, true, true}) {
    sum.add({c, negative});
    EXPECT_EQ(sum.mean(), c);
  }
}

TEST(SampleSum, signed_samples_have_weights_whose_sum_is_one) {
  SampleSum sum(1.2);
  sum.add({{1, 0, 0}, false});
  sum.add({{0, 1, 0}, true});
  sum.add({{0, 0, 1}, false});
  sum.add({{0, 0, 1}, false});
  // The mean of the signs is 1/2: weights (1 + 1.2 (s - 1/2)) / 4.
  EXPECT_NEAR(sum.mean().r, 1.6 / 4, 1e-12);
  EXPECT_NEAR(sum.mean().g, -0.8 / 4, 1e-12);
  EXPECT_NEAR(sum.mean().b, 3.2 / 4, 1e-12);
}

// A dark half-plane whose edge lies d pixels beside a pixel's centre: Mitchell's overshoot there.
TEST(SampleSum, negative_lobes_ring_beside_an_edge) {
  const double radius = 2;
  const auto f = [&](double x) { return filter_value(PixelFilter::mitchell, radius, x); };
  double below = 0, whole = 0;
  constexpr int kSteps = 40000;
  const double edge = 1.2;  // lit for x > 1.2, where the filter is below 0
  for (int i = 0; i < kSteps; ++i) {
    const double x = -radius + 2 * radius * (i + 0.5) / kSteps;
    whole += f(x);
    if (x > edge) below += f(x);
  }
  const Sampler sampler({.pattern = SamplePattern::owen_sobol,
                         .samples_per_pixel = 4096,
                         .filter = PixelFilter::mitchell,
                         .filter_radius = radius});
  SampleSum sum(sampler.filter_gain());
  for (uint32_t i = 0; i < 4096; ++i) {
    const auto [point, negative] = sampler.raster_sample(0, 0, i);
    sum.add({point.x - 0.5 > edge ? kWhite : kBlack, negative});
  }
  EXPECT_LT(below / whole, -0.01);
  EXPECT_NEAR(sum.mean().r, below / whole, 5e-4);
}

}  // namespace
}  // namespace tessera
