#include "bench/error/report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <random>
#include <sstream>
#include <string>

#include "bench/error/log_plot.h"

namespace tessera {
namespace {

/// What an estimator with this standard deviation and slope would give, 1 ms a sample.
ErrorCurve synthetic(const std::string& method, double deviation, double slope, int seeds = 32) {
  ErrorCurve curve{"flat", method, {}, 0, {}};
  std::mt19937_64 random(7);
  for (int samples = 1; samples <= 1024; samples *= 2) {
    ErrorRow row;
    row.samples = samples;
    for (int seed = 0; seed < seeds; ++seed) {
      const double unit = static_cast<double>(random() >> 11) * 0x1p-53;
      const double mse = std::pow(deviation * std::pow(samples, slope), 2) * (.8 + .4 * unit);
      row.runs.push_back({samples * .001, samples * .004, .01, mse});
    }
    summarize(row);
    curve.rows.push_back(row);
  }
  fit_slope(curve);
  return curve;
}

SceneErrors two_methods() {
  SceneErrors scene{"flat & <odd>", "a test", "seconds", 16, 8, 1e-4, "closed form", {}, {}};
  scene.curves = {synthetic("owen", .5, -.75), synthetic("independent", .5, -.5)};
  for (ErrorCurve& curve : scene.curves) curve.scene = scene.scene;
  for (size_t i = 0; i < scene.curves[1].rows.size(); ++i)
    compare(scene.curves[1].rows[i], scene.curves[0].rows[i]);
  scene.peers.push_back({"peer \"x\"", .5, 64, {}, .01});
  return scene;
}

TEST(ErrorCurve, SlopesAreFoundWithTheirBands) {
  for (const double slope : {-.5, -.75, -1.5}) {
    const ErrorCurve curve = synthetic("m", .3, slope);
    EXPECT_NEAR(curve.slope, slope, .01);
    EXPECT_LT(curve.slope_band.low, slope);
    EXPECT_GT(curve.slope_band.high, slope);
    EXPECT_LT(curve.slope_band.high - curve.slope_band.low, .02);
  }
  ErrorCurve flattened = synthetic("m", .3, -.5);
  for (ErrorRow& row : flattened.rows) row.rmse = std::hypot(row.rmse, .05);
  fit_slope(flattened);
  EXPECT_GT(flattened.slope, -.45);
}

TEST(ErrorCurve, EfficiencyIsLevelAtSlopeOneHalfAndGainsAreRatios) {
  const ErrorCurve half = synthetic("m", .2, -.5);
  for (const ErrorRow& row : half.rows) {
    EXPECT_NEAR(row.efficiency, 1 / (.04 * .001), .06 / (.04 * .001));
    EXPECT_LE(row.rmse_band.low, row.rmse);
    EXPECT_GE(row.rmse_band.high, row.rmse);
  }
  ErrorRow twice = half.rows[3];
  for (ErrorRun& run : twice.runs) run.mse *= 2;
  summarize(twice);
  compare(twice, half.rows[3]);
  EXPECT_NEAR(*twice.gain, .5, 1e-9);
  EXPECT_NEAR(twice.gain_band.low, .5, 1e-9) << "the same seeds on both sides";
}

TEST(ErrorCurve, TimeToAnErrorIsReadOffTheLine) {
  const ErrorCurve curve = synthetic("m", .5, -.5, 400);
  // .5 / sqrt(n) = 1/64 at n = 1024.
  EXPECT_NEAR(*seconds_to(curve, 1. / 50), .625, .02);
  EXPECT_EQ(*seconds_to(curve, .9), .001);
  EXPECT_FALSE(seconds_to(curve, 1. / 256));
}

TEST(Bootstrap, CoversTheTruthAboutAsOftenAsItSays) {
  std::mt19937_64 random(3);
  int covered = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> values(32);
    for (double& value : values) value = static_cast<double>(random() >> 11) * 0x1p-53;
    const Band band = bootstrap_band(
        values.size(),
        [&values](std::span<const uint32_t> picks) {
          double sum = 0;
          for (const uint32_t i : picks) sum += values[i];
          return sum / static_cast<double>(picks.size());
        },
        1000);
    covered += band.low <= .5 && .5 <= band.high ? 1 : 0;
  }
  EXPECT_GE(covered, 178);  // 95 % less what 32 values cost it, and three standard deviations
  EXPECT_LE(covered, 199);
}

TEST(ErrorReport, JsonAndCsvHoldEveryRow) {
  const std::vector<SceneErrors> scenes{two_methods()};
  const auto json = nlohmann::json::parse(error_json(scenes));
  ASSERT_EQ(json["rows"].size(), 22u);
  for (const auto& row : json["rows"])
    for (const char* key : {"scene", "method", "samples", "seconds", "rmse", "bias"})
      EXPECT_TRUE(row.contains(key)) << key;
  EXPECT_EQ(json["rows"][0]["scene"], "flat & <odd>");
  EXPECT_EQ(json["peers"][0]["method"], "peer \"x\"");
  EXPECT_EQ(json["curves"].size(), 2u);
  const std::string csv = error_csv(scenes);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 23);
  EXPECT_TRUE(csv.starts_with("scene,method,samples,seconds,rmse,bias,"));
  EXPECT_NE(error_table(scenes[0]).find("slope of RMSE over samples -0.75"), std::string::npos);
  EXPECT_NE(error_summary(scenes).find("| flat & <odd> | owen |"), std::string::npos);
}

TEST(ErrorPlot, IsXmlWithACurveAMethodAndTheGuides) {
  const SceneErrors scene = two_methods();
  for (const std::string& svg : {error_svg(scene), efficiency_svg(scene)}) {
    pugi::xml_document document;
    ASSERT_TRUE(document.load_string(svg.c_str())) << svg;
    const auto root = document.child("svg");
    EXPECT_EQ(root.select_nodes("polyline").size(), 2u);
    EXPECT_NE(svg.find("flat &amp; &lt;odd&gt;"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
    // Each curve has its 11 points, from left to right.
    double last = 0;
    std::istringstream points(root.child("polyline").attribute("points").value());
    int count = 0;
    for (std::string point; points >> point; ++count) {
      EXPECT_GT(std::stod(point), last);
      last = std::stod(point);
    }
    EXPECT_EQ(count, 11);
  }
  const std::string svg = error_svg(scene);
  for (const char* guide : {">-0.5<", ">-0.75<", ">-1.5<", ">error of the reference<"})
    EXPECT_NE(svg.find(guide), std::string::npos) << guide;
}

TEST(ErrorPlot, BearsWhatHasNoLogarithm) {
  LogPlot plot;
  EXPECT_TRUE(pugi::xml_document().load_string(to_svg(plot).c_str()));
  plot.series = {{"zero", {{0, 0, {}}, {1, 0, {}}, {NAN, 1, {}}, {1, INFINITY, {}}}},
                 {"one", {{1, 1, {0, 0}}}}};
  const std::string svg = to_svg(plot);
  EXPECT_TRUE(pugi::xml_document().load_string(svg.c_str()));
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

}  // namespace
}  // namespace tessera
