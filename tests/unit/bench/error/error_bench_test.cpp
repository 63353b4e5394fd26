#include "bench/error_bench.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "bench/error/closed_forms.h"
#include "bench/error_render.h"
#include "proto/wire/scene_codec.h"
#include "renderer/scene/read_settings.h"
#include "tests/error_of.h"
#include "tests/source_folder.h"
#include "tests/temporary_folder.h"

namespace tessera {
namespace {

AccuracyScene edge(uint32_t size) {
  AccuracyScene scene = make_accuracy_scene("edge");
  scene.loaded.scene.mutable_settings()->set_width(size);
  scene.loaded.scene.mutable_settings()->set_height(size);
  return scene;
}

ErrorBenchOptions tiny(std::vector<std::string> methods) {
  ErrorBenchOptions out;
  for (const std::string& method : methods) out.methods.push_back(parse_error_method(method));
  out.most_samples = 64;
  out.seeds = 12;
  out.threads = 2;
  out.reference_samples = 64;
  return out;
}

TEST(BenchError, EdgesConvergeAsTheoryHasIt) {
  const SceneErrors found = bench_error(edge(32), tiny({"owen", "independent+octree", "tent"}));
  ASSERT_EQ(found.curves.size(), 3u);
  EXPECT_EQ(found.reference, "closed form");
  const ErrorCurve& owen = found.curves[0];
  const ErrorCurve& independent = found.curves[1];
  ASSERT_EQ(owen.rows.size(), 7u);
  EXPECT_LT(owen.slope, -.65);
  EXPECT_GT(owen.slope, -.85);
  EXPECT_NEAR(independent.slope, -.5, .06);
  for (const ErrorCurve* curve : {&owen, &independent}) {
    EXPECT_EQ(curve->rows.front().samples, 1);
    for (const ErrorRow& row : curve->rows) {
      EXPECT_EQ(row.seeds, 12);
      EXPECT_LT(std::abs(row.bias_sigmas), 4.5) << curve->method << row.samples;
      EXPECT_GT(row.seconds, 0);
      EXPECT_EQ(row.not_finite, 0u);
      EXPECT_GT(row.error.flip, 0);
    }
  }
  EXPECT_GT(independent.rows.back().rmse, 1.5 * owen.rows.back().rmse);
  // The tent looks farther than a pixel's square: it has a reference of its own, rendered.
  EXPECT_GT(found.reference_error, 0);
}

TEST(BenchError, FindsAPlantedBias) {
  ErrorBenchOptions options = tiny({"owen"});
  options.least_samples = 16;
  Picture wrong = *closed_form("edge", 32, 32);
  for (float& value : wrong.values) value += .02F;
  options.given_reference = {wrong};
  const SceneErrors found = bench_error(edge(32), options);
  for (const ErrorRow& row : found.curves[0].rows) {
    EXPECT_NEAR(row.bias, .02, .002) << row.samples;
    EXPECT_GT(row.bias_sigmas, 6) << row.samples;
  }
}

TEST(BenchError, CurvesStopAboveTheReferencesError) {
  const SceneErrors found = bench_error(edge(32), [] {
    ErrorBenchOptions options = tiny({"tent"});
    options.most_samples = 1024;
    return options;
  }());
  EXPECT_GT(found.reference_error, 0);
  ASSERT_FALSE(found.curves[0].rows.empty());
  EXPECT_LT(found.curves[0].rows.back().samples, 64);
  for (const ErrorRow& row : found.curves[0].rows) EXPECT_GT(row.rmse, 5 * found.reference_error);
}

TEST(BenchError, ReferencesAreRenderedOnceAndKept) {
  const TemporaryFolder folder;
  const v1::Scene scene = with_method(edge(16).loaded.scene, {"reference"});
  uint32_t samples = 16;
  const Reference made = converged_reference(scene, {}, samples, 64, folder.path().string(), 1);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
  for (const auto& file : std::filesystem::directory_iterator(folder.path()))
    std::filesystem::last_write_time(file, std::filesystem::file_time_type{});
  samples = 8;
  const Reference kept = converged_reference(scene, {}, samples, 64, folder.path().string(), 1);
  EXPECT_EQ(samples, 16u) << "the better ones that were there";
  EXPECT_EQ(kept.first.values, made.first.values);
  EXPECT_EQ(kept.second.values, made.second.values);
  EXPECT_NE(kept.first.values, kept.second.values);
  for (const auto& file : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_EQ(std::filesystem::last_write_time(file), std::filesystem::file_time_type{});
    std::filesystem::resize_file(file, 100);
  }
  // Torn files are made anew, and another scene has others.
  const Reference again = converged_reference(scene, {}, samples, 64, folder.path().string(), 1);
  EXPECT_EQ(again.first.values, made.first.values);
  v1::Scene other = scene;
  other.mutable_settings()->mutable_sampling()->set_filter(v1::Sampling::TENT);
  converged_reference(other, {}, samples, 64, folder.path().string(), 1);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 4);
}

TEST(BenchError, PeersAreHeldAgainstTheSameTruth) {
  ErrorBenchOptions options = tiny({"owen"});
  options.most_samples = 2;
  Picture peer = *closed_form("edge", 32, 32);
  for (float& value : peer.values) value *= 1.1F;
  options.peers = {{"other", 2.5, 64, peer}};
  const SceneErrors found = bench_error(edge(32), options);
  ASSERT_EQ(found.peers.size(), 1u);
  EXPECT_NEAR(found.peers[0].error.mean_ratio, 1.1, 1e-5);
  EXPECT_GT(found.peers[0].error.rmse, .05);
  EXPECT_NEAR(found.peers[0].rmse_scaled, 0, 1e-6);
  options.peers[0].picture = *closed_form("edge", 16, 16);
  EXPECT_EQ(usage_error_of([&] { bench_error(edge(32), options); }),
            "--peer other: its picture has 16x16 pixels; expected 32x32, or --size");
}

TEST(BenchError, PeersAreNotBlamedForTheReferencesNoise) {
  const Picture truth = *closed_form("edge", 32, 32);
  Picture first = truth, second = truth;
  constexpr float kNoise[] = {.1F, -.1F, 0, 0};
  for (size_t i = 0; i < truth.values.size(); ++i) {
    first.values[i] += kNoise[i % 4];
    second.values[i] += kNoise[(i + 2) % 4];
  }
  ErrorBenchOptions options = tiny({"owen"});
  options.most_samples = 2;
  options.given_reference = {first, second};
  options.peers = {{"exact", 2.5, 64, truth}};
  const PeerMark peer = bench_error(edge(32), options).peers.at(0);
  EXPECT_NEAR(peer.error.rmse, .05, 1e-3);
  EXPECT_LT(peer.rmse_scaled, .005);
}

TEST(BenchError, MethodsAreWordsInAnyOrder) {
  const ErrorMethod method = parse_error_method("tent+octree+independent+whitted");
  EXPECT_EQ(method.integrator, "whitted");
  EXPECT_EQ(method.accelerator, "octree");
  EXPECT_EQ(*method.pattern, v1::Sampling::INDEPENDENT);
  EXPECT_EQ(*method.filter, v1::Sampling::TENT);
  EXPECT_FALSE(method.is_adaptive);
  EXPECT_EQ(*parse_error_method("owen-sobol").pattern, v1::Sampling::OWEN_SOBOL);
  EXPECT_EQ(*parse_error_method("blackman-harris").filter, v1::Sampling::BLACKMAN_HARRIS);
  EXPECT_NE(usage_error_of([] { parse_error_method("pattern-default"); }), "no error");
  EXPECT_TRUE(parse_error_method("adaptive").is_adaptive);
  EXPECT_NE(usage_error_of([] { parse_error_method("own"); }).find("did you mean 'owen'?"),
            std::string::npos);
  EXPECT_EQ(usage_error_of([] { parse_error_method("owen+center"); }),
            "'owen+center'; expected one word of each kind at most");
  usage_error_of([] { parse_error_method("owen+"); });
  EXPECT_NE(usage_error_of([] { parse_error_method(""); }), "no error");
}

TEST(AccuracyScenes, AreWholeAndBuildAsFarAsTheirIntegratorIsThere) {
  int closed = 0;
  for (const std::string& name : accuracy_scene_names()) {
    const AccuracyScene scene = make_accuracy_scene(name);
    const v1::Settings& settings = scene.loaded.scene.settings();
    EXPECT_FALSE(scene.about.empty()) << name;
    EXPECT_GT(scene.loaded.scene.cameras_size(), 0) << name;
    closed += closed_form(name, 8, 8).has_value() ? 1 : 0;
    const auto& kinds = integrator_names();
    if (std::find(kinds.begin(), kinds.end(), settings.integrator().kind()) == kinds.end())
      continue;
    v1::Scene small = scene.loaded.scene;
    small.mutable_settings()->set_width(8);
    small.mutable_settings()->set_height(8);
    const ErrorPicture picture = render_shot(small, scene.loaded.blobs, {"owen"}, {2, 1, 0}, 1);
    EXPECT_EQ(picture.not_finite, 0u) << name;
  }
  EXPECT_GE(accuracy_scene_names().size(), 10u);
  EXPECT_EQ(closed, 5);
  EXPECT_NE(usage_error_of([] { make_accuracy_scene("cornel"); }).find("did you mean 'cornell'?"),
            std::string::npos);
}

/// Those whose integrator this program has; the tolerance is in standard errors of their bias.
TEST(AccuracyScenes, ClosedFormsAreWhatTheRendererFinds) {
  for (const char* name : {"edge", "furnace", "sphere-light", "rectangle-light", "sky-wall"}) {
    AccuracyScene scene = make_accuracy_scene(name);
    v1::Settings& settings = *scene.loaded.scene.mutable_settings();
    const auto& kinds = integrator_names();
    if (std::find(kinds.begin(), kinds.end(), settings.integrator().kind()) == kinds.end())
      continue;
    settings.set_width(24);
    settings.set_height(24);
    ErrorBenchOptions options = tiny({"owen", "independent"});
    options.least_samples = 16;
    options.most_samples = 16;
    for (const ErrorCurve& curve : bench_error(scene, options).curves) {
      EXPECT_LT(std::abs(curve.rows.at(0).bias_sigmas), 4.5) << name << ' ' << curve.method;
      EXPECT_NEAR(curve.rows.at(0).error.mean_ratio, 1, .01) << name << ' ' << curve.method;
    }
  }
}

TEST(AccuracyScenes, TheCornellBoxIsTheSample) {
  const std::string path = source_folder() + "/scenes/samples/cornell.tessera";
  v1::Scene sample = read_scene_file(path, SceneEncoding::text).scene;
  v1::Scene ours = make_accuracy_scene("cornell").loaded.scene;
  EXPECT_EQ(ours.settings().width(), 128u);
  ours.mutable_settings()->set_width(512);
  ours.mutable_settings()->set_height(512);
  EXPECT_EQ(serialize_scene(sample), serialize_scene(ours));
}

TEST(ClosedForms, AgreeWithTheirLimits) {
  // Half of the edge's picture is white, but for the offset of its line.
  const Picture picture = *closed_form("edge", 64, 64);
  double sum = 0;
  for (const float value : picture.values) sum += double{value} / (3 * 64 * 64);
  EXPECT_NEAR(sum, .5 - (.8 * .0123 + .6 * .0217) / .8 / 2, 1e-6);
  // Far from the wall all of the sky is seen: albedo times radiance.
  const Picture wall = *closed_form("sky-wall", 64, 64);
  EXPECT_NEAR(wall.values[0], .8 * .5 * (1 + .0656), .01);
  EXPECT_NEAR(wall.values[3 * 63], .8 * .5 * (1 + 2.03 / std::hypot(2.03, 1)), .002);
  // Nearest to the round lamp, far from it.
  const Picture lamp = *closed_form("sphere-light", 64, 64);
  EXPECT_GT(lamp.values[size_t{3} * (38 * 64 + 63)], 4 * lamp.values[size_t{3} * (38 * 64)]);
  EXPECT_FALSE(closed_form("cornell", 64, 64));
  EXPECT_FALSE(closed_form("edge", 64, 32)) << "its pixels would be no squares";
}

}  // namespace
}  // namespace tessera
