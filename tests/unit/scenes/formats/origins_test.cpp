#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "proto/wire/node_numbers.h"
#include "scenes/formats/read_scene.h"
#include "tests/unit/scenes/formats/read_scene_fixture.h"

namespace tessera {
namespace {

class Origins : public testing::ReadScene {
 protected:
  void put(const std::string& name, const std::string& text) {
    texts_[name] = text;
    write(name, text);
  }
  LoadedScene load(const std::string& name, bool origins = true) const {
    ReadOptions options;
    options.origins = origins;
    return read_scene((folder_ / name).string(), options);
  }
  std::vector<std::string> told(const LoadedScene& loaded) const;

  std::map<std::string, std::string> texts_;
};

/// Of each node what its origin says, from the innermost: "a.crt:WORD" with the text from its
/// offset on, up to a blank; or "a.tessera:PATH".
std::vector<std::string> Origins::told(const LoadedScene& loaded) const {
  std::vector<std::string> lines;
  uint32_t number = 0;
  for_each_node(loaded.scene, [&](const v1::Node&) {
    std::string line;
    for (uint32_t at = loaded.origins.of_node(++number); at != 0;
         at = loaded.origins.at(at).above) {
      const Origin& origin = loaded.origins.at(at);
      const std::string name =
          std::filesystem::path(loaded.origins.files()[origin.file]).filename().string();
      if (!line.empty()) line += " < ";
      line += name + ":";
      if (origin.offset == Origin::kNowhere) {
        line += origin.path;
      } else {
        const std::string rest = texts_.at(name).substr(origin.offset);
        line += rest.substr(0, rest.find_first_of(" \n({"));
      }
      if (origin.turn > 0) line += "#" + std::to_string(origin.turn);
    }
    lines.push_back(line);
  });
  return lines;
}

TEST_F(Origins, of_a_script_lead_through_turns_and_calls) {
  put("a.crt", R"(
Settings { camera -> Camera { position -> vec3(0,0,-5) pointing -> vec3(0,0,0) fov -> .8 } }
mat = Material { color -> rgb(1, 0, 0) }
ball = Macro(x) { Sphere { center -> vec3(x,0,0) radius -> .5 material -> mat } }
row = Macro() {
  i = 0
  while (i < 2) { ball(i) <translate vec3(0,1,0)>  i = i + 1 }
}
Scene {
  row()
  Difference { Box { cornerA -> vec3(0,0,0) cornerB -> vec3(1,1,1) material -> mat } ball(9) }
}
)");
  EXPECT_EQ(
      told(load("a.crt")),
      (std::vector<std::string>{"a.crt:Sphere < a.crt:ball < a.crt:while#1 < a.crt:row",
                                "a.crt:Sphere < a.crt:ball < a.crt:while#2 < a.crt:row",
                                "a.crt:Difference", "a.crt:Box", "a.crt:Sphere < a.crt:ball"}));
}

TEST_F(Origins, of_x3d_lead_through_prototypes_and_other_files) {
  put("a.x3dv", R"(#X3D V3.3 utf8
PROTO Ball [ ] { Transform { children Shape { geometry Sphere { } } } }
Ball { }
Inline { url "b.tessera" }
)");
  put("b.tessera", "nodes { shape { sphere {} } }");
  EXPECT_EQ(told(load("a.x3dv")),
            (std::vector<std::string>{"a.x3dv:Transform < a.x3dv:Ball", "a.x3dv:Shape",
                                      "a.x3dv:Inline", "b.tessera:nodes[0]", ""}));
}

TEST_F(Origins, of_message_formats_are_paths_and_lead_through_includes) {
  put("main.tessera", R"(nodes { shape { csg { operands { shape { sphere {} } } operands {} } }
    children { } } includes { file: "part.tessera" } objects { name: "a" nodes { } })");
  put("part.tessera", "nodes { shape { sphere {} } } objects { name: 'b' nodes { children { } } }");
  const LoadedScene loaded = load("main.tessera");
  EXPECT_EQ(
      told(loaded),
      (std::vector<std::string>{
          "main.tessera:nodes[0]", "main.tessera:nodes[0].shape.csg.operands[0]",
          "main.tessera:nodes[0].shape.csg.operands[1]", "main.tessera:nodes[0].children[0]",
          "main.tessera:includes[0]", "main.tessera:objects[0].nodes[0]", "part.tessera:nodes[0]",
          "part.tessera:objects[0].nodes[0]", "part.tessera:objects[0].nodes[0].children[0]"}));
}

TEST_F(Origins, change_nothing_of_the_scene_and_keep_their_numbers_when_text_moves) {
  put("a.tessera", "nodes { shape { sphere {} } }\nnodes { children { } }");
  put("b.tessera",
      "# A note.\n\nnodes { shape { sphere {} } }   # of a ball\nnodes { children { } }");
  const LoadedScene plain = load("a.tessera", false), marked = load("a.tessera"),
                    noted = load("b.tessera");
  EXPECT_EQ(plain.scene.SerializeAsString(), marked.scene.SerializeAsString());
  EXPECT_EQ(plain.scene.SerializeAsString(), noted.scene.SerializeAsString());
  EXPECT_EQ(plain.origins.size(), 0u);
  for (uint32_t node = 1; node <= 3; ++node) {
    EXPECT_EQ(marked.origins.at(marked.origins.of_node(node)).path,
              noted.origins.at(noted.origins.of_node(node)).path);
  }
}

}  // namespace
}  // namespace tessera
