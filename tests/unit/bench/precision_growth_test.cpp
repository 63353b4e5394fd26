#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "bench/growth.h"
#include "bench/precision.h"

namespace tessera {
namespace {

TEST(BenchPrecision, RobustTestsAreNeverWrongAndPlainOnesAreKnownToBe) {
  const auto rows = bench_precision({.rays = 5000, .rounds = 1});
  std::map<std::string, PrecisionBenchRow> far;
  for (const PrecisionBenchRow& r : rows) {
    if (r.distance == 1e4) far[r.shape + " " + r.method] = r;
    if (r.method != "robust") continue;
    EXPECT_EQ(r.leaks, 0) << r.shape << r.distance;
    EXPECT_EQ(r.self_hits, 0) << r.shape << r.distance;
    EXPECT_LE(r.max_error, 1e-11 * r.distance) << r.shape << r.distance;
  }
  EXPECT_EQ(far.at("triangle robust").wrong, 0);
  EXPECT_EQ(far.at("torus robust").wrong, 0);
  EXPECT_GT(far.at("triangle float-moller-trumbore").leaks, 1000);
  EXPECT_EQ(far.at("triangle float-woop").leaks, 0);
  EXPECT_GT(far.at("sphere float-textbook").wrong, 10000);
  EXPECT_GT(far.at("sphere double-textbook").max_error,
            100 * far.at("sphere double-gems").max_error);
  EXPECT_GT(far.at("torus double-quartic").wrong, 10000);
  EXPECT_EQ(far.at("torus double-quartic-moved").wrong, 0);
  const auto json = nlohmann::json::parse(precision_json(rows));
  EXPECT_EQ(json["rows"].size(), rows.size());
  EXPECT_EQ(json["rows"][0]["method"], "float-moller-trumbore");
}

TEST(BenchGrowth, WorkARayGrowsLikeTheLogarithm) {
  GrowthBenchOptions options;
  options.most = 100'000;
  options.most_of_octrees = 1'000;
  options.rays = 1000;
  const auto rows = bench_growth(options);
  std::map<size_t, double> visits;
  for (const GrowthBenchRow& r : rows)
    if (r.scene == "soup" && r.accelerator == "bvh") visits[r.triangles] = r.node_visits_per_ray;
  ASSERT_EQ(visits.size(), 3u);
  EXPECT_GT(visits[100'000], visits[1'000]);
  EXPECT_LT(visits[100'000], 6 * visits[1'000]);
  EXPECT_EQ(rows.size(), 2 * (3 + 2u));
  EXPECT_EQ(nlohmann::json::parse(growth_json(rows))["rows"].size(), rows.size());
  const std::string svg = growth_svg(rows);
  EXPECT_NE(svg.find("bvh, soup"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

}  // namespace
}  // namespace tessera
