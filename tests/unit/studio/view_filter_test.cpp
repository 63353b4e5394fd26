#include "studio/view_filter.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "front/render_options.h"
#include "proto/wire/node_numbers.h"
#include "studio/full_frame.h"
#include "studio/scene_reading.h"
#include "studio/source_map.h"
#include "tests/source_folder.h"

namespace tessera {
namespace {

const std::string kFilteredFolder = source_folder() + "/scenes/samples";
constexpr const char* kFilteredFile = "filter.tessera";
/// Nodes 1 to 8, and those of the object: 9 and 10.
constexpr const char* kFiltered = R"(
nodes { name: "sun" light { directional { direction { y: -1 } } } }
nodes {
  name: "group"
  transform { steps { translate { x: 10 } } }
  children { name: "left" shape { sphere { center { x: -2 } } } }
  children { name: "right" shape { sphere { center { x: 2 } radius: 2 } } }
}
nodes { name: "place" instance_of: "pair" transform { steps { translate { y: 5 } } } }
nodes {
  name: "cut"
  shape { csg { operation: DIFFERENCE operands { shape { sphere {} } } operands { name: "hole" shape { box {} } } } }
}
objects {
  name: "pair"
  nodes { name: "one" shape { sphere {} } }
  nodes { name: "two" shape { sphere { center { z: 4 } } } }
}
)";

class ViewFilterTest : public testing::Test {
 protected:
  static std::shared_ptr<const SceneReading> read(const ViewFilter& filter) {
    OpenTexts texts;
    texts.emplace(kFilteredFile, Document(kFiltered));
    auto reading = std::make_shared<const SceneReading>(
        read_for_studio({.file = kFilteredFile, .revision = 1, .texts = texts, .filter = filter},
                        {.folder = kFilteredFolder, .assets = {}}));
    EXPECT_TRUE(reading->scene) << (reading->problems.empty() ? "" : reading->problems[0].message);
    return reading;
  }
  static std::vector<EntityRef> refs(const std::vector<std::string>& entities) {
    std::vector<EntityRef> list;
    for (const std::string& entity : entities) list.push_back({kFilteredFile, entity});
    return list;
  }
  static std::vector<uint32_t> hidden(const std::vector<std::string>& entities) {
    return read({.hidden = refs(entities)})->hidden;
  }
  static std::vector<uint32_t> others(const std::vector<std::string>& entities) {
    return read({.solo = refs(entities)})->hidden;
  }
};

using Numbers = std::vector<uint32_t>;

TEST_F(ViewFilterTest, HidesTheNodesThatAnEntityMade) {
  EXPECT_EQ(hidden({}), Numbers());
  EXPECT_EQ(hidden({"nodes[1]"}), Numbers{2});
  EXPECT_EQ(hidden({"nodes[1].children[1]", "nodes[0]"}), (Numbers{1, 4}));
  EXPECT_EQ(hidden({"nodes[7]"}), Numbers()) << "there is none";
}

TEST_F(ViewFilterTest, LeavesAloneWhatStandsInIt) {
  // The other child, the place of the pair and the pair, and what is cut; the light goes on.
  EXPECT_EQ(others({"nodes[1].children[0]"}), (Numbers{4, 5, 6, 9, 10}));
  EXPECT_EQ(others({"nodes[1]"}), (Numbers{5, 6, 9, 10}));
  EXPECT_EQ(others({"nodes[2]"}), (Numbers{2, 6})) << "with the object that is placed there";
  EXPECT_EQ(others({"objects[0].nodes[1]"}), (Numbers{2, 6, 9})) << "where it is placed";
  EXPECT_EQ(others({"nodes[9]"}), Numbers()) << "what is gone leaves nothing alone";
}

TEST_F(ViewFilterTest, TheJobLacksWhatIsHiddenAndTheSceneHasIt) {
  const auto reading = read({.hidden = refs({"nodes[1]"}), .solo = {}});
  const FullFrame frame{.reading = reading, .options = std::make_shared<const RenderOptions>()};
  std::vector<bool> of_job, of_scene;
  const JobSpec job = job_of(frame);
  for_each_node(job.scene, [&](const v1::Node& node) { of_job.push_back(node.hidden()); });
  for_each_node(reading->scene->loaded.scene,
                [&](const v1::Node& node) { of_scene.push_back(node.hidden()); });
  std::vector<bool> expected(10, false);
  EXPECT_EQ(of_scene, expected);
  expected[1] = true;
  EXPECT_EQ(of_job, expected);
}

TEST_F(ViewFilterTest, TellsWhereEntitiesAre) {
  const auto reading = read({});
  SourceMap map(reading, kFilteredFolder);
  const nlohmann::json told = centers_json(map);
  EXPECT_EQ(told["file"], kFilteredFile);
  std::map<std::string, nlohmann::json> centers, sizes, times;
  for (const auto& each : told["list"]) {
    centers[each[1]] = each[2];
    sizes[each[1]] = each[3];
    times[each[1]] = each[4];
  }
  EXPECT_EQ(centers["nodes[1].children[0]"], (nlohmann::json{8, 0, 0}));
  EXPECT_EQ(centers["nodes[1]"], (nlohmann::json{10.5, 0, 0})) << "from 7 to 14";
  EXPECT_EQ(sizes["nodes[1].children[0]"], (nlohmann::json{2, 2, 2}));
  EXPECT_EQ(sizes["nodes[1]"], (nlohmann::json{7, 4, 4}));
  EXPECT_TRUE(sizes["nodes[0]"].is_null());
  EXPECT_EQ(centers["nodes[2]"], (nlohmann::json{0, 5, 2}));
  EXPECT_EQ(centers["objects[0].nodes[1]"], (nlohmann::json{0, 5, 4}));
  EXPECT_TRUE(centers.contains("nodes[0]"));
  EXPECT_TRUE(centers["nodes[0]"].is_null()) << "light from far away";
  for (const auto& [entity, number] : times) EXPECT_EQ(number, 1) << entity;
}

/// How many things each entity of a text makes by itself.
std::map<std::string, size_t> things_of(const std::string& file, const std::string& text) {
  const Document document(text);
  const auto reading = std::make_shared<const SceneReading>(
      read_for_studio({.file = file, .revision = 1, .texts = {{file, document}}},
                      {.folder = kFilteredFolder, .assets = {}}));
  EXPECT_TRUE(reading->scene) << text;
  std::map<std::string, size_t> times;
  if (!reading->scene) return times;
  SourceMap map(reading, kFilteredFolder);
  const nlohmann::json told = centers_json(map);
  for (const auto& each : told["list"]) times[each[1]] = each[4];
  return times;
}

TEST(ViewFilter, TellsHowManyThingsATextMakes) {
  auto of = things_of("a.crt", R"(red = Material { color -> rgb(1, 0, 0) }
Settings { camera -> Camera { position -> vec3(0, 0, -5) pointing -> vec3(0, 0, 0) fov -> 40 } }
block = Macro(x) { Sphere { center -> vec3(x, 0, 0) radius -> 1 material -> red } }
Scene { block(1)  i = 0  while (i < 3) { block(i) i = i + 1 } }
)");
  EXPECT_EQ(of["block.Sphere[0]"], 4u) << "by two calls, one of them in a loop of three turns";
  of = things_of(
      "a.tessera",
      "objects { name: 'o' nodes { shape { sphere { } } } }\n"
      "nodes { instance_of: 'o' } nodes { instance_of: 'o' } nodes { shape { box { } } }");
  EXPECT_EQ(of["objects[0].nodes[0]"], 2u);
  EXPECT_EQ(of["nodes[0]"], 1u);
  of = things_of("a.x3d",
                 "<X3D version='4.0'><Scene><Shape DEF='s'><Sphere/></Shape>"
                 "<Transform translation='3 0 0'><Shape USE='s'/></Transform></Scene></X3D>");
  EXPECT_EQ(of["X3D[0].Scene[0].Shape[0]"], 2u);
}

}  // namespace
}  // namespace tessera
