#include "renderer/render/tile_renderer.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <future>
#include <thread>
#include <vector>

#include "base/error.h"
#include "renderer/film/aov.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

// X3D's default camera looks at a sphere of its default material, with a headlight.
constexpr char kSphere[] = R"(
  cameras { world_from_camera { steps { translate { z: 10 } } }
            headlight { directional { direction { z: -1 } } } }
  background { solid { r: .25 g: .5 b: 1 } }
  nodes { shape { sphere {} } })";

// Glass, a mirror, transparent and flat things, three lights and a ground that never ends.
constexpr char kMixed[] = R"(
  settings { sampling { pattern: OWEN_SOBOL } integrator { ambient { r: .1 g: .1 b: .1 } } }
  cameras { world_from_camera { steps { look_at { eye { x: 1 y: 2 z: 6 } target { y: .5 } } } } }
  background { gradient { sky { r: .2 g: .4 b: 1 } ground { r: .5 g: .5 b: .4 } } glow: .25 }
  materials { name: 'glass' classic { transparency { value: .9 } refractive_index: 1.5
              reflectivity { value { r: .1 g: .1 b: .1 } } absorption { r: 1 g: .2 b: .1 } } }
  materials { name: 'mirror' classic { reflectivity { value { r: .8 g: .7 b: .6 } }
              specular { value { r: 1 g: 1 b: 1 } } grain: .2 } }
  materials { name: 'veil' classic { transparency { value: .5 } transmission: STRAIGHT } }
  nodes { light { directional { direction { x: -1 y: -2 z: -1 } } } }
  nodes { light { point { position { x: 2 y: 3 } } intensity: 8 attenuation { quadratic: 1 } } }
  nodes { light { spot { position { y: 4 } direction { y: -1 } beam_width: 10 cut_off: 40 } } }
  nodes { transform { steps { translate { y: 1 } } } shape { materials: 'glass' sphere {} } }
  nodes { shape { materials: 'mirror' box { min { x: -3 z: -2 } max { x: -1.5 y: 2 z: -1 } } } }
  nodes { shape { materials: 'veil' box { min { x: 1.2 z: -1 } max { x: 1.8 y: 1.5 z: 1 } } } }
  nodes { shape { plane {} } })";

TEST(TileRenderer, shows_a_lit_sphere_before_its_background) {
  const TilePixels tile = render_text(kSphere, 33, 33);
  const size_t middle = 3 * (16 * 33 + 16);
  EXPECT_FLOAT_EQ(tile.values[middle], 0.8f);
  EXPECT_FLOAT_EQ(tile.values[middle + 2], 0.8f);
  EXPECT_EQ(tile.values[0], 0.25f);
  EXPECT_EQ(tile.values[1], 0.5f);
  EXPECT_EQ(tile.values[2], 1.0f);
  EXPECT_EQ(tile.counters.at("samples"), 33u * 33u);
  EXPECT_EQ(tile.counters.at("nan_samples"), 0u);
}

TEST(TileRenderer, builds_only_the_meshes_that_rays_come_near) {
  const auto mesh = [](double x, double y) {
    return fmt::format(
        "nodes {{ transform {{ steps {{ translate {{ x: {} y: {} }} }} }} shape {{ mesh "
        "{{ inline_positions: [-1,-1,0, 1,-1,0, 1,1,0, -1,1,0] "
        "inline_triangles: [0,1,2, 0,2,3, 0,1,3] }} }} }} ",
        x, y);
  };
  const auto render = [&](const std::string& meshes) {
    return render_text(std::string(kSphere) + meshes, 33, 33);
  };
  const TilePixels one = render(mesh(2.5, 0));
  EXPECT_FALSE(one.counters.contains("meshes_built_when_hit"));
  const TilePixels three = render(mesh(2.5, 0) + mesh(500, 1) + mesh(-500, 1));
  EXPECT_EQ(three.counters.at("meshes_built_when_hit"), 1u);
  EXPECT_EQ(three.values, one.values);
}

TEST(TileRenderer, pixels_do_not_depend_on_how_the_frame_is_cut) {
  constexpr int kWidth = 23, kHeight = 17;
  constexpr uint32_t kSamples = 3;
  v1::FrameSettings frame = frame_of(kWidth, kHeight);
  frame.set_samples_per_pixel(kSamples);
  const auto renderer = make_tile_renderer(parse_scene(kMixed), {}, frame, 1);
  const PixelRect whole{0, 0, kWidth, kHeight};
  const TilePixels expected = render_rect(*renderer, whole, kSamples);
  EXPECT_GT(expected.counters.at("rays_refraction"), 0u);
  EXPECT_GT(expected.counters.at("rays_reflection"), 0u);
  EXPECT_GT(expected.counters.at("rays_shadow"), 0u);

  for (const int side : {1, 5, 16}) {
    CounterMap sums;
    for (int y = 0; y < kHeight; y += side) {
      for (int x = 0; x < kWidth; x += side) {
        const PixelRect rect{x, y, std::min(x + side, kWidth), std::min(y + side, kHeight)};
        const TilePixels tile = render_rect(*renderer, rect, kSamples);
        for (const auto& [name, value] : tile.counters) sums[name] += value;
        for (int row = 0; row < rect.height(); ++row) {
          for (int i = 0; i < 3 * rect.width(); ++i) {
            const auto from = static_cast<size_t>(3 * rect.width() * row + i);
            const auto to = static_cast<size_t>(3 * (kWidth * (y + row) + x) + i);
            ASSERT_EQ(tile.values[from], expected.values[to]) << side << " " << x << " " << y;
          }
        }
      }
    }
    for (const auto& [name, value] : expected.counters) {
      if (name != "tiles_background") {
        EXPECT_EQ(sums[name], value) << name;
      }
    }
  }
}

// What stopped a light's last shadow ray is asked first, which must not show in a picture of the
// work.
TEST(TileRenderer, cost_does_not_depend_on_how_the_frame_is_cut) {
  std::string text = R"(cameras { world_from_camera { steps { look_at { eye { y: 3 z: 12 } } } } }
    nodes { light { directional { direction { x: -1 y: -2 z: -1 } } } } nodes { shape { plane { offset: -2 } } } )";
  for (int i = 0; i < 40; ++i)
    text += fmt::format("nodes {{ shape {{ sphere {{ center {{ x: {} z: {} }} radius: .6 }} }} }} ",
                        i % 8 - 3.5, i / 8 - 2);
  v1::FrameSettings frame = frame_of(24, 16);
  frame.set_accelerator("bvh");
  const auto picture = make_tile_renderer(parse_scene(text), {}, frame, 1);
  EXPECT_GT(render_rect(*picture, {0, 0, 24, 16}).counters.at("occluders_met_again"), 0u);
  frame.set_integrator("cost");
  const auto cost = make_tile_renderer(parse_scene(text), {}, frame, 1);
  const TilePixels whole = render_rect(*cost, {0, 0, 24, 16});
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 24; ++x)
      EXPECT_EQ(render_rect(*cost, {x, y, x + 1, y + 1}).values[0],
                whole.values[static_cast<size_t>(3 * (24 * y + x))]);
}

// A tree that is not built yet is not visited by who passes it by.
TEST(TileRenderer, cost_does_not_depend_on_which_trees_were_needed_before) {
  std::string text = "cameras { world_from_camera { steps { translate { z: 10 } } } } ";
  for (const double x : {-2.0, 2.0}) {
    text += fmt::format(
        "nodes {{ transform {{ steps {{ translate {{ x: {} }} }} }} shape {{ mesh "
        "{{ inline_positions: [-1,-1,0, 1,-1,0, 1,1,0, -1,1,0] "
        "inline_triangles: [0,1,2, 0,2,3, 0,1,3] }} }} }} ",
        x);
  }
  constexpr int kSide = 16;
  v1::FrameSettings frame = frame_of(kSide, kSide);
  frame.set_accelerator("bvh");
  frame.set_integrator("cost");
  const auto row_by_row = [&](int first, int step) {
    const auto renderer = make_tile_renderer(parse_scene(text), {}, frame, 1);
    std::vector<float> cost(kSide * kSide);
    for (int i = 0, at = first; i < kSide * kSide; ++i, at += step) {
      const int x = at / kSide, y = at % kSide;
      cost[static_cast<size_t>(at)] = render_rect(*renderer, {x, y, x + 1, y + 1}).values[0];
    }
    return cost;
  };
  EXPECT_EQ(row_by_row(0, 1), row_by_row(kSide * kSide - 1, -1));
}

TEST(TileRenderer, cost_of_embree_is_not_shown) {
  v1::FrameSettings frame = frame_of(2, 2);
  frame.set_accelerator("embree");
  frame.set_integrator("cost");
  EXPECT_THROW(make_tile_renderer(parse_scene(kSphere), {}, frame, 1), Error);
}

TEST(TileRenderer, a_sample_alone_is_the_sample_among_others) {
  v1::FrameSettings frame = frame_of(4, 4);
  frame.set_samples_per_pixel(2);
  const auto renderer = make_tile_renderer(parse_scene(kMixed), {}, frame, 1);
  const PixelRect rect{0, 0, 4, 4};
  const TilePixels both = render_rect(*renderer, rect, 2);
  const TilePixels first = render_rect(*renderer, rect, 1, 0);
  const TilePixels second = render_rect(*renderer, rect, 1, 1);
  for (size_t i = 0; i < both.values.size(); ++i) {
    EXPECT_NEAR(both.values[i], (first.values[i] + second.values[i]) / 2, 1e-6f);
  }
  EXPECT_NE(first.values, second.values);
}

TEST(TileRenderer, traces_samples_that_coincide_once) {
  const auto render = [](uint32_t samples, const std::string& more) {
    v1::FrameSettings frame = frame_of(8, 8);
    frame.set_samples_per_pixel(samples);
    const auto renderer =
        make_tile_renderer(parse_scene(std::string(kSphere) + more), {}, frame, 1);
    return render_rect(*renderer, {0, 0, 8, 8}, samples);
  };
  const std::string center = "settings { sampling { pattern: CENTER } }";
  const TilePixels one = render(1, center), many = render(7, center);
  EXPECT_EQ(many.values, one.values);
  EXPECT_EQ(many.counters.at("rays_primary"), one.counters.at("rays_primary"));
  EXPECT_EQ(many.counters.at("samples_skipped"), 6u * 64);
  EXPECT_EQ(render(7, "").counters.at("samples_skipped"), 0u);
}

TEST(TileRenderer, the_seed_moves_samples) {
  v1::FrameSettings frame = frame_of(4, 4);
  frame.set_samples_per_pixel(2);
  const v1::Scene scene = parse_scene(kMixed);
  const auto render = [&] {
    return render_rect(*make_tile_renderer(scene, {}, frame, 1), {0, 0, 4, 4}, 2).values;
  };
  const auto zero = render();
  EXPECT_EQ(render(), zero);
  frame.set_seed(1);
  EXPECT_NE(render(), zero);
}

TEST(TileRenderer, threads_of_the_build_change_nothing) {
  const v1::Scene scene = parse_scene(kMixed);
  const auto frame = frame_of(16, 16);
  const PixelRect rect{0, 0, 16, 16};
  EXPECT_EQ(render_rect(*make_tile_renderer(scene, {}, frame, 1), rect).values,
            render_rect(*make_tile_renderer(scene, {}, frame, 4), rect).values);
}

TEST(TileRenderer, may_be_called_from_many_threads) {
  const auto renderer = make_tile_renderer(parse_scene(kMixed), {}, frame_of(16, 16), 2);
  const PixelRect rect{0, 0, 16, 16};
  const auto expected = render_rect(*renderer, rect).values;
  std::vector<std::future<std::vector<float>>> others;
  for (int i = 0; i < 4; ++i) {
    others.push_back(
        std::async(std::launch::async, [&] { return render_rect(*renderer, rect).values; }));
  }
  for (auto& other : others) EXPECT_EQ(other.get(), expected);
}

TEST(TileRenderer, grain_darkens_by_up_to_its_size) {
  const std::string rough =
      "materials { name: 'm' classic { emission { value { r: 1 g: 1 b: 1 } } diffuse { value {} } "
      "grain: .5 } } nodes { shape { materials: 'm' plane { normal { z: 1 } } } }";
  const auto values = render_text(rough, 16, 16).values;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  EXPECT_GT(*low, .85f - 1e-6f);
  EXPECT_LT(*low, .86f);
  EXPECT_GT(*high, .99f);
  EXPECT_LE(*high, 1.0f);
  EXPECT_EQ(render_text(rough, 16, 16).values, values);
}

TEST(TileRenderer, stops_when_cancelled_and_tells_its_pixels) {
  const auto renderer = make_tile_renderer(parse_scene(kSphere), {}, frame_of(8, 8), 1);
  TileProgress progress;
  EXPECT_TRUE(renderer->render({{0, 0, 8, 8}, 0, 1}, progress));
  EXPECT_EQ(progress.work_done, 64u);
  progress.cancelled = true;
  EXPECT_FALSE(renderer->render({{0, 0, 8, 8}, 0, 1}, progress));
}

TEST(TileRenderer, tells_within_a_pixel_that_it_gets_on) {
  const auto work_of = [](const std::string& text, uint32_t samples,
                          const std::function<void(v1::FrameSettings&)>& ask) {
    v1::FrameSettings frame = frame_of(1, 1);
    frame.set_samples_per_pixel(samples);
    ask(frame);
    TileProgress progress;
    const auto renderer = make_tile_renderer(parse_scene(text), {}, frame, 1);
    EXPECT_TRUE(renderer->render({{0, 0, 1, 1}, 0, samples}, progress));
    return progress.work_done.load();
  };
  constexpr char kLens[] = R"(
    cameras { world_from_camera { steps { translate { z: 10 } } }
              lens { radius_x: .1 radius_y: .1 focal_distance: 9 samples: 1024 } }
    nodes { shape { sphere {} } })";
  const auto nothing = [](v1::FrameSettings&) {};
  EXPECT_EQ(work_of(kMixed, 4096, nothing), 64u) << "a batch each";
  const auto view = [](v1::FrameSettings& frame) { frame.set_integrator("normals"); };
  EXPECT_EQ(work_of(kMixed, 4096, view), 4u) << "a thousand samples each";
  EXPECT_EQ(work_of(kLens, 8, nothing), 8u);
  const auto albedo = [](v1::FrameSettings& frame) {
    frame.set_aovs(AovSet().with(Aov::albedo).bits());
  };
  EXPECT_EQ(work_of(kMixed, 4096, albedo), 64u + 4);
  const auto error = [](v1::FrameSettings& frame) { frame.set_target_error(1e-12); };
  EXPECT_GE(work_of(kMixed, 1 << 15, error), 32u);
}

TEST(TileRenderer, stops_within_a_pixel) {
  v1::FrameSettings frame = frame_of(1, 1);
  constexpr uint32_t kSamples = 1 << 24;
  frame.set_samples_per_pixel(1 << 20);
  const auto renderer = make_tile_renderer(parse_scene(kMixed), {}, frame, 1);
  TileProgress progress;
  auto tile = std::async(std::launch::async, [&] {
    return renderer->render({{0, 0, 1, 1}, 0, kSamples}, progress);
  });
  while (progress.work_done == 0) std::this_thread::yield();
  progress.cancelled = true;
  EXPECT_FALSE(tile.get());
  EXPECT_LT(progress.work_done, kSamples / 1024);
}

// Looking past everything must give what tracing gives: an endless plane far behind the camera
// makes every pixel traced without being seen.
TEST(TileRenderer, pixels_past_everything_keep_their_bits) {
  constexpr char kCamera[] = "cameras { world_from_camera { steps { translate { z: 10 } } } }";
  constexpr char kBehind[] = "nodes { shape { plane { normal { z: 1 } offset: 1000 } } }";
  for (const char* background :
       {"background { solid { r: .1 g: .7 b: .3 } }",
        "background { gradient { sky { r: 1 } ground { b: 1 } } }",
        "background { gradient { sky { r: 1 } ground { b: 1 } model: ABSOLUTE_Y } glow: .5 }"}) {
    const std::string lights = "nodes { light { directional { direction { x: 1 y: 1 } } } }";
    const std::string text = "settings { sampling { samples_per_pixel: 3 filter: TENT } }" +
                             std::string(kCamera) + background + lights +
                             "nodes { shape { sphere {} } }";
    const TilePixels skipped = render_text(text, 40, 30);
    const TilePixels traced = render_text(text + kBehind, 40, 30);
    EXPECT_EQ(skipped.values, traced.values) << background;
    EXPECT_GT(skipped.counters.at("rays_background_skipped"), 3u * 600u);
    EXPECT_EQ(traced.counters.at("rays_background_skipped"), 0u);
    EXPECT_EQ(skipped.counters.at("rays_background_skipped") + skipped.counters.at("rays_primary"),
              3u * 40u * 30u);
  }
}

TEST(TileRenderer, answers_tiles_of_background_without_tracing) {
  const auto renderer = make_tile_renderer(parse_scene(kSphere), {}, frame_of(64, 64), 1);
  const TilePixels corner = render_rect(*renderer, {0, 0, 8, 8});
  EXPECT_EQ(corner.counters.at("tiles_background"), 1u);
  EXPECT_EQ(corner.counters.at("primitive_tests"), 0u);
  EXPECT_EQ(render_rect(*renderer, {28, 28, 36, 36}).counters.at("tiles_background"), 0u);
}

// What a coordinator fills whole tiles with.
TEST(TileRenderer, tells_what_every_pixel_past_everything_is) {
  constexpr uint32_t kSamples = 3;
  const std::string settings = "settings { sampling { pattern: OWEN_SOBOL filter: TENT } }";
  const auto renderer =
      make_tile_renderer(parse_scene(settings + kSphere), {}, frame_of(64, 64), 1);
  const auto unseen = renderer->unseen(kSamples);
  ASSERT_TRUE(unseen);
  const PixelRect& seen = unseen->seen;
  ASSERT_FALSE(seen.empty());
  int outside = 0;
  for (int y = 0; y < 64; y += 3) {
    for (int x = 0; x < 64; x += 3) {
      if (seen.contains({x, y, x + 1, y + 1})) continue;
      ++outside;
      const TilePixels pixel = render_rect(*renderer, {x, y, x + 1, y + 1}, kSamples);
      ASSERT_EQ(pixel.values, unseen->one_pixel.values);
      ASSERT_EQ(pixel.counters, unseen->one_pixel.counters);
    }
  }
  EXPECT_GT(outside, 100);
  // A background that differs from pixel to pixel is traced, or looked up.
  EXPECT_FALSE(
      make_tile_renderer(parse_scene(kMixed), {}, frame_of(8, 8), 1)->unseen(kSamples).has_value());
}

TEST(TileRenderer, an_empty_scene_is_black) {
  EXPECT_EQ(render_text("", 2, 1).values, std::vector<float>(6, 0.0f));
}

TEST(TileRenderer, numbers_that_overflow_are_counted_and_black) {
  const TilePixels tile = render_text(R"(
    materials { name: 'm' classic { emission { value { r: 1e308 } } diffuse { value { } } } }
    nodes { light { ambient_intensity: 1e308 color { r: 1e308 } directional { direction { z: -1 } } } }
    nodes { shape { materials: 'm' box { min { x: -9 y: -9 z: 0 } max { x: 9 y: 9 z: 1 } } } })",
                                      1, 1);
  EXPECT_EQ(tile.counters.at("nan_samples"), 1u);
  EXPECT_EQ(tile.values, std::vector<float>(3, 0.0f));
}

TEST(TileRenderer, facing_mirrors_end) {
  const std::string room = R"(
    materials { name: 'm' classic { reflectivity { value { r: 1 g: 1 b: 1 } }
                diffuse { value {} } emission { value { r: 1 } } } }
    cameras { world_from_camera {} }
    background { solid { g: 1 } }
    nodes { shape { materials: 'm' plane { normal { z: 1 } offset: -1 } } }
    nodes { shape { materials: 'm' plane { normal { z: 1 } offset: 1 } } } )";
  const auto depth = [&](int max_depth, const char* more = "") {
    return render_pixel(room + "settings { integrator { max_depth: " + std::to_string(max_depth) +
                        more + " } }");
  };
  EXPECT_EQ(depth(0), (std::vector<float>{1, 0, 0}));
  EXPECT_EQ(depth(100), (std::vector<float>{101, 0, 0}));
  EXPECT_EQ(depth(3, " background_at_max_depth: true"), (std::vector<float>{4, 1, 0}));
}

TEST(TileRenderer, refuses_an_unknown_integrator_with_the_nearest_name) {
  v1::FrameSettings frame = frame_of(1, 1);
  frame.set_integrator("whited");
  try {
    make_tile_renderer({}, {}, frame, 1);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::bad_scene);
    EXPECT_NE(std::string(error.what()).find("did you mean 'whitted'"), std::string::npos);
  }
}

TEST(TileRenderer, views_show_normals_and_depth) {
  const auto view = [&](const char* kind) {
    return render_pixel(std::string(kSphere) + "settings { integrator { kind: '" + kind + "' } }");
  };
  EXPECT_EQ(view("normals"), (std::vector<float>{0.5f, 0.5f, 1.0f}));
  EXPECT_EQ(view("depth"), (std::vector<float>{9, 9, 9}));
}

TEST(TileRenderer, wireframe_shows_the_edges_of_triangles) {
  constexpr char kSquare[] = R"(
    cameras { world_from_camera { steps { translate { z: 10 } } } }
    nodes { shape { mesh { inline_positions: [-9, -9, 0, 9, -9, 0, 9, 9, 0, -9, 9, 0]
                           inline_triangles: [0, 1, 2, 0, 2, 3] } } }
    settings { integrator { kind: 'wireframe' } })";
  const auto renderer = make_tile_renderer(parse_scene(kSquare), {}, frame_of(9, 9), 1);
  TileProgress progress;
  const auto tile = renderer->render({{0, 0, 9, 9}, 0, 1}, progress);
  ASSERT_TRUE(tile);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 9; ++x) {
      // The diagonal goes up to the right.
      const float level = tile->values[static_cast<size_t>(3 * (9 * y + x))];
      EXPECT_EQ(level < 0.1f, x + y == 8) << x << ' ' << y << ": " << level;
    }
  }
  const std::string ball = std::string(kSphere) + "settings { integrator { kind: 'wireframe' } }";
  EXPECT_NEAR(render_pixel(ball)[0], 0.6, 1e-6) << "which has no triangles";
}

}  // namespace
}  // namespace tessera
