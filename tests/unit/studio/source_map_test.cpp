#include "studio/source_map.h"

#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "base/file.h"
#include "proto/wire/node_numbers.h"
#include "tests/source_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

const std::string kSamples = source_folder() + "/scenes/samples";

std::shared_ptr<const SceneReading> read(const std::string& file) {
  return std::make_shared<const SceneReading>(read_for_studio(
      {.file = file, .revision = 1, .texts = {}}, {.folder = kSamples, .assets = {}}));
}

/// The text that a link selects.
std::string cut(const SourceLink& link) {
  const Document document(read_input_file(kSamples + "/" + link.file, Document::kMostBytes));
  const std::string text = document.text();
  const size_t begin = document.text_byte_of(document.offset_of(*link.begin));
  return text.substr(begin, document.text_byte_of(document.offset_of(*link.end)) - begin);
}

/// The node that the text of a field of nodes describes.
v1::Node parse(const std::string& text) {
  using google::protobuf::TextFormat;
  v1::Node parent;
  v1::Scene scene;
  v1::Csg csg;
  if (text.starts_with("nodes") && TextFormat::ParseFromString(text, &scene)) return scene.nodes(0);
  if (text.starts_with("children") && TextFormat::ParseFromString(text, &parent))
    return parent.children(0);
  if (text.starts_with("operands") && TextFormat::ParseFromString(text, &csg))
    return csg.operands(0);
  ADD_FAILURE() << "no node: " << text;
  return {};
}

/// What the text of a script calls the shape.
const char* crt_name(const v1::Shape& shape) {
  switch (shape.kind_case()) {
    case v1::Shape::kSphere:
      return "Sphere";
    case v1::Shape::kBox:
      return "Box";
    case v1::Shape::kPlane:
      return "Plane";
    case v1::Shape::kHalfPlane:
      return "HalfPlane";
    case v1::Shape::kDisc:
      return "Disc";
    case v1::Shape::kCylinder:
      return "Cylinder";
    case v1::Shape::kCone:
      return "Cone";
    case v1::Shape::kTorus:
      return "Torus";
    case v1::Shape::kMesh:
      return "Triangle";
    default:
      return "";
  }
}

TEST(SourceMap, the_text_of_every_node_of_every_sample_is_that_node) {
  int messages = 0, shapes = 0, others = 0;
  for (const auto& entry : fs::directory_iterator(kSamples)) {
    const std::string file = entry.path().filename().string(), ending = entry.path().extension();
    if (ending != ".tessera" && ending != ".crt" && ending != ".x3d" && ending != ".x3dv") continue;
    const auto reading = read(file);
    ASSERT_TRUE(reading->scene) << file;
    SourceMap map(reading, kSamples);
    std::vector<const v1::Node*> nodes;
    for_each_node(reading->scene->loaded.scene,
                  [&](const v1::Node& node) { nodes.push_back(&node); });
    for (size_t i = 0; i < nodes.size(); ++i) {
      const v1::Node& node = *nodes[i];
      const SourceChain chain = map.chain({.nodes = {static_cast<uint32_t>(i + 1)}});
      if (chain.links.empty()) continue;
      const SourceLink& link = chain.links[chain.at];
      if (!link.begin) continue;
      const std::string text = cut(link);
      if (link.file.ends_with(".tessera") && link.kind == "node") {
        ++messages;
        EXPECT_EQ(parse(text).SerializeAsString(), node.SerializeAsString()) << file << text;
      } else if (link.file.ends_with(".crt") && node.has_shape() && !node.shape().has_csg()) {
        ++shapes;
        EXPECT_NE(text.find(crt_name(node.shape())), std::string::npos) << file << '\n' << text;
      } else if (!link.file.ends_with(".crt") && node.has_shape()) {
        ++others;
        EXPECT_NE(text.find("Shape"), std::string::npos) << file << '\n' << text;
      }
    }
  }
  EXPECT_GT(messages, 100);
  EXPECT_GT(shapes, 100);
  EXPECT_GT(others, 50);
}

TEST(SourceMap, notes_and_blanks_change_nothing_but_places) {
  const auto reading = read("chess.crt");
  ASSERT_TRUE(reading->scene);
  OpenTexts texts;
  texts["chess.crt"] =
      Document("-- A note.\n\n" + read_input_file(kSamples + "/chess.crt", Document::kMostBytes));
  const auto moved = std::make_shared<const SceneReading>(read_for_studio(
      {.file = "chess.crt", .revision = 2, .texts = texts}, {.folder = kSamples, .assets = {}}));
  ASSERT_TRUE(moved->scene);
  EXPECT_EQ(moved->scene->digest, reading->scene->digest);
  SourceMap before(reading, kSamples), after(moved, kSamples);
  for (uint32_t node = 1; node < 40; ++node) {
    const SourceChain was = before.chain({.nodes = {node}}), is = after.chain({.nodes = {node}});
    ASSERT_EQ(was.links.size(), is.links.size());
    for (size_t i = 0; i < was.links.size(); ++i) {
      EXPECT_EQ(was.links[i].entity, is.links[i].entity);
      if (!was.links[i].begin || was.links[i].file != "chess.crt") continue;
      EXPECT_EQ(was.links[i].begin->line + 2, is.links[i].begin->line);
    }
  }
}

}  // namespace
}  // namespace tessera
