#include "front/picture_warnings.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

JobReport report(uint64_t hits, uint64_t instances, uint64_t hidden) {
  JobReport made;
  made.counters["hits"] = hits;
  made.build_counters = {{"instances", instances}, {"nodes_hidden", hidden}};
  made.tiles_total = made.tiles_done = 4;
  return made;
}

std::string only_warning(const JobReport& of) {
  const auto warnings = report_warnings(of);
  return warnings.size() == 1 ? warnings[0] : std::to_string(warnings.size()) + " warnings";
}

TEST(ReportWarnings, TellWhyNothingIsSeen) {
  EXPECT_TRUE(report_warnings(report(1, 1, 0)).empty());
  EXPECT_NE(only_warning(report(0, 3, 1)).find("--frame-all"), std::string::npos);
  EXPECT_NE(only_warning(report(0, 0, 2)).find("nodes that are not hidden"), std::string::npos);
  EXPECT_NE(only_warning(report(0, 0, 0)).find("nodes with shapes"), std::string::npos);
  const auto points = report_warnings(report(0, 3, 0), {.is_of_strokes = true});
  ASSERT_EQ(points.size(), 1u);
  EXPECT_NE(points[0].find("expected a larger --size or more --spp"), std::string::npos);
  EXPECT_TRUE(report_warnings(report(0, 3, 0), {.is_whole = false}).empty()) << "a crop of the sky";
  JobReport filled = report(0, 3, 0);  // whose tiles look past everything, and count nothing
  filled.counters.clear();
  EXPECT_NE(only_warning(filled).find("no ray meets a surface"), std::string::npos);
}

TEST(ReportWarnings, StrokesAreShapesThatCastNoShadow) {
  v1::Scene scene;
  EXPECT_FALSE(has_strokes_alone(scene)) << "nothing at all";
  v1::Node& points = *scene.add_nodes()->add_children();
  points.mutable_shape()->mutable_mesh();
  points.set_casts_no_shadow(true);
  EXPECT_TRUE(has_strokes_alone(scene));
  scene.add_objects()->add_nodes()->mutable_shape()->mutable_sphere();
  EXPECT_FALSE(has_strokes_alone(scene));
}

TEST(ReportWarnings, TellNothingOfWhatWasNotTracedNow) {
  JobReport kept = report(0, 1, 0);
  kept.tiles_restored = 4;
  EXPECT_TRUE(report_warnings(kept).empty());
  JobReport stopped = report(0, 1, 0);
  stopped.end = JobReport::End::interrupted;
  EXPECT_TRUE(report_warnings(stopped).empty());
}

TEST(ReportWarnings, TellWhatTheSceneLeavesOut) {
  JobReport made = report(9, 1, 0);
  made.build_counters["triangles_dropped"] = 2;
  EXPECT_EQ(only_warning(made), "2 triangles without an area: left out");
  EXPECT_EQ(report_warnings(made, {.scene = "a.obj"}),
            std::vector<std::string>{"a.obj: 2 triangles without an area: left out"});
  made.build_counters["triangles_dropped"] = 0;
  made.build_counters["nodes_dropped"] = 1;
  EXPECT_TRUE(report_warnings(made).empty()) << "which the scene's warnings name";
}

TEST(ReportWarnings, CountWhatHadNoColour) {
  JobReport odd = report(9, 1, 0);
  odd.counters["nan_samples"] = 2;
  EXPECT_TRUE(only_warning(odd).starts_with("2 samples had no colour"));
}

}  // namespace
}  // namespace tessera
