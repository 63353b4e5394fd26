#include "front/render_options.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "front/output_settings.h"
#include "tests/error_of.h"

namespace tessera {
namespace {

template <typename Call>
ExitCode code_of(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error.code();
  }
  return ExitCode::done;
}

TEST(RenderOptions, ThePictureIsNamedAfterTheScene) {
  RenderOptions options;
  options.scene = "some/where/view.one.obj";
  ASSERT_EQ(picture_paths(options).size(), 1u);
  EXPECT_EQ(picture_paths(options)[0], "view.one.png");
}

TEST(RenderOptions, FramesAreNumberedBeforeTheEnding) {
  EXPECT_EQ(numbered_path("a/b.c.png", 7), "a/b.c.0007.png");
  EXPECT_EQ(numbered_path("b.exr", 12345), "b.12345.exr");
}

TEST(RenderOptions, DefaultsThenSceneThenOptions) {
  v1::Scene scene;
  v1::FrameSettings frame = frame_settings({}, scene, std::nullopt);
  EXPECT_EQ(frame.width(), 960u);
  EXPECT_EQ(frame.height(), 540u);
  EXPECT_EQ(frame.samples_per_pixel(), 1u);
  EXPECT_EQ(frame.accelerator(), "bvh");
  EXPECT_EQ(frame.integrator(), "auto");

  scene.mutable_settings()->set_width(100);
  scene.mutable_settings()->mutable_sampling()->set_samples_per_pixel(9);
  scene.mutable_settings()->mutable_sampling()->set_seed(3);
  scene.mutable_settings()->set_accelerator("linear");
  scene.mutable_settings()->set_time(1.5);
  frame = frame_settings({}, scene, std::nullopt);
  EXPECT_EQ(frame.width(), 100u);
  EXPECT_EQ(frame.samples_per_pixel(), 9u);
  EXPECT_EQ(frame.seed(), 3u);
  EXPECT_EQ(frame.accelerator(), "linear");
  EXPECT_EQ(frame.time(), 1.5);

  RenderOptions options;
  options.size = FrameSize{8, 6};
  options.samples_per_pixel = 2;
  options.seed = 5;
  options.accelerator = "bvh";
  options.time = 2;
  frame = frame_settings(options, scene, 7);
  EXPECT_EQ(frame.width(), 8u);
  EXPECT_EQ(frame.samples_per_pixel(), 2u);
  EXPECT_EQ(frame.seed(), 5u);
  EXPECT_EQ(frame.accelerator(), "bvh");
  EXPECT_EQ(frame.time(), 2);
}

// A scene's count and its grid are for all pixels alike.
TEST(RenderOptions, TargetErrorsTakeNoCountThatTheSceneMeantForAllPixels) {
  v1::Scene scene;
  v1::Sampling& sampling = *scene.mutable_settings()->mutable_sampling();
  sampling.set_samples_per_pixel(4);
  sampling.set_pattern(v1::Sampling::CORNER_GRID);
  RenderOptions options;
  options.target_error = 0.01;
  v1::FrameSettings frame = frame_settings(options, scene, std::nullopt);
  EXPECT_EQ(frame.samples_per_pixel(), 1024u);
  EXPECT_EQ(frame.pattern(), "owen-sobol");

  options.samples_per_pixel = 64;
  EXPECT_EQ(frame_settings(options, scene, std::nullopt).samples_per_pixel(), 64u);
  options.samples_per_pixel.reset();
  sampling.set_pattern(v1::Sampling::INDEPENDENT);
  EXPECT_EQ(frame_settings(options, scene, std::nullopt).pattern(), "independent");
  sampling.set_target_error(0.5);
  frame = frame_settings(options, scene, std::nullopt);
  EXPECT_EQ(frame.samples_per_pixel(), 4u) << "of a scene with a target of its own: the most";
  EXPECT_EQ(frame.target_error(), 0.01);
}

TEST(RenderOptions, SamplingIsTheDefaultThenTheScenesThenAsAsked) {
  v1::Scene scene;
  RenderOptions options;
  v1::FrameSettings frame = frame_settings(options, scene, std::nullopt);
  EXPECT_EQ(frame.pattern(), "center");
  EXPECT_EQ(frame.pixel_filter(), "box");
  EXPECT_EQ(frame.filter_radius(), 0.5);
  EXPECT_EQ(frame.target_error(), 0);

  options.target_error = 0.25;
  frame = frame_settings(options, scene, std::nullopt);
  EXPECT_EQ(frame.samples_per_pixel(), 1024u);
  EXPECT_EQ(frame.min_samples(), 16u);
  EXPECT_EQ(frame.pattern(), "owen-sobol");

  v1::Sampling& sampling = *scene.mutable_settings()->mutable_sampling();
  sampling.set_filter(v1::Sampling::MITCHELL);
  sampling.set_filter_radius(1.75);
  sampling.set_pattern(v1::Sampling::BLUE_NOISE);
  sampling.set_target_error(0.5);
  sampling.set_min_samples(64);
  frame = frame_settings({}, scene, std::nullopt);
  EXPECT_EQ(frame.pattern(), "blue-noise");
  EXPECT_EQ(frame.pixel_filter(), "mitchell");
  EXPECT_EQ(frame.filter_radius(), 1.75);
  EXPECT_EQ(frame.target_error(), 0.5);
  EXPECT_EQ(frame.min_samples(), 64u);

  // A filter by name is not given the radius of another.
  options.filter = "tent";
  options.target_error = 0;
  options.pattern = "independent";
  options.samples_per_pixel = 9;
  frame = frame_settings(options, scene, std::nullopt);
  EXPECT_EQ(frame.filter_radius(), 1);
  EXPECT_EQ(frame.target_error(), 0);
  EXPECT_EQ(frame.pattern(), "independent");
  options.filter_radius = 3;
  EXPECT_EQ(frame_settings(options, scene, std::nullopt).filter_radius(), 3);
}

TEST(RenderOptions, TheLeastSamplesAreForATargetError) {
  v1::Scene scene;
  RenderOptions options;
  options.min_samples = 4;
  EXPECT_EQ(code_of([&] { frame_settings(options, scene, std::nullopt); }), ExitCode::bad_usage);
  options.target_error = 0;
  EXPECT_EQ(code_of([&] { frame_settings(options, scene, std::nullopt); }), ExitCode::bad_usage);
  options.target_error = .1;
  EXPECT_EQ(frame_settings(options, scene, std::nullopt).min_samples(), 4u);
  options.min_samples = 1024;
  EXPECT_EQ(frame_settings(options, scene, std::nullopt).min_samples(), 1024u);
  options.min_samples = 1025;
  EXPECT_EQ(code_of([&] { frame_settings(options, scene, std::nullopt); }), ExitCode::bad_usage);
  options.samples_per_pixel = 2000;
  EXPECT_EQ(frame_settings(options, scene, std::nullopt).min_samples(), 1025u);
  options.samples_per_pixel.reset();
  options.min_samples = 4;
  options.target_error.reset();
  scene.mutable_settings()->mutable_sampling()->set_target_error(.1);
  EXPECT_EQ(frame_settings(options, scene, std::nullopt).min_samples(), 4u);
}

TEST(RenderOptions, AFrameHasItsTime) {
  v1::Scene scene;
  EXPECT_EQ(frame_settings({}, scene, 12).time(), 0.5);
  scene.mutable_settings()->mutable_frames()->set_per_second(10);
  EXPECT_EQ(frame_settings({}, scene, 12).time(), 1.2);
  scene.mutable_settings()->mutable_frames()->set_per_second(0);
  EXPECT_EQ(code_of([&] { frame_settings({}, scene, std::nullopt); }), ExitCode::bad_scene);
}

TEST(RenderOptions, SettingsOutOfRangeAreTheScenesFault) {
  v1::Scene scene;
  scene.mutable_settings()->set_width(0);
  EXPECT_EQ(code_of([&] { frame_settings({}, scene, std::nullopt); }), ExitCode::bad_scene);
  scene.mutable_settings()->set_width(65536);
  scene.mutable_settings()->set_height(65536);
  EXPECT_EQ(code_of([&] { frame_settings({}, scene, std::nullopt); }), ExitCode::bad_scene);
}

TEST(RenderOptions, ACameraIsInTheScene) {
  v1::Scene scene;
  scene.add_cameras()->set_name("front");
  RenderOptions options;
  options.camera = "front";
  EXPECT_EQ(frame_settings(options, scene, std::nullopt).camera(), "front");
  options.camera = "fornt";
  EXPECT_EQ(code_of([&] { frame_settings(options, scene, std::nullopt); }), ExitCode::bad_usage);
  scene.mutable_cameras(0)->set_description("from the door");
  for (const char* other : {"1", "from the door"}) {
    options.camera = other;
    EXPECT_EQ(frame_settings(options, scene, std::nullopt).camera(), other);
  }
  options.camera = "2";
  EXPECT_EQ(code_of([&] { frame_settings(options, scene, std::nullopt); }), ExitCode::bad_usage);
}

TEST(RenderOptions, NamesThatTheSceneGetsWrongAreItsFault) {
  v1::Scene scene;
  RenderOptions options;
  scene.mutable_settings()->set_accelerator("bvhh");
  EXPECT_EQ(code_of([&] { frame_settings(options, scene, std::nullopt); }), ExitCode::bad_scene);
  options.accelerator = "nonuniform-octree";
  EXPECT_EQ(frame_settings(options, scene, std::nullopt).accelerator(), "nonuniform-octree");
  scene.mutable_settings()->mutable_integrator()->set_kind("pathh");
  EXPECT_EQ(code_of([&] { frame_settings(options, scene, std::nullopt); }), ExitCode::bad_scene);
  options.integrator = "depth";
  EXPECT_EQ(frame_settings(options, scene, std::nullopt).integrator(), "depth");
}

TEST(RenderOptions, WhatTheSceneIsNotToBlameForIsTheOptionsFault) {
  v1::Scene scene;
  RenderOptions options;
  options.pattern = "centered-grid";
  options.samples_per_pixel = 10;
  const auto blamed = [&] {
    return usage_error_of([&] { frame_settings(options, scene, std::nullopt); });
  };
  EXPECT_TRUE(blamed().starts_with("--spp 10 --pattern centered-grid: ")) << blamed();
  options.samples_per_pixel = 9;
  EXPECT_EQ(frame_settings(options, scene, std::nullopt).pattern(), "centered-grid");
  options.target_error = .01;
  EXPECT_NE(blamed().find("--target-error 0.01"), std::string::npos) << blamed();
  options = {};
  options.samples_per_pixel = 3;
  scene.mutable_settings()->mutable_sampling()->set_pattern(v1::Sampling::CORNER_GRID);
  EXPECT_TRUE(blamed().starts_with("--spp 3: ")) << blamed();
  scene.mutable_settings()->mutable_sampling()->set_samples_per_pixel(5);
  options = {};
  EXPECT_EQ(code_of([&] { frame_settings(options, scene, std::nullopt); }), ExitCode::bad_scene);
}

TEST(RenderOptions, ACropLiesInTheFrame) {
  v1::FrameSettings frame;
  frame.set_width(20);
  frame.set_height(10);
  RenderOptions options;
  EXPECT_EQ(crop_window(options, frame), (PixelRect{0, 0, 20, 10}));
  options.crop = PixelRect{5, 5, 20, 10};
  EXPECT_EQ(crop_window(options, frame), *options.crop);
  options.crop = PixelRect{5, 5, 21, 10};
  EXPECT_EQ(code_of([&] { crop_window(options, frame); }), ExitCode::bad_usage);
}

TEST(OutputSettings, AreTheScenes) {
  v1::Output output;
  EXPECT_EQ(output_settings("a.tessera", output), OutputSettings{});
  output.set_tone_map(v1::Output::FILMIC);
  output.set_transfer(v1::Output::GAMMA);
  output.set_gamma(1.8);
  output.set_exposure(-1);
  output.set_quantization(v1::Output::TRUNCATE);
  for (const double number : {1.0, 2.0, 3.0}) output.add_response(number);
  const OutputSettings settings = output_settings("a.tessera", output);
  EXPECT_EQ(settings.tone_curve, ToneCurve::filmic);
  EXPECT_EQ(settings.transfer, TransferCurve::gamma);
  EXPECT_EQ(settings.gamma, 1.8);
  EXPECT_EQ(settings.exposure, -1);
  EXPECT_EQ(settings.quantization, Quantization::truncate);
  EXPECT_TRUE(settings.has_response);
  EXPECT_EQ(settings.response[2], 3);
  output.add_response(4);
  EXPECT_EQ(code_of([&] { output_settings("a.tessera", output); }), ExitCode::bad_scene);
}

TEST(OutputSettings, OptionsAreLaidOverTheScene) {
  v1::Output output;
  output.set_tone_map(v1::Output::FILMIC);
  output.set_transfer(v1::Output::DISPLAY);
  output.set_exposure(1);
  EXPECT_EQ(output_settings("a.tessera", output).tone_curve, ToneCurve::filmic);
  OutputSettings laid_over = output_settings("a.tessera", output, {.exposure = -2});
  EXPECT_EQ(laid_over.tone_curve, ToneCurve::filmic);
  EXPECT_EQ(laid_over.transfer, TransferCurve::display);
  EXPECT_EQ(laid_over.exposure, -2);
  laid_over =
      output_settings("a.tessera", output, {.tone_map = "reinhard-luminance", .gamma = 1.8});
  EXPECT_EQ(laid_over.tone_curve, ToneCurve::reinhard_luminance);
  EXPECT_EQ(laid_over.transfer, TransferCurve::gamma);
  EXPECT_EQ(laid_over.gamma, 1.8);
  EXPECT_EQ(output_settings("a.tessera", output, {.transfer = "gamma", .gamma = 3}).gamma, 3);
  EXPECT_EQ(
      code_of([&] { output_settings("a.tessera", output, {.transfer = "srgb", .gamma = 3}); }),
      ExitCode::bad_usage);
  EXPECT_EQ(output_settings("a.tessera", output).bits, 8);
  EXPECT_EQ(output_settings("a.tessera", output, {.bits = 16}).bits, 16);
  const ToneCurve curves[] = {ToneCurve::clamp, ToneCurve::reinhard, ToneCurve::reinhard_luminance,
                              ToneCurve::filmic, ToneCurve::linear};
  for (size_t i = 0; i < tone_map_names().size(); ++i) {
    EXPECT_EQ(output_settings("a.tessera", output, {.tone_map = tone_map_names()[i]}).tone_curve,
              curves[i]);
  }
}

}  // namespace
}  // namespace tessera
