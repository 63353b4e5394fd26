#include "scenes/formats/scene_summary.h"

#include <gtest/gtest.h>

#include <map>

namespace tessera {
namespace {

TEST(SceneSummary, TellsUsedUnusedAndUndefinedNamesApart) {
  v1::Scene scene;
  scene.add_materials()->set_name("red");
  scene.add_materials()->set_name("blue");
  scene.add_objects()->set_name("thing");
  v1::Node& node = *scene.add_nodes();
  node.mutable_shape()->mutable_sphere();
  node.mutable_shape()->add_materials("blu");
  scene.add_nodes()->set_instance_of("thing");
  scene.add_nodes()->mutable_light()->mutable_point();
  const SceneSummary summary = summarize(scene, {});
  EXPECT_EQ(summary.unused, (std::vector<std::string>{"material 'red'", "material 'blue'"}));
  EXPECT_EQ(summary.undefined, (std::vector<std::string>{"material 'blu'; did you mean 'blue'?"}));
  std::map<std::string, uint64_t> counts;
  for (const auto& [what, count] : summary.counts) counts[what] = count;
  EXPECT_EQ(counts["shapes, sphere"], 1u);
  EXPECT_EQ(counts["lights, point"], 1u);
  EXPECT_EQ(counts["instances"], 1u);
  EXPECT_EQ(counts["nodes"], 3u);
}

}  // namespace
}  // namespace tessera
